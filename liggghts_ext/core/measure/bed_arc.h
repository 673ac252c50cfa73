#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <vector>

namespace millscale::charge {

/// A run of bins of a circle: `count` bins from `first`, across the end to the beginning.
struct Arc {
  std::size_t first, count;
};

/// Return the arc with the high level of the two-level step that fits the values best, in the sense
/// of least squares; none if all values are equal. There is no parameter. The ends are resolved to
/// one bin; a gradual end lies at the middle of the two levels. Derived here.
///
/// With the means inside and outside as levels, a step of k of n bins explains n d^2 / (k (n - k))
/// of the sum of squares. d is the sum over the arc of the deviations from the overall mean. An arc
/// and its complement are one step, so all arcs up to n / 2 bins are tried.
inline std::optional<Arc> bed_arc(const std::vector<double>& value)
{
  const std::size_t n = value.size();
  const double mean = std::accumulate(value.begin(), value.end(), 0.0) / static_cast<double>(n);
  std::vector<double> below(2 * n + 1, 0.0);  // sum of the deviations of the bins before
  double scale = 0.0;
  for (std::size_t i = 0; i < 2 * n; ++i) {
    below[i + 1] = below[i] + (value[i % n] - mean);
    scale += value[i % n] * value[i % n];
  }
  double most = 1e-24 * scale;  // squared rounding of the sums is no step
  std::size_t width = 0;
  for (std::size_t k = 1; k <= n / 2; ++k) {
    double highest = 0.0, lowest = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const double inside = below[i + k] - below[i];
      highest = inside > highest ? inside : highest;
      lowest = inside < lowest ? inside : lowest;
    }
    const double extreme = std::max(highest, -lowest);
    const double explained =
        extreme * extreme * static_cast<double>(n) / (static_cast<double>(k) * (n - k));
    if (explained <= most) continue;
    most = explained;
    width = k;
  }
  if (width == 0) return std::nullopt;
  std::size_t first = 0;
  double inside = 0.0;
  for (std::size_t i = 0; i < n; ++i)
    if (const double sum = below[i + width] - below[i]; std::abs(sum) > std::abs(inside)) {
      inside = sum;
      first = i;
    }
  return inside > 0.0 ? Arc{first, width} : Arc{(first + width) % n, n - width};
}

}  // namespace millscale::charge
