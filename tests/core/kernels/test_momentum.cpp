#include <gtest/gtest.h>

#include "core/kernels/evaluation.h"

namespace {

using namespace kernel_test;

/// Momentum and angular momentum about the origin of a cloud of balls, and the sums of their
/// magnitudes.
struct Momenta {
  millscale::Vector linear{}, angular{};
  double linear_sizes = 0.0, angular_sizes = 0.0;
};

Momenta momenta(const Cloud& cloud)
{
  using written_out::sum;
  Momenta total;
  for (int i = 0; i < cloud.all(); ++i) {
    const double m = cloud.mass[i], inertia = 0.4 * m * cloud.radius[i] * cloud.radius[i];
    const millscale::Vector orbital = millscale::cross(cloud.position[i], cloud.velocity[i]);
    total.linear = sum(total.linear, m, cloud.velocity[i]);
    total.angular = sum(sum(total.angular, m, orbital), inertia, cloud.spin[i]);
    total.linear_sizes += m * written_out::size(cloud.velocity[i]);
    total.angular_sizes += m * written_out::size(orbital);
  }
  return total;
}

/// Sum of the magnitudes of all balls' changes of momentum in a step.
double impulses(const Evaluation& step)
{
  double sum = 0.0;
  for (const auto& force : step.force) sum += dt * written_out::size(force);
  return sum;
}

/// Update velocities from forces, then positions from velocities. This keeps the angular momentum
/// too.
void move(Evaluation& step, const Implementation& kernel)
{
  using written_out::sum;
  step.clear();
  step.with(kernel);
  Cloud& cloud = step.cloud;
  for (int i = 0; i < cloud.all(); ++i) {
    const double m = cloud.mass[i], inertia = 0.4 * m * cloud.radius[i] * cloud.radius[i];
    cloud.velocity[i] = sum(cloud.velocity[i], dt / m, step.force[i]);
    cloud.spin[i] = sum(cloud.spin[i], dt / inertia, step.torque[i]);
    cloud.position[i] = sum(cloud.position[i], dt, cloud.velocity[i]);
  }
}

TEST(Momentum, IsConservedToRoundOffInACloudWithoutWalls)
{
  // Each of 300 steps rounds the sum by 1e-16 of its terms, with either sign. Mixed kernels also
  // round the force on each ball from up to a dozen contacts. Lever arms are below 1 m.
  for (const Implementation& kernel : kernels()) {
    Evaluation step(random_cloud({300, 0.25, 0.01, 0.03, 2}, 10), 0.05);
    const Momenta before = momenta(step.cloud);
    const auto start = step.cloud.position;
    double rounded = 0.0;
    for (int n = 0; n < 300; ++n) {
      move(step, kernel);
      if (is_mixed(kernel)) rounded += 12 * 6e-8 * impulses(step);
    }
    const Momenta after = momenta(step.cloud);
    const auto change = [](const millscale::Vector& a, const millscale::Vector& b) {
      return written_out::size(written_out::sum(a, -1.0, b));
    };
    EXPECT_LT(change(after.linear, before.linear), 300e-16 * after.linear_sizes + rounded)
        << kernel.name;
    EXPECT_LT(change(after.angular, before.angular), 300e-16 * after.angular_sizes + rounded)
        << kernel.name;
    EXPECT_GT(change(step.cloud.position[0], start[0]), 1e-3);
  }
}

}  // namespace
