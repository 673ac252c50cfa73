#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/liner/nearest.h"
#include "core/liner/profile.h"

namespace millscale::liner {

/// The pieces of a profile that are near a point: square cells of the cross-section in the frame of
/// a sector's centre line, each with the indices in Profile::around() of the pieces within a reach.
/// The cost of a look-up does not depend on the number of pieces.
class PieceGrid {
 public:
  /// Indices of pieces, ascending.
  struct Range {
    const int *first, *last;

    const int* begin() const { return first; }
    const int* end() const { return last; }
  };

  /// reach: largest distance of a listed piece from a point of the cell [m]. width: of a cell [m];
  /// larger where there would be too many cells.
  PieceGrid(const Profile& profile, double reach, double width)
  {
    choose_cells(profile, reach, width);
    std::vector<std::vector<int>> lists(columns_ * rows_);
    const double half_diagonal = std::sqrt(0.5) / per_width_ + 1e-9 * profile.radius();
    for (std::size_t i = 0; i < profile.around().size(); ++i) {
      const Piece& piece = profile.around()[i].piece;
      const double sagitta =
          piece.is_arc() ? std::abs(piece.arc_radius) * (1.0 - std::cos(piece.half_angle)) : 0.0;
      const double far = reach + half_diagonal + sagitta;
      const auto [low_radial, high_radial] = std::minmax(piece.begin.radial, piece.end.radial);
      const auto [low_tangential, high_tangential] =
          std::minmax(piece.begin.tangential, piece.end.tangential);
      const std::size_t last_column = column(high_radial + far),
                        last_row = row(high_tangential + far);
      for (std::size_t c = column(low_radial - far); c <= last_column; ++c)
        for (std::size_t r = row(low_tangential - far); r <= last_row; ++r) {
          const Local centre = centre_of(c, r);
          if (!is_of_sector(profile, centre, half_diagonal)) continue;
          if (length(centre - detail::nearest_on(piece, centre).point) <= reach + half_diagonal)
            lists[c * rows_ + r].push_back(static_cast<int>(i));
        }
    }
    for (const std::vector<int>& list : lists) {
      begins_.push_back(static_cast<int>(pieces_.size()));
      pieces_.insert(pieces_.end(), list.begin(), list.end());
    }
    begins_.push_back(static_cast<int>(pieces_.size()));
    find_sides(profile, half_diagonal);
  }

  /// The pieces within the reach of a point of the sector, and perhaps some others.
  Range near(Local p) const
  {
    const int* begin = &begins_[column(p.radial) * rows_ + row(p.tangential)];
    return {pieces_.data() + begin[0], pieces_.data() + begin[1]};
  }

  /// Return whether a point of the sector is in the cavity. Only for cells without pieces nearby:
  /// such a cell lies on one side of the liner.
  bool is_clear(Local p) const
  {
    return side_[column(p.radial) * rows_ + row(p.tangential)] == Side::cavity;
  }

  /// The pieces within the reach of any point of the sector.
  std::vector<int> all() const
  {
    std::vector<int> result = pieces_;
    std::sort(result.begin(), result.end());
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
  }

 private:
  enum class Side : signed char { unknown, near_liner, cavity, wall };

  static constexpr double most_cells = 3e5;

  /// Cover the points of a sector that can be within the reach. Points beyond are in the cells at
  /// the border.
  void choose_cells(const Profile& profile, double reach, double width)
  {
    const double radius = profile.radius(), half_pitch = 0.5 * profile.pitch();
    const bool narrow = half_pitch <= 0.5 * pi;
    const double high = narrow ? radius * std::sin(half_pitch) : radius;
    low_ = {narrow ? std::max(0.0, profile.clear_radius() - reach) * std::cos(half_pitch) : -radius,
            -high};
    const double deep = radius - low_.radial, wide = 2.0 * high;
    width = std::max(width, std::sqrt(deep * wide / most_cells));
    per_width_ = 1.0 / width;
    columns_ = static_cast<std::size_t>(deep / width) + 1;
    rows_ = static_cast<std::size_t>(wide / width) + 1;
  }

  Local centre_of(std::size_t column, std::size_t row) const
  {
    return low_ + (1.0 / per_width_) * Local{column + 0.5, row + 0.5};
  }

  /// Return whether a cell with this centre has points of the sector.
  static bool is_of_sector(const Profile& profile, Local centre, double half_diagonal)
  {
    const double half_pitch = 0.5 * profile.pitch();
    const double beyond_border =
        std::abs(centre.tangential) * std::cos(half_pitch) - centre.radial * std::sin(half_pitch);
    return profile.sectors() == 1 || beyond_border <= half_diagonal;
  }

  /// Find the sides of the cells without pieces. Those that join lie on one side.
  void find_sides(const Profile& profile, double half_diagonal)
  {
    side_.assign(columns_ * rows_, Side::unknown);
    for (std::size_t k = 0; k < side_.size(); ++k)
      if (begins_[k] < begins_[k + 1] ||
          !is_of_sector(profile, centre_of(k / rows_, k % rows_), half_diagonal))
        side_[k] = Side::near_liner;
    std::vector<std::size_t> open;
    for (std::size_t k = 0; k < side_.size(); ++k) {
      if (side_[k] != Side::unknown) continue;
      const Local centre = centre_of(k / rows_, k % rows_);
      const Side side =
          detail::nearest_piece(profile, centre).distance >= 0.0 ? Side::cavity : Side::wall;
      const auto visit = [&](std::size_t cell) {
        if (side_[cell] != Side::unknown) return;
        side_[cell] = side;
        open.push_back(cell);
      };
      visit(k);
      while (!open.empty()) {
        const std::size_t cell = open.back(), row = cell % rows_;
        open.pop_back();
        if (row > 0) visit(cell - 1);
        if (row + 1 < rows_) visit(cell + 1);
        if (cell >= rows_) visit(cell - rows_);
        if (cell + rows_ < side_.size()) visit(cell + rows_);
      }
    }
  }

  std::size_t column(double radial) const { return cell(radial - low_.radial, columns_); }
  std::size_t row(double tangential) const { return cell(tangential - low_.tangential, rows_); }
  std::size_t cell(double from_low, std::size_t count) const
  {
    const double place = from_low * per_width_;
    if (!(place > 0.0)) return 0;  // also for NaN
    return place < static_cast<double>(count) ? static_cast<std::size_t>(place) : count - 1;
  }

  Local low_{};
  double per_width_ = 1.0;  ///< cells per length [1/m]
  std::size_t columns_ = 1, rows_ = 1;
  std::vector<int> begins_;  ///< of the cells, column by column, in pieces_
  std::vector<int> pieces_;
  std::vector<Side> side_;  ///< of the cells
};

}  // namespace millscale::liner
