#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/neighbor/cell_grid.h"
#include "core/neighbor/particles.h"

namespace millscale::neighbor {

/// The largest speed in each cell of a grid and the 26 cells around it.
class SpeedMap {
 public:
  /// Make the map of particles within these bounds, in cells of this edge [m] or wider. speed: of
  /// each particle [m/s].
  void make(const Particles& particles, Bounds bounds, double edge, const std::vector<float>& speed)
  {
    lay_out(bounds, particles.total(), edge);
    cell_of_.resize(particles.total());
    const int count = cells_[0] * cells_[1] * cells_[2];
    for (auto* cells : {&largest_, &around_}) cells->assign(count, 0.0F);
    for (int i = 0; i < particles.total(); ++i) {
      float& largest = largest_[cell_of_[i] = cell(particles.position[i])];
      largest = std::max(largest, speed[i]);
    }
    for (const int step : {1, cells_[0], cells_[0] * cells_[1]}) {
      const float* const from = largest_.data();
      float* const to = around_.data();
      for (int c = step; c < count - step; ++c)
        to[c] = std::max(std::max(from[c - step], from[c + step]), from[c]);
      std::swap(largest_, around_);
    }
  }

  /// Return the largest speed around a particle.
  float around(int i) const { return largest_[cell_of_[i]]; }

 private:
  void lay_out(const Bounds& bounds, int particles, double edge)
  {
    for (;; edge *= 1.3) {
      double count = 1.0;
      for (int d = 0; d < 3; ++d) {
        // A layer of empty cells around the grid saves tests at its boundary. Without particles,
        // high - low is minus infinity.
        cells_[d] =
            3 + static_cast<int>(std::clamp((bounds.high[d] - bounds.low[d]) / edge, 0.0, 1e4));
        low_[d] = bounds.low[d];
        count *= cells_[d];
      }
      if (count < 64.0 + 8.0 * particles) break;
    }
    inverse_edge_ = 1.0 / edge;
  }

  int cell(const double* x) const
  {
    int at[3];
    for (int d = 0; d < 3; ++d)
      at[d] = 1 + static_cast<int>(
                      std::min(cells_[d] - 3.0, std::max(0.0, (x[d] - low_[d]) * inverse_edge_)));
    return at[0] + cells_[0] * (at[1] + cells_[1] * at[2]);
  }

  double low_[3], inverse_edge_ = 1.0;
  int cells_[3];
  std::vector<int> cell_of_;
  std::vector<float> largest_, around_;
};

}  // namespace millscale::neighbor
