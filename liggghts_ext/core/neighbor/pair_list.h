#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <vector>

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
  std::vector<double> displacement;  ///< tangential displacement on i, three per entry [m]

  int nlocal() const { return static_cast<int>(first.size()); }
};

/// Particles sorted into cells no smaller than the longest reach, so that a particle's partners are
/// in the 27 nearby cells.
class CellGrid {
 public:
  static constexpr int fours = 4;  ///< particles are copied and read four at a time

  /// skin: the largest skin of a particle [m].
  void sort(const Particles& particles, double skin)
  {
    double largest = 0.0;
    for (int i = 0; i < particles.total(); ++i) largest = std::max(largest, particles.radius[i]);
    lay_out(particles, 2.0 * (largest + skin));
    cell_of_.resize(particles.total());
    start_.assign(static_cast<std::size_t>(cells_[0]) * cells_[1] * cells_[2] + 1, 0);
    ghosts_.assign(start_.size(), 0);
    for (int i = 0; i < particles.total(); ++i) {
      cell_of_[i] = cell(particles.position[i]);
      ++start_[cell_of_[i] + 1];
      ghosts_[cell_of_[i] + 1] += i >= particles.nlocal;
    }
    for (auto* count : {&start_, &ghosts_})
      std::partial_sum(count->begin(), count->end(), count->begin());
    next_.assign(start_.begin(), start_.end() - 1);
    // Groups of four are read, also where one is left.
    for (auto& numbers : sorted_) numbers.resize(particles.total() + fours);
    index_.resize(particles.total() + fours);
    for (int i = 0; i < particles.total(); ++i) {
      const int place = next_[cell_of_[i]]++;
      for (int d = 0; d < 3; ++d) sorted_[d][place] = particles.position[i][d];
      sorted_[3][place] = particles.radius[i];
      index_[place] = i;
    }
  }

  /// Add each particle's skin to its radius.
  void widen(const double* skin)
  {
    for (std::size_t place = 0; place < cell_of_.size(); ++place)
      sorted_[3][place] += skin[index_[place]];
  }

  int cells() const { return static_cast<int>(start_.size()) - 1; }

  /// Local particles of a cell.
  const int* begin(int cell) const { return index_.data() + start_[cell]; }
  const int* end(int cell) const { return index_.data() + first_ghost(cell); }

  /// Replace each particle's value, >= 0, by the largest in the 27 nearby cells.
  void largest_around(std::vector<double>& value)
  {
    largest_.assign(cells(), 0.0);
    for (std::size_t i = 0; i < cell_of_.size(); ++i)
      largest_[cell_of_[i]] = std::max(largest_[cell_of_[i]], value[i]);
    for (const int step : {1, cells_[0], cells_[0] * cells_[1]}) {
      along_.assign(largest_.begin(), largest_.end());
      for (int c = step; c + step < cells(); ++c)
        largest_[c] = std::max({along_[c - step], along_[c], along_[c + step]});
    }
    for (std::size_t i = 0; i < cell_of_.size(); ++i) value[i] = largest_[cell_of_[i]];
  }

  /// Return contiguous copies, valid until the next call: first the local particles of an inner
  /// cell, then their candidates. Of two cells, the particles of the later are candidates of the
  /// earlier; ghosts are candidates of both, for ghosts have no candidates.
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

  /// Sorting keeps the order within a cell, so ghosts come last.
  int first_ghost(int cell) const { return start_[cell + 1] - (ghosts_[cell + 1] - ghosts_[cell]); }

  /// Copy a range of sorted particles.
  void copy(int first, int end)
  {
    const std::size_t needed = near_count_ + (end - first) + fours;
    if (near_index_.size() < needed) {
      for (auto& numbers : near_) numbers.resize(2 * needed);
      near_index_.resize(2 * needed);
    }
    // Ranges are short: groups of four are faster than a memcpy each.
    for (int from = first, to = near_count_; from < end; from += fours, to += fours) {
      for (int d = 0; d < 4; ++d) copy_four(&sorted_[d][from], &near_[d][to]);
      copy_four(&index_[from], &near_index_[to]);
    }
    near_count_ += end - first;
  }

  /// Copy the ghosts of a range of cells.
  void copy_ghosts(int first, int end)
  {
    if (ghosts_[end] == ghosts_[first]) return;
    for (int cell = first; cell < end; ++cell) copy(first_ghost(cell), start_[cell + 1]);
  }

  void lay_out(const Particles& particles, double reach)
  {
    double high[3];
    for (int d = 0; d < 3; ++d) low_[d] = INFINITY, high[d] = -INFINITY;
    for (int i = 0; i < particles.total(); ++i)
      for (int d = 0; d < 3; ++d) {
        low_[d] = std::min(low_[d], particles.position[i][d]);
        high[d] = std::max(high[d], particles.position[i][d]);
      }
    // A layer of empty cells around the grid saves tests at its boundary. The factor keeps rounding
    // from placing a pair at exactly the reach two cells apart.
    double edge = (1.0 + 1e-6) * reach;
    for (;; edge *= 1.3) {
      double count = 1.0;
      for (int d = 0; d < 3; ++d) {
        // Without particles, high - low is minus infinity.
        cells_[d] = 3 + static_cast<int>(std::clamp((high[d] - low_[d]) / edge, 0.0, 1e4));
        count *= cells_[d];
      }
      if (count < 64.0 + 8.0 * particles.total()) break;
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
  std::vector<int> start_, ghosts_;          ///< particles and ghosts in all cells before each
  std::vector<double> sorted_[4], near_[4];  ///< x, y, z, reach
  std::vector<double> largest_, along_;
  std::vector<int> index_, near_index_;
  int near_count_ = 0;
};

/// Build the list of the pairs whose surfaces are within the sum of both skins [m], without
/// contacts and histories. The grid holds these particles, sorted with a skin at least as large.
inline void build(PairList& list, CellGrid& grid, const Particles& particles, const double* skin,
                  ListPartners list_partners)
{
  grid.widen(skin);
  list.first.resize(particles.nlocal);
  list.partners.resize(particles.nlocal);
  std::size_t count = 0;
  for (int cell = 0; cell < grid.cells(); ++cell) {
    if (grid.begin(cell) == grid.end(cell)) continue;
    Candidates candidates = grid.around(cell);
    for (const int* ball = grid.begin(cell); ball != grid.end(cell); ++ball) {
      const int i = *ball;
      candidates.drop_first();
      const std::size_t needed = count + candidates.count + 2 * CellGrid::fours;
      if (list.other.size() < needed) {
        list.own.resize(2 * needed);
        list.other.resize(2 * needed);
      }
      int* const begin = list.other.data() + count;
      const double* x = particles.position[i];
      const int* end =
          list_partners(candidates, {x[0], x[1], x[2], particles.radius[i] + skin[i]}, begin);
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

}  // namespace millscale::neighbor
