#pragma once

#include <emmintrin.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "core/neighbor/pair_list.h"

namespace millscale::neighbor {

/// An index of no particle.
constexpr int absent = -1;

/// Global ids of the particles of a list; a ghost has the tag of the particle it copies.
using Tags = std::vector<int>;

/// What a contact remembers, on i.
struct Remembered {
  const double* displacement;     ///< tangential [m]
  energy::CarriedWork carried{};  ///< none if it is not known
};

/// Return the work of a contact. sign: -1 to exchange i and j.
inline energy::CarriedWork work_on(const Remembered& known, double sign)
{
  if (sign > 0.0) return known.carried;
  return {energy::seen_from_j(known.carried.work), known.carried.available};
}

/// Set what a contact remembers. sign: -1 if it is known on j.
inline void remember(PairList& list, int entry, const Remembered& known, double sign)
{
  for (int d = 0; d < 3; ++d)
    list.displacement[3 * static_cast<std::size_t>(entry) + d] = sign * known.displacement[d];
  if (list.records_work) list.carried.push_back(work_on(known, sign));
  list.touching[entry] = list.records_work ? static_cast<int>(list.carried.size()) : 1;
}

/// Bring the work that has been carried to a new list into the order of the list.
inline void order_work(PairList& list)
{
  if (!list.records_work) return;
  const energy::WorkColumns work = list.work.columns();
  for_each_contact(list, [&](int entry, int number) {
    const energy::CarriedWork& carried = list.carried[list.touching[entry] - 1];
    work.set(number, carried.work);
    list.available[entry] = carried.available;
    list.touching[entry] = 1;
  });
  list.carried.clear();
}

/// Return what the contact of an entry remembers, by its number in the list.
inline Remembered remembered(const PairList& list, int entry, int number)
{
  Remembered known{&list.displacement[3 * static_cast<std::size_t>(entry)]};
  if (list.records_work && !list.available.empty())
    known.carried = {list.work.get(number), list.available[entry]};
  return known;
}

/// Restore the contact history between i and the particle with this tag. Return true if the pair is
/// listed under i, overlaps, and is no pair with a ghost. A contact with a ghost has a second
/// entry, under the particle that the ghost copies.
inline bool restore_history(PairList& list, const Particles& particles, const int* tags, int i,
                            int tag, const Remembered& known, double sign)
{
  bool only_entry = false, restored = false;
  int nearest = absent;
  for (int entry = list.first[i]; entry < list.first[i] + list.partners[i]; ++entry) {
    const int j = list.other[entry];
    if (tags[j] != tag) continue;
    if (!overlap(particles, i, j)) {
      if (nearest == absent || separation_squared(particles, i, j) <
                                   separation_squared(particles, i, list.other[nearest]))
        nearest = entry;
      continue;
    }
    remember(list, entry, known, sign);
    only_entry = j < particles.nlocal;
    restored = true;
  }
  if (restored || nearest == absent || !list.records_work) return only_entry;
  // The contact has ended at this step, and the kernel is to record its end.
  remember(list, nearest, known, sign);
  return list.other[nearest] < particles.nlocal;
}

namespace detail {

/// Return the entry of i with j; -1 if there is none.
inline int entry_of(const PairList& list, int i, int j)
{
  typedef int Ints __attribute__((vector_size(16)));
  const int end = list.first[i] + list.partners[i];
  for (int entry = list.first[i]; entry < end; entry += 8) {
    Ints low, high;
    std::memcpy(&low, &list.other[entry], sizeof low);
    std::memcpy(&high, &list.other[entry + 4], sizeof high);
    const unsigned same = _mm_movemask_ps(_mm_castsi128_ps(__m128i(low == j))) |
                          _mm_movemask_ps(_mm_castsi128_ps(__m128i(high == j))) << 4;
    if (same == 0) continue;
    const int found = entry + __builtin_ctz(same);
    return found < end ? found : -1;
  }
  return -1;
}

/// Restore the contact history of two local particles. Return true if the list has the pair without
/// a ghost, and it overlaps. The pair is most often listed under the particle whose entries come
/// first.
inline bool restore_local(PairList& list, const Particles& particles, int i, int j,
                          const Remembered& known)
{
  const bool i_first = list.first[i] <= list.first[j];
  for (const bool under_i : {i_first, !i_first}) {
    const int entry = under_i ? entry_of(list, i, j) : entry_of(list, j, i);
    if (entry < 0) continue;
    if (!overlap(particles, i, j)) return false;
    remember(list, entry, known, under_i ? 1.0 : -1.0);
    return true;
  }
  return false;
}

}  // namespace detail

/// Transfer the contact histories from the old list to the new one, whose particles may be numbered
/// differently. Either particle may own the pair in the new list; both own an entry once one of
/// them has left through a periodic boundary of the same rank. new_index: index in the new list of
/// each local particle of the old list, or `absent`.
inline void transfer_history(const PairList& old, const Tags& old_tags,
                             const std::vector<int>& new_index, PairList& list,
                             const Particles& particles, const int* tags)
{
  constexpr int block = 256;
  int touching[block];  // entries
  int before = 0;       // contacts
  for (int first = 0; first < old.entries; first += block) {
    int count = 0;
    for (int entry = first; entry < std::min(first + block, old.entries); ++entry) {
      touching[count] = entry;
      count += old.touching[entry];
    }
    for (int k = 0; k < count; ++k) {
      const int entry = touching[k];
      const int a = old.own[entry], b = old.other[entry];
      const int i = new_index[a], j = b < old.nlocal() ? new_index[b] : absent;
      const Remembered known = remembered(old, entry, before + k);
      if (i != absent && j != absent && detail::restore_local(list, particles, i, j, known))
        continue;
      if (i != absent && restore_history(list, particles, tags, i, old_tags[b], known, 1.0))
        continue;
      if (j != absent) restore_history(list, particles, tags, j, old_tags[a], known, -1.0);
    }
    before += count;
  }
}

/// Call visit(particle, tag of the partner, remembered, sign) for each contact of each marked local
/// particle. sign: -1 if the particle is j of what is remembered.
template <class Visit>
void for_each_history_of(const std::vector<char>& marked, const PairList& list, const Tags& tags,
                         const Visit& visit)
{
  for_each_contact(list, [&](int entry, int number) {
    const int a = list.own[entry], b = list.other[entry];
    const bool of_b = b < list.nlocal() && marked[b];
    if (!marked[a] && !of_b) return;
    const Remembered known = remembered(list, entry, number);
    if (marked[a]) visit(a, tags[b], known, 1.0);
    if (of_b) visit(b, tags[a], known, -1.0);
  });
}

}  // namespace millscale::neighbor
