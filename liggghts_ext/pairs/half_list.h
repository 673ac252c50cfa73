#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "pairs/balls.h"

namespace millscale::pairs {

/// Pairs of balls that are close, each once: owned ball i with every later ball j, owned or ghost.
/// Pairs of ball i are entries first[i] .. first[i + 1].
struct HalfList {
  std::vector<int> first{0};
  std::vector<int> other;            ///< j
  std::vector<int> touching;         ///< 1 while the two touch
  std::vector<double> displacement;  ///< tangential memory of the contact on i, three each [m]

  int owned() const { return static_cast<int>(first.size()) - 1; }
  std::size_t size() const { return other.size(); }
};

/// Balls sorted into a grid of cells no smaller than the longest reach, so that a ball's partners
/// are in its own and the 26 cells around.
class CellGrid {
 public:
  /// reach: largest distance of two centres that make a pair [m].
  void sort(const Balls& balls, double reach)
  {
    lay_out(balls, reach);
    cell_of_.resize(balls.all);
    start_.assign(static_cast<std::size_t>(cells_[0]) * cells_[1] * cells_[2] + 1, 0);
    for (int i = 0; i < balls.all; ++i) {
      cell_of_[i] = cell(balls.position[i]);
      ++start_[cell_of_[i] + 1];
    }
    for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
    next_.assign(start_.begin(), start_.end() - 1);
    sorted_.resize(balls.all);
    for (int i = 0; i < balls.all; ++i) {
      Sorted& ball = sorted_[next_[cell_of_[i]]++];
      for (int d = 0; d < 3; ++d) ball.position[d] = balls.position[i][d];
      ball.radius = balls.radius[i];
      ball.index = i;
    }
  }

  /// Most partners ball i can have.
  int room(int i) const
  {
    int balls = 0;
    for_rows(cell_of_[i], [&](int begin, int end) { balls += end - begin; });
    return balls;
  }

  /// Writes every ball j > i whose surface is within `gap` of that of ball i; returns the end.
  int* later_partners(const Balls& balls, int i, double gap, int* out) const
  {
    const double* x = balls.position[i];
    const double reach = balls.radius[i] + gap;
    for_rows(cell_of_[i], [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        const Sorted& ball = sorted_[k];
        const double dx = x[0] - ball.position[0], dy = x[1] - ball.position[1],
                     dz = x[2] - ball.position[2], limit = reach + ball.radius;
        *out = static_cast<int>(ball.index);  // kept only if it counts: no branch to mispredict
        out += (dx * dx + dy * dy + dz * dz <= limit * limit) & (ball.index > i);
      }
    });
    return out;
  }

 private:
  struct Sorted {
    double position[3], radius;
    std::int64_t index;
  };

  /// Ranges of sorted balls in the cells around one: three cells of a row lie side by side.
  template <class Visit>
  void for_rows(int home, const Visit& visit) const
  {
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy) {
        const int row = home + cells_[0] * (dy + cells_[1] * dz);
        visit(start_[row - 1], start_[row + 2]);
      }
  }

  void lay_out(const Balls& balls, double reach)
  {
    double high[3];
    for (int d = 0; d < 3; ++d) low_[d] = INFINITY, high[d] = -INFINITY;
    for (int i = 0; i < balls.all; ++i)
      for (int d = 0; d < 3; ++d) {
        low_[d] = std::min(low_[d], balls.position[i][d]);
        high[d] = std::max(high[d], balls.position[i][d]);
      }
    // A layer of empty cells all round spares the tests at the border.
    // The hair keeps rounding from putting a pair at the very reach two cells apart.
    double edge = (1.0 + 1e-6) * reach;
    for (;; edge *= 1.3) {
      double count = 1.0;
      for (int d = 0; d < 3; ++d) {
        // Without balls, high - low is minus infinity.
        cells_[d] = 3 + static_cast<int>(std::clamp((high[d] - low_[d]) / edge, 0.0, 1e4));
        count *= cells_[d];
      }
      if (count < 64.0 + 8.0 * balls.all) break;
    }
    inverse_edge_ = 1.0 / edge;
  }

  int cell(const double* x) const
  {
    int at[3];
    for (int d = 0; d < 3; ++d)
      at[d] = 1 + std::clamp(static_cast<int>((x[d] - low_[d]) * inverse_edge_), 0, cells_[d] - 3);
    return at[0] + cells_[0] * (at[1] + cells_[1] * at[2]);
  }

  double low_[3], inverse_edge_ = 1.0;
  int cells_[3];
  std::vector<int> cell_of_, start_, next_;
  std::vector<Sorted> sorted_;
};

/// Lists the pairs whose surfaces are within `gap` [m]; memories are zero, nothing touches.
inline void build(HalfList& list, CellGrid& grid, const Balls& balls, double gap)
{
  double largest = 0.0;
  for (int i = 0; i < balls.all; ++i) largest = std::max(largest, balls.radius[i]);
  grid.sort(balls, 2.0 * largest + gap);
  list.first.resize(balls.owned + 1);
  list.first[0] = 0;
  int count = 0;
  for (int i = 0; i < balls.owned; ++i) {
    const std::size_t needed = static_cast<std::size_t>(count) + grid.room(i);
    if (list.other.size() < needed) list.other.resize(needed + needed / 2);
    int* begin = list.other.data() + count;
    count += static_cast<int>(grid.later_partners(balls, i, gap, begin) - begin);
    list.first[i + 1] = count;
  }
  list.other.resize(count);
  list.touching.assign(count, 0);
  list.displacement.assign(3 * static_cast<std::size_t>(count), 0.0);
}

}  // namespace millscale::pairs
