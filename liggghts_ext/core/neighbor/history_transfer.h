#pragma once

#include <vector>

#include "core/neighbor/pair_list.h"

namespace millscale::neighbor {

/// An index of no particle.
constexpr int absent = -1;

/// Global ids of the particles of a list; a ghost has the tag of the particle it copies.
using Tags = std::vector<int>;

/// Restore the contact history between i and the particle with this tag: `sign` times
/// `displacement`. Return true if the pair is listed under i, overlaps, and is no pair with a
/// ghost. A contact with a ghost has a second entry, under the particle that the ghost copies.
inline bool restore_history(PairList& list, const Particles& particles, const int* tags, int i,
                            int tag, const double* displacement, double sign)
{
  bool only_entry = false;
  for (int entry = list.first[i]; entry < list.first[i] + list.partners[i]; ++entry) {
    const int j = list.other[entry];
    if (tags[j] != tag || !overlap(particles, i, j)) continue;
    list.touching[entry] = 1;
    for (int d = 0; d < 3; ++d) list.displacement[3 * entry + d] = sign * displacement[d];
    only_entry = j < particles.nlocal;
  }
  return only_entry;
}

/// Transfer the contact histories from the old list to the new one, whose particles may be numbered
/// differently. Either particle may own the pair in the new list; both own an entry once one of
/// them has left through a periodic boundary of the same rank. new_index: index in the new list of
/// each local particle of the old list, or `absent`.
inline void transfer_history(const PairList& old, const Tags& old_tags,
                             const std::vector<int>& new_index, PairList& list,
                             const Particles& particles, const int* tags)
{
  for (int entry = 0; entry < old.entries; ++entry) {
    if (!old.touching[entry]) continue;
    const int a = old.own[entry], b = old.other[entry];
    const int i = new_index[a], j = b < old.nlocal() ? new_index[b] : absent;
    const double* displacement = &old.displacement[3 * static_cast<std::size_t>(entry)];
    if (i != absent && restore_history(list, particles, tags, i, old_tags[b], displacement, 1.0))
      continue;
    if (j != absent) restore_history(list, particles, tags, j, old_tags[a], displacement, -1.0);
  }
}

/// Call visit(particle, tag of the partner, displacement, sign) for each contact of each marked
/// local particle. The contact history of the particle is sign times displacement.
template <class Visit>
void for_each_history_of(const std::vector<char>& marked, const PairList& list, const Tags& tags,
                         const Visit& visit)
{
  for (int entry = 0; entry < list.entries; ++entry) {
    if (!list.touching[entry]) continue;
    const int a = list.own[entry], b = list.other[entry];
    const double* displacement = &list.displacement[3 * static_cast<std::size_t>(entry)];
    if (marked[a]) visit(a, tags[b], displacement, 1.0);
    if (b < list.nlocal() && marked[b]) visit(b, tags[a], displacement, -1.0);
  }
}

}  // namespace millscale::neighbor
