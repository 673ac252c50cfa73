#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/neighbor/cells.h"
#include "core/neighbor/particles.h"

namespace millscale::neighbor {

/// The smallest box that holds some particles [m]. A NaN position does not change it.
struct Bounds {
  double low[3] = {INFINITY, INFINITY, INFINITY};
  double high[3] = {-INFINITY, -INFINITY, -INFINITY};

  void add(const double* x)
  {
    for (int d = 0; d < 3; ++d) {
      low[d] = std::min(low[d], x[d]);
      high[d] = std::max(high[d], x[d]);
    }
  }
};

/// Particles sorted by size class, and by cell within a class. Size is the reach, radius plus skin.
/// A class has cells as large as its particles need: small particles among large ones have few
/// candidates. Layers along z hold rows along y, and rows hold slices along x, so the candidates of
/// a particle in a row are contiguous.
class CellGrid {
 public:
  /// Sort the particles. skin: of each particle [m].
  void sort(const Particles& particles, const double* skin)
  {
    nlocal_ = particles.nlocal;
    const int total = particles.total();
    lay_out(particles, skin);
    start_.assign(cells_ + 1, 0);
    ghost_start_.assign(particles.nghost > 0 ? cells_ + 1 : 0, 0);
    cell_of_.resize(total);
    for (int i = 0; i < total; ++i) {
      const SizeClass& size = classes_.size() == 1 ? classes_[0] : classes_[class_of_[i]];
      cell_of_[i] = size.cell(particles.position[i]);
      ++(i < nlocal_ ? start_ : ghost_start_)[cell_of_[i]];
    }
    for (auto* numbers : {&x_, &y_, &z_, &reach_}) numbers->resize(total + Candidates::spare);
    index_.resize(total + Candidates::spare);
    place(particles, skin, 0, nlocal_, start_);
    if (particles.nghost == 0) return;
    place(particles, skin, nlocal_, total, ghost_start_);
    for (SizeClass& size : classes_) count_ghosts(size);
  }

  /// Call visit(index, centre, candidates) for each local particle. Of two particles of a class,
  /// the later is a candidate of the earlier. Of two classes, all particles of one look for those
  /// of the other. Ghosts are candidates of all near, for ghosts have no candidates.
  template <class Visit>
  void for_each(const Visit& visit)
  {
    for (std::size_t c = 0; c < classes_.size(); ++c) {
      const SizeClass& size = classes_[c];
      find_searched(c);
      for (int z = 0; z < size.cells[2]; ++z)
        for (int y = 0; y < size.cells[1]; ++y) visit_row(size, y, z, visit);
    }
  }

 private:
  /// Largest over smallest reach of a class. A ratio of 2 doubles the cost of radii that are spread
  /// evenly from 1 to 10.
  static constexpr double class_ratio = 4.0;
  /// Slices of a cell along x. Its edges along y and z hold the largest reach of two particles.
  static constexpr int slices = 2;
  /// Rounding must not place a pair at the very reach outside of the cells that are searched.
  static constexpr double allowance = 1.0 + 1e-6;

  struct SizeClass {
    double reach;  ///< the largest of its particles [m]
    double low[3], inverse[3], last[3];
    int cells[3];
    int first;                        ///< cell
    int local;                        ///< particles
    std::vector<int> ghosts_below{};  ///< ghosts in rows of a smaller y than each

    /// Return the cell along one direction; 0 for a NaN.
    int at(int d, double x) const
    {
      return static_cast<int>(std::min(last[d], std::max(0.0, (x - low[d]) * inverse[d])));
    }
    int row(int y, int z) const { return first + cells[0] * (y + cells[1] * z); }
    int cell(const double* x) const { return row(at(1, x[1]), at(2, x[2])) + at(0, x[0]); }
    /// Return how many rows a particle of another reach searches.
    double rows_near(double other) const
    {
      return (1.0 + 2.0 * (reach + other) * inverse[1]) *
             (1.0 + 2.0 * (reach + other) * inverse[2]);
    }
  };

  /// Another class that a class searches.
  struct Searched {
    const SizeClass* size;
    bool local;  ///< also its local particles
  };

  void lay_out(const Particles& particles, const double* skin)
  {
    double least = INFINITY, most = 0.0;
    Bounds bounds;
    for (int i = 0; i < particles.total(); ++i) {
      const double reach = particles.radius[i] + skin[i];
      least = std::min(least, reach);
      most = std::max(most, reach);
      bounds.add(particles.position[i]);
    }
    classes_.clear();
    cells_ = 0;
    if (most < class_ratio * least || particles.total() == 0)
      add_class(bounds, most, particles.nlocal, particles.total());
    else
      lay_out_classes(particles, skin, most);
  }

  void lay_out_classes(const Particles& particles, const double* skin, double most)
  {
    struct Content {
      Bounds bounds;
      double reach = 0.0;
      int local = 0, total = 0;
      int number;
    };
    constexpr int most_classes = 6;  // the last holds all that are smaller
    Content content[most_classes];
    class_of_.resize(particles.total());
    for (int i = 0; i < particles.total(); ++i) {
      const double reach = particles.radius[i] + skin[i];
      int c = 0;
      for (double limit = most / class_ratio; reach <= limit && c + 1 < most_classes;
           limit /= class_ratio)
        ++c;
      class_of_[i] = static_cast<signed char>(c);
      content[c].bounds.add(particles.position[i]);
      content[c].reach = std::max(content[c].reach, reach);
      content[c].local += i < particles.nlocal;
      ++content[c].total;
    }
    for (Content& each : content) {
      each.number = static_cast<int>(classes_.size());
      if (each.total > 0) add_class(each.bounds, each.reach, each.local, each.total);
    }
    for (signed char& c : class_of_) c = static_cast<signed char>(content[c].number);
  }

  void add_class(Bounds bounds, double reach, int local, int total)
  {
    SizeClass size{};
    size.reach = reach;
    size.local = local;
    size.first = static_cast<int>(cells_);
    for (double edge = 2.0 * allowance * reach;; edge *= 1.3) {
      double count = 1.0;
      for (int d = 0; d < 3; ++d) {
        size.inverse[d] = (d == 0 ? slices : 1) / edge;
        // Without particles, high - low is minus infinity.
        size.cells[d] = 1 + static_cast<int>(std::clamp(
                                (bounds.high[d] - bounds.low[d]) * size.inverse[d], 0.0, 1e4));
        count *= size.cells[d];
      }
      if (count < 64.0 + 16.0 * total) break;
    }
    for (int d = 0; d < 3; ++d) {
      size.low[d] = bounds.low[d];
      size.last[d] = size.cells[d] - 1;
    }
    cells_ += static_cast<std::size_t>(size.cells[0]) * size.cells[1] * size.cells[2];
    classes_.push_back(size);
  }

  /// Copy the particles into their cells, in order within a cell. start: the number in each cell,
  /// then the first place of each.
  void place(const Particles& particles, const double* skin, int first, int end,
             std::vector<int>& start)
  {
    int sum = first;
    for (int& count : start) count = sum += count;
    for (int i = end - 1; i >= first; --i) {
      const int at = --start[cell_of_[i]];
      x_[at] = particles.position[i][0];
      y_[at] = particles.position[i][1];
      z_[at] = particles.position[i][2];
      reach_[at] = particles.radius[i] + skin[i];
      index_[at] = i;
    }
  }

  void count_ghosts(SizeClass& size)
  {
    size.ghosts_below.assign(size.cells[1] + 1, 0);
    for (int y = 0; y < size.cells[1]; ++y) {
      int ghosts = size.ghosts_below[y];
      for (int z = 0; z < size.cells[2]; ++z)
        ghosts += ghost_start_[size.row(y, z) + size.cells[0]] - ghost_start_[size.row(y, z)];
      size.ghosts_below[y + 1] = ghosts;
    }
  }

  /// Find what else the particles of a class search: of two classes, that with fewer rows to search
  /// in all searches the other.
  void find_searched(std::size_t c)
  {
    searched_.clear();
    const SizeClass& size = classes_[c];
    const auto cost = [](const SizeClass& of, const SizeClass& in) {
      return of.local * in.rows_near(of.reach);
    };
    for (std::size_t o = 0; o < classes_.size(); ++o) {
      const SizeClass& other = classes_[o];
      if (o == c) continue;
      const double own = cost(size, other), others = cost(other, size);
      searched_.push_back({&other, own < others || (own == others && c < o)});
    }
  }

  /// Return the row if it exists and has particles.
  bool occupied(const SizeClass& size, const std::vector<int>& start, int y, int z) const
  {
    if (start.empty() || y < 0 || y >= size.cells[1] || z < 0 || z >= size.cells[2]) return false;
    const int row = size.row(y, z);
    return start[row] < start[row + size.cells[0]];
  }

  template <class Visit>
  void visit_row(const SizeClass& size, int y, int z, const Visit& visit)
  {
    if (!occupied(size, start_, y, z)) return;
    const int row = size.row(y, z);
    constexpr int most_rows = 4 + 9;
    const int* rows[most_rows];  // first particles of their cells
    int count = 0;
    for (const auto& [dy, dz] : {std::pair{1, 0}, {-1, 1}, {0, 1}, {1, 1}})
      if (occupied(size, start_, y + dy, z + dz)) rows[count++] = &start_[size.row(y + dy, z + dz)];
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy)
        if (occupied(size, ghost_start_, y + dy, z + dz))
          rows[count++] = &ghost_start_[size.row(y + dy, z + dz)];
    for (int at = start_[row]; at < start_[row + size.cells[0]]; ++at) {
      const Centre centre{x_[at], y_[at], z_[at], reach_[at]};
      const double width = allowance * (centre.reach + size.reach);
      const int low = size.at(0, centre.x - width), high = size.at(0, centre.x + width) + 1;
      if (spans_.size() < 1 + most_rows) spans_.resize(1 + most_rows);
      spans_[0] = {at + 1, start_[row + high]};
      int most = Candidates::spare + spans_[0].end - spans_[0].first;
      for (int k = 0; k < count; ++k) {
        const Span span{rows[k][low], rows[k][high]};
        spans_[1 + k] = span;
        most += span.end - span.first;
      }
      int spans = 1 + count;
      for (const Searched& other : searched_) most += add_spans(other, centre, spans);
      visit(index_[at], centre,
            Candidates{x_.data(), y_.data(), z_.data(), reach_.data(), index_.data(), spans_.data(),
                       spans, most});
    }
  }

  /// Add the spans of another class that a particle searches. Return the number of candidates.
  int add_spans(const Searched& other, const Centre& centre, int& spans)
  {
    const SizeClass& size = *other.size;
    const double width = allowance * (centre.reach + size.reach);
    const int first = size.at(1, centre.y - width), last = size.at(1, centre.y + width);
    const bool ghosts =
        !ghost_start_.empty() && size.ghosts_below[first] < size.ghosts_below[last + 1];
    if (!other.local && !ghosts) return 0;
    const int low = size.at(0, centre.x - width), high = size.at(0, centre.x + width) + 1;
    const int bottom = size.at(2, centre.z - width), top = size.at(2, centre.z + width);
    const std::size_t most = spans + 2 * static_cast<std::size_t>(last - first + 1) *
                                         static_cast<std::size_t>(top - bottom + 1);
    if (spans_.size() < most) spans_.resize(2 * most);
    int candidates = 0;
    for (int z = bottom; z <= top; ++z)
      for (int y = first; y <= last; ++y) {
        const int row = size.row(y, z);
        const auto add = [&](const std::vector<int>& start) {
          const Span span{start[row + low], start[row + high]};
          if (span.first == span.end) return;
          spans_[spans++] = span;
          candidates += span.end - span.first;
        };
        if (other.local) add(start_);
        if (ghosts) add(ghost_start_);
      }
    return candidates;
  }

  std::vector<SizeClass> classes_;
  std::vector<Searched> searched_;
  std::size_t cells_ = 0;
  int nlocal_ = 0;
  std::vector<signed char> class_of_;  ///< of each particle, if there are several classes
  std::vector<int> cell_of_;
  std::vector<int> start_, ghost_start_;  ///< first local particle and ghost of each cell
  std::vector<double> x_, y_, z_, reach_;
  std::vector<int> index_;
  std::vector<Span> spans_;
};

}  // namespace millscale::neighbor
