#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "core/kernels/kernel.h"
#include "core/neighbor/pair_list.h"

/// Balls that own their arrays: the owned ones first, then ghosts.
struct Cloud {
  std::vector<std::array<double, 3>> position, velocity, spin;
  std::vector<double> radius, mass;
  std::vector<int> type;
  int ghosts = 0;

  void add(const std::array<double, 3>& x, double r, int t = 1)
  {
    position.push_back(x);
    velocity.push_back({});
    spin.push_back({});
    radius.push_back(r);
    mass.push_back(11217.0 * r * r * r);  // a ball of 2678 kg/m^3
    type.push_back(t);
  }
  int all() const { return static_cast<int>(radius.size()); }
  int owned() const { return all() - ghosts; }

  millscale::pairs::Balls view() const
  {
    const auto rows = [](const std::vector<std::array<double, 3>>& field) {
      return reinterpret_cast<const double(*)[3]>(field.data());
    };
    return {rows(position), rows(velocity), rows(spin), radius.data(),
            mass.data(),    type.data(),    owned(),    all()};
  }
};

/// A cloud's size and content.
struct CloudSize {
  int balls;
  double edge;                             ///< of the cube that holds the centres [m]
  double smallest = 0.02, largest = 0.02;  ///< radii [m]
  int types = 1;
  int ghosts = 0;
};

/// Balls at random in a cube about the origin, with random velocities and spins.
inline Cloud random_cloud(const CloudSize& size, unsigned seed)
{
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share;
  std::normal_distribution<double> normal;
  Cloud cloud;
  for (int i = 0; i < size.balls; ++i) {
    std::array<double, 3> x;
    for (double& coordinate : x) coordinate = size.edge * (share(random) - 0.5);
    const double radius = size.smallest + (size.largest - size.smallest) * share(random);
    cloud.add(x, radius, 1 + static_cast<int>(size.types * share(random)));
    for (int d = 0; d < 3; ++d) {
      cloud.velocity[i][d] = 0.3 * normal(random);
      cloud.spin[i][d] = 10.0 * normal(random);
    }
  }
  cloud.ghosts = size.ghosts;
  return cloud;
}

/// Lists the pairs whose surfaces are within `gap` [m].
inline void build_within(millscale::pairs::HalfList& list, millscale::pairs::CellGrid& grid,
                         const Cloud& cloud, double gap,
                         millscale::pairs::ListPartners list_partners)
{
  grid.sort(cloud.view(), gap / 2);
  const std::vector<double> margin(cloud.all(), gap / 2);
  millscale::pairs::build(list, grid, cloud.view(), margin.data(), list_partners);
}

inline void build_within(millscale::pairs::HalfList& list, const Cloud& cloud, double gap,
                         millscale::pairs::ListPartners list_partners)
{
  millscale::pairs::CellGrid grid;
  build_within(list, grid, cloud, gap, list_partners);
}

/// Those this machine can run. Mixed kernels stand for a level's own: their `evaluate` is theirs.
inline std::vector<millscale::pairs::Kernel> kernels()
{
  std::vector<millscale::pairs::Kernel> found, mixed;
  for (int level = 2; level <= 4; ++level)
    if (millscale::pairs::runs(level)) found.push_back(millscale::pairs::kernel(level));
  for (millscale::pairs::Kernel kernel : found)
    if (kernel.evaluate_mixed) {
      kernel.evaluate = kernel.evaluate_mixed;
      kernel.level = "mixed";
      mixed.push_back(kernel);
    }
  found.insert(found.end(), mixed.begin(), mixed.end());
  return found;
}
