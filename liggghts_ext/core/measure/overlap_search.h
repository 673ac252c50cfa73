#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/math/vector.h"

namespace millscale::charge {

struct Sphere {
  double x, y, z, radius;
  bool ghost = false;  ///< of another sphere, perhaps on another rank
};

/// Finds the largest overlap of two spheres with cells as wide as the largest sphere, without a
/// neighbour list. Storage is reused from search to search. Pairs of two ghosts are left out: they
/// are the images of other pairs.
class OverlapSearch {
 public:
  void clear() { spheres_.clear(); }
  void add(const Sphere& s) { spheres_.push_back(s); }

  /// Return the largest overlap of all pairs, radii less distance of the centres [m]; 0 without
  /// overlaps.
  double largest()
  {
    if (spheres_.size() < 2) return 0.0;
    make_grid();
    sort_into_cells();
    best_ = 0.0;
    for (int z = 0; z < cells_[2]; ++z)
      for (int y = 0; y < cells_[1]; ++y)
        for (int x = 0; x < cells_[0]; ++x) search_cell(x, y, z);
    return best_;
  }

 private:
  /// Cells from one corner of the spheres to the other, at least as wide as a sphere. Cells are
  /// wider where distant outliers would make more than a few cells per sphere.
  void make_grid()
  {
    Vector high;
    low_ = high = {spheres_[0].x, spheres_[0].y, spheres_[0].z};
    double radius = 0.0;
    for (const Sphere& s : spheres_) {
      low_ = {std::min(low_[0], s.x), std::min(low_[1], s.y), std::min(low_[2], s.z)};
      high = {std::max(high[0], s.x), std::max(high[1], s.y), std::max(high[2], s.z)};
      radius = std::max(radius, s.radius);
    }
    const double most = 16.0 * static_cast<double>(spheres_.size()) + 1e4;
    double width = 2.0 * radius, count;
    do {
      count = 1.0;
      for (int d = 0; d < 3; ++d) {
        const double along = std::floor((high[d] - low_[d]) / width) + 1.0;
        count *= along;
        cells_[d] = static_cast<int>(std::min(along, most));
      }
      inverse_width_ = 1.0 / width;
      width *= 2.0;
    } while (count > most);
  }

  std::size_t cell(int x, int y, int z) const
  {
    return (static_cast<std::size_t>(z) * cells_[1] + y) * cells_[0] + x;
  }

  /// Counting sort: the spheres of cell c are sorted_[begin_[c]] to sorted_[begin_[c + 1]].
  void sort_into_cells()
  {
    const std::size_t count = cell(0, 0, cells_[2]);
    begin_.assign(count + 2, 0);
    cell_of_.resize(spheres_.size());
    sorted_.resize(spheres_.size());
    const auto along = [this](double x, int d) {
      return std::min(static_cast<int>((x - low_[d]) * inverse_width_), cells_[d] - 1);
    };
    for (std::size_t i = 0; i < spheres_.size(); ++i) {
      const Sphere& s = spheres_[i];
      cell_of_[i] = static_cast<std::uint32_t>(cell(along(s.x, 0), along(s.y, 1), along(s.z, 2)));
      ++begin_[cell_of_[i] + 2];
    }
    for (std::size_t c = 2; c < begin_.size(); ++c) begin_[c] += begin_[c - 1];
    for (std::size_t i = 0; i < spheres_.size(); ++i)
      sorted_[begin_[cell_of_[i] + 1]++] = spheres_[i];
  }

  /// Search the pairs of a cell with itself and with half of its neighbours. Neighbours along x are
  /// contiguous in sorted_, so each row of cells is one range.
  void search_cell(int x, int y, int z)
  {
    const std::size_t own = cell(x, y, z);
    const std::size_t first = begin_[own], last = begin_[own + 1];
    if (first == last) return;
    const int left = std::max(x - 1, 0), right = std::min(x + 1, cells_[0] - 1);
    const std::size_t along_row = begin_[cell(right, y, z) + 1];
    for (std::size_t i = first; i < last; ++i) compare(sorted_[i], i + 1, along_row);
    static constexpr std::array<std::array<int, 2>, 4> rows{{{1, 0}, {-1, 1}, {0, 1}, {1, 1}}};
    for (const auto& [dy, dz] : rows) {
      if (y + dy < 0 || y + dy >= cells_[1] || z + dz >= cells_[2]) continue;
      const std::size_t from = begin_[cell(left, y + dy, z + dz)];
      const std::size_t to = begin_[cell(right, y + dy, z + dz) + 1];
      for (std::size_t i = first; i < last; ++i) compare(sorted_[i], from, to);
    }
  }

  void compare(const Sphere& s, std::size_t from, std::size_t to)
  {
    for (std::size_t j = from; j < to; ++j) {
      const Sphere& t = sorted_[j];
      const double dx = s.x - t.x, dy = s.y - t.y, dz = s.z - t.z;
      const double square = dx * dx + dy * dy + dz * dz;
      const double closer = s.radius + t.radius - best_;  // a square root only for a new maximum
      // With a margin for rounding, so that the order of the pairs does not matter.
      if (!(closer > 0.0 && square < (1.0 + 1e-14) * closer * closer) || (s.ghost && t.ghost))
        continue;
      best_ = std::max(best_, s.radius + t.radius - std::sqrt(square));
    }
  }

  std::vector<Sphere> spheres_, sorted_;
  std::vector<std::uint32_t> begin_, cell_of_;
  Vector low_{};
  std::array<int, 3> cells_{};
  double inverse_width_ = 0.0, best_ = 0.0;
};

}  // namespace millscale::charge
