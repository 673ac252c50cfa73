#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/liner/frame.h"
#include "core/math/constants.h"
#include "core/math/format.h"

namespace millscale::charge {

/// Rings of equal width from the axis to `reach`, the largest distance of a ball's centre, R - a,
/// and equal sectors from the top on down the rising side, in the frame fixed in space.
struct PolarCells {
  std::size_t rings, sectors;
  double reach;  ///< [m]
};

/// A grid of more cells than this has none that a ball of any mill fills.
inline constexpr std::size_t most_cells = 10'000'000;

/// One cell: its borders over `reach` and from the vertical [rad]; its share of solid volume.
struct OccupancyCell {
  double radius_low, radius_high, angle_low, angle_high, solid_fraction;
};

/// Volume of the balls whose centre is in a cell, over the volume of the cell, averaged over
/// samples. A ball counts whole where its centre is: the grid is that of the centres' paths, and
/// the lifters, which reach into its outer rings, are not taken off the cells.
class OccupancyGrid {
 public:
  /// Throws std::invalid_argument for a grid without cells.
  explicit OccupancyGrid(const PolarCells& cells) : cells_(cells)
  {
    if (cells.rings == 0 || cells.sectors == 0)
      throw std::invalid_argument("rings and sectors must be > 0, got " +
                                  std::to_string(cells.rings) + " and " +
                                  std::to_string(cells.sectors));
    if (cells.rings > most_cells / cells.sectors)
      throw std::invalid_argument("rings times sectors must be <= " + std::to_string(most_cells) +
                                  ", which take 80 MB on every rank, got " +
                                  std::to_string(cells.rings) + " times " +
                                  std::to_string(cells.sectors));
    if (!(cells.reach > 0.0))
      throw std::invalid_argument("R - a must be > 0 m, got " + format(cells.reach));
    volume_.assign(cells.rings * cells.sectors, 0.0);
  }

  /// Adds a ball by its centre, from the axis; one beyond `reach`, as far as it overlaps the wall,
  /// is in the last ring. One that is no number is left out.
  void add(liner::Point centre, double radius)
  {
    if (!std::isfinite(centre.x + centre.z)) return;
    const double turn = 0.5 - liner::polar_angle(centre) / (2.0 * pi);
    const auto part = [](double share, std::size_t n) {
      return std::min(static_cast<std::size_t>(share * static_cast<double>(n)), n - 1);
    };
    const double square = centre.x * centre.x + centre.z * centre.z;
    const double distance = std::min(std::sqrt(square) / cells_.reach, 1.0);
    volume_[part(distance, cells_.rings) * cells_.sectors + part(turn, cells_.sectors)] +=
        ball_volume(radius);
  }

  /// Sums over the samples so far, ring by ring [m^3].
  std::vector<double>& volumes() { return volume_; }
  const std::vector<double>& volumes() const { return volume_; }

  /// One cell of an average over `samples` in a mill of `length` [m]. `sums` are the volumes() of
  /// all ranks.
  OccupancyCell cell(std::size_t index, const std::vector<double>& sums, double samples,
                     double length) const
  {
    const std::size_t ring = index / cells_.sectors, sector = index % cells_.sectors;
    const double width = 2.0 * pi / static_cast<double>(cells_.sectors);
    const auto rings = static_cast<double>(cells_.rings);
    OccupancyCell c{static_cast<double>(ring) / rings, static_cast<double>(ring + 1) / rings,
                    static_cast<double>(sector) * width, static_cast<double>(sector + 1) * width,
                    0.0};
    const double area = 0.5 * width * cells_.reach * cells_.reach *
                        (c.radius_high * c.radius_high - c.radius_low * c.radius_low);
    c.solid_fraction = sums[index] / (samples * area * length);
    return c;
  }

 private:
  PolarCells cells_;
  std::vector<double> volume_;
};

}  // namespace millscale::charge
