#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "core/kernels/kernel.h"
#include "core/neighbor/pair_list.h"

/// Balls with their arrays: local ones first, then ghosts.
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
  int nlocal() const { return all() - ghosts; }

  millscale::neighbor::Particles view() const
  {
    const auto rows = [](const std::vector<std::array<double, 3>>& field) {
      return reinterpret_cast<const double(*)[3]>(field.data());
    };
    return {rows(position), rows(velocity), rows(spin), radius.data(),
            mass.data(),    type.data(),    nlocal(),   ghosts};
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

/// Random balls in a cube about the origin, with random velocities and spins.
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

/// List the pairs whose surfaces are within `gap` [m].
inline void build_within(millscale::neighbor::PairList& list, millscale::neighbor::CellGrid& grid,
                         const Cloud& cloud, double gap,
                         millscale::neighbor::ListPartners list_partners)
{
  const std::vector<double> skin(cloud.all(), gap / 2);
  millscale::neighbor::build(list, grid, cloud.view(), skin.data(), list_partners);
}

inline void build_within(millscale::neighbor::PairList& list, const Cloud& cloud, double gap,
                         millscale::neighbor::ListPartners list_partners)
{
  millscale::neighbor::CellGrid grid;
  build_within(list, grid, cloud, gap, list_partners);
}

/// The implementations that this machine supports. Each mixed kernel is a further implementation,
/// whose `evaluate` is the mixed kernel.
inline std::vector<millscale::kernels::Implementation> kernels()
{
  std::vector<millscale::kernels::Implementation> found, mixed;
  for (const auto& each : millscale::kernels::implementations())
    if (each.supported()) found.push_back(each);
  for (auto kernel : found)
    if (kernel.evaluate_mixed) {
      kernel.evaluate = kernel.evaluate_mixed;
      kernel.evaluate_rows = kernel.evaluate_rows_mixed;
      kernel.name = "mixed";
      mixed.push_back(kernel);
    }
  found.insert(found.end(), mixed.begin(), mixed.end());
  return found;
}
