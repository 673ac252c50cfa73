#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <vector>

#include "core/neighbor/cells.h"

namespace millscale::pairs {

/// Pairs of balls that are close, each once: owned ball i with other balls j, owned or ghost. The
/// pairs of ball i are entries first[i] .. first[i] + partners[i]; which of two owned balls has a
/// pair follows from where they are. Balls that are neighbours in space are neighbours in the list.
/// Beyond the last entry there are `spare_entries` more to be read, not to be used.
struct HalfList {
  int entries = 0;
  std::vector<int> first, partners;
  std::vector<int> own, other;       ///< i and j
  std::vector<int> touching;         ///< 1 while the two touch
  std::vector<double> displacement;  ///< tangential memory of the contact on i, three each [m]

  int owned() const { return static_cast<int>(first.size()); }
};

/// Balls sorted into a grid of cells no smaller than the longest reach, so that a ball's partners
/// are in its own and the 26 cells around.
class CellGrid {
 public:
  static constexpr int fours = 4;  ///< balls are copied and read by the four

  /// margin: largest of a ball [m].
  void sort(const Balls& balls, double margin)
  {
    double largest = 0.0;
    for (int i = 0; i < balls.all; ++i) largest = std::max(largest, balls.radius[i]);
    lay_out(balls, 2.0 * (largest + margin));
    cell_of_.resize(balls.all);
    start_.assign(static_cast<std::size_t>(cells_[0]) * cells_[1] * cells_[2] + 1, 0);
    ghosts_.assign(start_.size(), 0);
    for (int i = 0; i < balls.all; ++i) {
      cell_of_[i] = cell(balls.position[i]);
      ++start_[cell_of_[i] + 1];
      ghosts_[cell_of_[i] + 1] += i >= balls.owned;
    }
    for (auto* count : {&start_, &ghosts_})
      std::partial_sum(count->begin(), count->end(), count->begin());
    next_.assign(start_.begin(), start_.end() - 1);
    // Four may be read where one is left.
    for (auto& numbers : sorted_) numbers.resize(balls.all + fours);
    index_.resize(balls.all + fours);
    for (int i = 0; i < balls.all; ++i) {
      const int place = next_[cell_of_[i]]++;
      for (int d = 0; d < 3; ++d) sorted_[d][place] = balls.position[i][d];
      sorted_[3][place] = balls.radius[i];
      index_[place] = i;
    }
  }

  /// The balls' radii begin this much further out from here on.
  void widen(const double* margin)
  {
    for (std::size_t place = 0; place < cell_of_.size(); ++place)
      sorted_[3][place] += margin[index_[place]];
  }

  int cells() const { return static_cast<int>(start_.size()) - 1; }

  /// Owned balls of a cell.
  const int* begin(int cell) const { return index_.data() + start_[cell]; }
  const int* end(int cell) const { return index_.data() + first_ghost(cell); }

  /// Of each ball the largest of these numbers, none negative, among the balls of its own and the
  /// 26 cells around.
  void largest_around(std::vector<double>& of_ball)
  {
    largest_.assign(cells(), 0.0);
    for (std::size_t i = 0; i < cell_of_.size(); ++i)
      largest_[cell_of_[i]] = std::max(largest_[cell_of_[i]], of_ball[i]);
    for (const int step : {1, cells_[0], cells_[0] * cells_[1]}) {
      along_.assign(largest_.begin(), largest_.end());
      for (int c = step; c + step < cells(); ++c)
        largest_[c] = std::max({along_[c - step], along_[c], along_[c + step]});
    }
    for (std::size_t i = 0; i < cell_of_.size(); ++i) of_ball[i] = largest_[cell_of_[i]];
  }

  /// Copies side by side, good until the next call: first the owned balls of an inner cell, then
  /// those that may be their partners. Of two cells the later one's balls are the earlier one's
  /// candidates; ghosts are candidates of both, for they have none.
  Candidates around(int cell)
  {
    near_count_ = 0;
    const int row = cells_[0], layer = cells_[0] * cells_[1];
    copy(start_[cell], start_[cell + 2]);
    for (const int later : {row, layer - row, layer, layer + row})
      copy(start_[cell + later - 1], start_[cell + later + 2]);
    copy_ghosts(cell - 1, cell);
    for (const int earlier : {row, layer - row, layer, layer + row})
      copy_ghosts(cell - earlier - 1, cell - earlier + 2);
    return {near_[0].data(), near_[1].data(),    near_[2].data(),
            near_[3].data(), near_index_.data(), near_count_};
  }

 private:
  template <class Number>
  static void copy_four(const Number* from, Number* to)
  {
    std::memcpy(to, from, 4 * sizeof(Number));
  }

  /// Balls are sorted into a cell in their order, so ghosts come last.
  int first_ghost(int cell) const { return start_[cell + 1] - (ghosts_[cell + 1] - ghosts_[cell]); }

  /// The sorted balls from one to before another.
  void copy(int first, int end)
  {
    const std::size_t needed = near_count_ + (end - first) + fours;
    if (near_index_.size() < needed) {
      for (auto& numbers : near_) numbers.resize(2 * needed);
      near_index_.resize(2 * needed);
    }
    // Rows are short: whole fours, in place of a call for each.
    for (int from = first, to = near_count_; from < end; from += fours, to += fours) {
      for (int d = 0; d < 4; ++d) copy_four(&sorted_[d][from], &near_[d][to]);
      copy_four(&index_[from], &near_index_[to]);
    }
    near_count_ += end - first;
  }

  /// Of cells side by side.
  void copy_ghosts(int first, int end)
  {
    if (ghosts_[end] == ghosts_[first]) return;
    for (int cell = first; cell < end; ++cell) copy(first_ghost(cell), start_[cell + 1]);
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
  std::vector<int> cell_of_, next_;
  std::vector<int> start_, ghosts_;          ///< balls, ghosts in all cells before each
  std::vector<double> sorted_[4], near_[4];  ///< x, y, z, radius and margin
  std::vector<double> largest_, along_;
  std::vector<int> index_, near_index_;
  int near_count_ = 0;
};

/// Lists the pairs whose surfaces are within the sum of both balls' margins [m]; memories are zero,
/// nothing touches. The grid is of these balls and sorted with no shorter a reach.
inline void build(HalfList& list, CellGrid& grid, const Balls& balls, const double* margin,
                  ListPartners list_partners)
{
  grid.widen(margin);
  list.first.resize(balls.owned);
  list.partners.resize(balls.owned);
  std::size_t count = 0;
  for (int cell = 0; cell < grid.cells(); ++cell) {
    if (grid.begin(cell) == grid.end(cell)) continue;
    Candidates candidates = grid.around(cell);
    for (const int* ball = grid.begin(cell); ball != grid.end(cell); ++ball) {
      const int i = *ball;
      candidates.leave_out_first();
      const std::size_t needed = count + candidates.count + 2 * CellGrid::fours;
      if (list.other.size() < needed) {
        list.own.resize(2 * needed);
        list.other.resize(2 * needed);
      }
      int* const begin = list.other.data() + count;
      const double* x = balls.position[i];
      const int* end =
          list_partners(candidates, {x[0], x[1], x[2], balls.radius[i] + margin[i]}, begin);
      list.first[i] = static_cast<int>(count);
      list.partners[i] = static_cast<int>(end - begin);
      std::fill_n(list.own.data() + count, list.partners[i], i);
      count += list.partners[i];
    }
  }
  list.entries = static_cast<int>(count);
  const std::size_t room = count + spare_entries;
  for (auto* ball : {&list.own, &list.other}) {
    ball->resize(room);
    std::fill_n(ball->data() + count, spare_entries, 0);
  }
  list.touching.assign(room, 0);
  list.displacement.assign(3 * room, 0.0);
}

}  // namespace millscale::pairs
