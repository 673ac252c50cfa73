#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/energy/contact_work.h"
#include "core/neighbor/cell_grid.h"
#include "core/neighbor/cells.h"
#include "core/neighbor/particles.h"

namespace millscale::neighbor {

/// Half neighbour list: each near pair once, local particle i with particle j, local or ghost. The
/// pairs of i are entries first[i] .. first[i] + partners[i]. Positions decide which of two local
/// particles owns a pair. Particles that are near in space are near in the list. Beyond the last
/// entry, `spare_entries` more may be read.
struct PairList {
  int entries = 0;
  std::vector<int> first, partners;
  std::vector<int> own, other;       ///< i and j
  std::vector<int> touching;         ///< 1 while the pair is in contact
  std::vector<double> displacement;  ///< tangential displacement on i, three per entry, of pairs in
                                     ///< contact [m]; anything else of others
  bool records_work = false;         ///< the work of contacts is recorded
  energy::WorkStore work;            ///< of pairs in contact, in the order of the list, if recorded
  energy::WorkStore next_work;       ///< for that of the next step
  std::vector<double> available;  ///< energy of the approach [J], of pairs in contact, if recorded

  std::vector<energy::CarriedWork> carried;  ///< to a new list, before it is ordered

  int nlocal() const { return static_cast<int>(first.size()); }

  /// Make room for `count` entries.
  void reserve(std::size_t count)
  {
    if (other.size() < count) {
      own.resize(count + count / 4);
      other.resize(count + count / 4);
      displacement.resize(3 * other.size());
    }
    if (!records_work) return;
    work.reserve(other.size());
    next_work.reserve(other.size());
    if (available.size() < other.size()) available.resize(other.size());
  }
};

/// Call visit(entry, number) for each contact, numbered in the order of the list.
template <class Visit>
inline void for_each_contact(const PairList& list, const Visit& visit)
{
  int number = 0;
  for (int entry = 0; entry < list.entries; ++entry)
    if (list.touching[entry]) visit(entry, number++);
}

/// Build the list of the pairs whose surfaces are within the sum of both skins [m], without
/// contacts and histories.
inline void build(PairList& list, CellGrid& grid, const Particles& particles, const double* skin,
                  ListPartners list_partners)
{
  grid.sort(particles, skin);
  list.first.resize(particles.nlocal);
  list.partners.resize(particles.nlocal);
  int count = 0;
  grid.for_each([&](int i, const Centre& centre, const Candidates& candidates) {
    list.reserve(count + candidates.most);
    int* const begin = list.other.data() + count;
    const int found = static_cast<int>(list_partners(candidates, centre, begin) - begin);
    list.first[i] = count;
    list.partners[i] = found;
    int* const own = list.own.data() + count;
    for (int k = 0; k < found; k += 8) std::fill_n(own + k, 8, i);
    count += found;
  });
  list.entries = count;
  list.reserve(count + spare_entries);
  for (auto* ball : {&list.own, &list.other}) std::fill_n(ball->data() + count, spare_entries, 0);
  list.touching.assign(count + spare_entries, 0);
}

}  // namespace millscale::neighbor
