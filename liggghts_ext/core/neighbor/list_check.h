#pragma once

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "core/neighbor/pair_list.h"

namespace millscale::pairs {

/// Two balls that touch and that the list does not say to touch.
struct MissedContact {
  int i, j;
  double overlap;  ///< [m]
  bool listed;     ///< the list has the pair, not the touch
};

namespace detail {

inline std::optional<MissedContact> missed(const HalfList& list, const Balls& balls, int i, int j)
{
  if (std::min(i, j) >= balls.owned) return std::nullopt;  // two ghosts: another rank's
  const double radii = balls.radius[i] + balls.radius[j];
  const double overlap = radii - std::sqrt(apart_square(balls, i, j));
  if (!(overlap > 1e-12 * radii)) return std::nullopt;  // rounding may say either
  for (const auto& [a, b] : {std::pair{i, j}, std::pair{j, i}}) {
    if (a >= balls.owned) continue;
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

/// Looks for a contact that a list lacks, after its evaluation. It shares nothing with `build`: all
/// balls in order of their lower ends along x, each with those that begin before it ends.
inline std::optional<MissedContact> missed_contact(const HalfList& list, const Balls& balls)
{
  const auto low = [&](int i) { return balls.position[i][0] - balls.radius[i]; };
  std::vector<int> order(balls.all);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) { return low(a) < low(b); });
  for (std::size_t a = 0; a < order.size(); ++a) {
    const double high = balls.position[order[a]][0] + balls.radius[order[a]];
    for (std::size_t b = a + 1; b < order.size() && low(order[b]) < high; ++b)
      if (const auto found = detail::missed(list, balls, order[a], order[b])) return found;
  }
  return std::nullopt;
}

}  // namespace millscale::pairs
