#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

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
    const double half_pitch = 0.5 * profile.pitch();
    const Local across{-std::sin(half_pitch), std::cos(half_pitch)};  // to the border
    const auto of_sector = [&](Local p) {
      return profile.sectors() == 1 ||
             dot({p.radial, std::abs(p.tangential)}, across) <= half_diagonal;
    };
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
          const Local centre = low_ + (1.0 / per_width_) * Local{c + 0.5, r + 0.5};
          if (!of_sector(centre)) continue;
          if (length(centre - detail::nearest_on(piece, centre).point) <= reach + half_diagonal)
            lists[c * rows_ + r].push_back(static_cast<int>(i));
        }
    }
    for (const std::vector<int>& list : lists) {
      begins_.push_back(static_cast<int>(pieces_.size()));
      pieces_.insert(pieces_.end(), list.begin(), list.end());
    }
    begins_.push_back(static_cast<int>(pieces_.size()));
  }

  /// The pieces within the reach of a point of the sector, and perhaps some others.
  Range near(Local p) const
  {
    const int* begin = &begins_[column(p.radial) * rows_ + row(p.tangential)];
    return {pieces_.data() + begin[0], pieces_.data() + begin[1]};
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
};

}  // namespace millscale::liner
