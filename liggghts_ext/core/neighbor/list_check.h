#pragma once

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "core/neighbor/pair_list.h"

namespace millscale::neighbor {

/// Two particles that overlap and that the list does not mark as touching.
struct MissedContact {
  int i, j;
  double overlap;  ///< [m]
  bool listed;     ///< the list has the pair, not marked as touching
};

namespace detail {

inline std::optional<MissedContact> missed(const PairList& list, const Particles& particles, int i,
                                           int j)
{
  if (std::min(i, j) >= particles.nlocal)
    return std::nullopt;  // two ghosts: another rank evaluates them
  const double radii = particles.radius[i] + particles.radius[j];
  const double overlap = radii - std::sqrt(separation_squared(particles, i, j));
  if (!(overlap > 1e-12 * radii)) return std::nullopt;  // rounding decides
  for (const auto& [a, b] : {std::pair{i, j}, std::pair{j, i}}) {
    if (a >= particles.nlocal) continue;
    const int* begin = list.other.data() + list.first[a];
    const int* end = begin + list.partners[a];
    const int* found = std::find(begin, end, b);
    if (found == end) continue;
    if (list.touching[found - list.other.data()]) return std::nullopt;
    return MissedContact{i, j, overlap, true};
  }
  return MissedContact{i, j, overlap, false};
}

}  // namespace detail

/// Return a contact that the list lacks after its evaluation, if there is one. The search shares no
/// code with `build`: it sweeps the particles in order of their lower ends along x.
inline std::optional<MissedContact> missed_contact(const PairList& list, const Particles& particles)
{
  const auto low = [&](int i) { return particles.position[i][0] - particles.radius[i]; };
  std::vector<int> order(particles.total());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) { return low(a) < low(b); });
  for (std::size_t a = 0; a < order.size(); ++a) {
    const double high = particles.position[order[a]][0] + particles.radius[order[a]];
    for (std::size_t b = a + 1; b < order.size() && low(order[b]) < high; ++b)
      if (const auto found = detail::missed(list, particles, order[a], order[b])) return found;
  }
  return std::nullopt;
}

}  // namespace millscale::neighbor
