#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <stdexcept>

#include "core/contact/time_step.h"

namespace {

using namespace millscale::contact;

const Material paper_ball{2.0 * 2.3e7 * 1.3, 0.3, 2678.0};

/// Largest excursion of x'' = -omega^2 x - 2 zeta omega x' from x = 1 over many velocity-Verlet
/// steps whose force sees the half-step velocity.
double excursion(double omega, double zeta, double dt)
{
  double x = 1.0, v = 0.0, largest = 1.0;
  for (int i = 0; i < 20000 && largest < 1e6; ++i) {
    v -= dt * (omega * omega * x + 2.0 * zeta * omega * v);
    x += dt * v;
    largest = std::fmax(largest, std::abs(x));
  }
  return largest;
}

/// Return whether velocity Verlet with the half-step velocities stays bounded. Two balls are in a
/// sticking tangential contact whose force accelerates and spins them. Slip rate: s' = v1 - v2 - r
/// (w1 + w2).
bool tangential_contact_is_stable(const Pair& pair, double radius, double overlap, double dt)
{
  const Coefficients c = coefficients(pair, overlap);
  const double mass = 2.0 * pair.mass, inertia = 0.4 * mass * radius * radius;
  double slip = 1e-6, largest = 0.0;
  std::array<double, 2> v{}, spin{};
  for (int i = 0; i < 20000 && largest < 1.0; ++i) {
    const double rate = v[0] - v[1] - radius * (spin[0] + spin[1]);
    const double force = -c.tangential_stiffness * slip - c.tangential_damping * rate;
    v[0] += dt * force / mass;
    v[1] -= dt * force / mass;
    for (double& w : spin) w -= dt * radius * force / inertia;
    slip += dt * (v[0] - v[1] - radius * (spin[0] + spin[1]));
    largest = std::fmax(largest, std::abs(slip));
  }
  return largest < 1.0;
}

TEST(TimeStep, RayleighTimeOfThePapersBall)
{
  EXPECT_NEAR(rayleigh_time(paper_ball, 0.02), 7.33e-4, 0.005e-4);
}

TEST(TimeStep, RayleighTimeIsTheTravelTimeOfARayleighWave)
{
  // At nu = 1/4 the Rayleigh speed is sqrt(2 - 2/sqrt(3)) of the shear speed. The fit is within
  // 1 %.
  const Material m{1e9, 0.25, 2500.0};
  const double speed = std::sqrt(2.0 - 2.0 / std::sqrt(3.0)) * std::sqrt(shear_modulus(m) / 2500.0);
  EXPECT_NEAR(rayleigh_time(m, 0.02) * speed / (millscale::pi * 0.02), 1.0, 0.01);
}

TEST(TimeStep, DampedModeIsStableUpToItsLimitAndNotBeyond)
{
  for (const double zeta : {0.0, 0.1, 0.54, 1.01, 3.0}) {
    const double limit = damped_mode_limit(100.0, zeta);
    EXPECT_NEAR(limit, 2.0 * (std::sqrt(1.0 + zeta * zeta) - zeta) / 100.0, 1e-15);
    EXPECT_LT(excursion(100.0, zeta, 0.99 * limit), 50.0) << "zeta " << zeta;
    EXPECT_GE(excursion(100.0, zeta, 1.01 * limit), 1e6) << "zeta " << zeta;
  }
}

TEST(TimeStep, TwoBallsSpinUpJustBeyondTheLimit)
{
  for (const double e : {0.1, 0.5, 1.0}) {
    const Pair pair = ball_on_ball(paper_ball, 0.02, e);
    const double overlap = 0.16e-3, limit = damping_time_step_limit(pair, overlap);
    EXPECT_TRUE(tangential_contact_is_stable(pair, 0.02, overlap, 0.99 * limit)) << "e " << e;
    EXPECT_FALSE(tangential_contact_is_stable(pair, 0.02, overlap, 1.01 * limit)) << "e " << e;
  }
}

TEST(TimeStep, TangentialModeActsOnTwoSeventhsOfTheMass)
{
  const Pair pair = ball_on_ball(paper_ball, 0.02, 0.1);
  const Coefficients c = coefficients(pair, 1e-4);
  const double mass = 2.0 / 7.0 * pair.mass;
  const double zeta = 0.5 * c.tangential_damping / std::sqrt(c.tangential_stiffness * mass);
  EXPECT_NEAR(zeta, 1.01, 0.005);
  EXPECT_NEAR(damping_time_step_limit(pair, 1e-4),
              damped_mode_limit(std::sqrt(c.tangential_stiffness / mass), zeta), 1e-15);
}

TEST(TimeStep, BedOfThePaperIsLimitedToATenthOfAMillisecond)
{
  // Coordination 4, mean overlap 0.16 mm in the settled S = 2.6 mill. The stock scheme becomes
  // unstable between 1e-4 and 2e-4 s.
  const Pair pair = ball_on_ball(paper_ball, 0.02, 0.1);
  EXPECT_NEAR(damping_time_step_limit(pair, 0.16e-3, 4.0), 1.0e-4, 0.05e-4);
}

/// Largest speed of the tangential mode in 2,000 steps from an initial speed. The balls have many
/// contacts in the worst phase. Damping is limited by the sum over all contacts: x' = x + dt v, v'
/// = v - dt (k x' + c v).
double bounded_excursion(const Pair& pair, double overlap, double contacts, double dt)
{
  const Coefficients c = coefficients(pair, overlap);
  const double mass = 2.0 / 7.0 * pair.mass, ball = 2.0 * pair.mass;
  const double of_ball = contacts * c.tangential_damping;  // D of either of two balls
  const double damping = of_ball / (1.0 + dt * (of_ball / ball + of_ball / ball));
  double x = 0.0, v = 1.0, largest = 0.0;
  for (int step = 0; step < 2000; ++step) {
    x += dt * v;
    v -= dt * (contacts * c.tangential_stiffness * x + damping * v) / mass;
    largest = std::fmax(largest, std::abs(v));
  }
  return largest;
}

TEST(TimeStep, BoundedDampingIsStableUpToItsOwnLimit)
{
  for (const double e : {0.1, 0.5, 0.98})
    for (const double contacts : {1.0, 4.0, 8.0}) {
      const Pair pair = ball_on_ball(paper_ball, 0.02, e);
      const double plain = damping_time_step_limit(pair, 0.16e-3, contacts);
      const double bounded = damping_time_step_limit(pair, 0.16e-3, contacts, true);
      EXPECT_GE(bounded, plain);
      EXPECT_LT(bounded_excursion(pair, 0.16e-3, contacts, 0.99 * bounded), 50.0) << e << contacts;
      // At small restitution the tangential mode sets the limit, not the normal mode.
      if (e < 0.5) {
        EXPECT_GT(bounded_excursion(pair, 0.16e-3, contacts, 1.01 * bounded), 1e6);
      }
    }
}

TEST(TimeStep, BedOfThePaperTakesStepsOfSeventeenHundredthsOfAMillisecondIfBounded)
{
  const Pair pair = ball_on_ball(paper_ball, 0.02, 0.1);
  EXPECT_NEAR(damping_time_step_limit(pair, 0.16e-3, 4.0, true), 1.73e-4, 0.005e-4);
}

TEST(TimeStep, LimitScalesAsSimilarityAsks)
{
  // S_n ~ sqrt(overlap), so omega ~ overlap^(1/4) at constant damping ratio.
  const Pair pair = ball_on_ball(paper_ball, 0.02, 0.1);
  EXPECT_NEAR(damping_time_step_limit(pair, 1e-4) / damping_time_step_limit(pair, 16e-4), 2.0,
              1e-12);
  // A ball twice as large at the same relative overlap: stiffness x2, mass x8.
  const Pair large = ball_on_ball(paper_ball, 0.04, 0.1);
  EXPECT_NEAR(damping_time_step_limit(large, 2e-4) / damping_time_step_limit(pair, 1e-4), 2.0,
              1e-12);
}

TEST(TimeStep, RefusesImpossibleInput)
{
  const Pair pair = ball_on_ball(paper_ball, 0.02, 0.1);
  EXPECT_THROW(damping_time_step_limit(pair, 0.0), std::invalid_argument);
  EXPECT_THROW(damping_time_step_limit(pair, 1e-4, 0.5), std::invalid_argument);
  EXPECT_THROW(damping_time_step_limit(pair, 1e-4, NAN), std::invalid_argument);
  EXPECT_THROW(rayleigh_time(paper_ball, 0.0), std::invalid_argument);
  EXPECT_THROW(rayleigh_time({6e7, 0.3, -1.0}, 0.02), std::invalid_argument);
}

TEST(TimeStep, ABedSinksIntoItselfByTheWeightAbove)
{
  // The paper's S = 2.6 mill: 0.16 mm of 20 mm balls.
  EXPECT_NEAR(bed_overlap({5.98e7, 0.3, 2678.0}, 9.81, 1.5) * 20.0, 0.16, 0.005);
  // An eighth of the modulus gives four times the overlap.
  EXPECT_NEAR(
      bed_overlap({1e7, 0.3, 7800.0}, 9.81, 1.0) / bed_overlap({8e7, 0.3, 7800.0}, 9.81, 1.0), 4.0,
      1e-12);
  EXPECT_THROW(bed_overlap({0.0, 0.3, 2678.0}, 9.81, 1.5), std::invalid_argument);
}

}  // namespace
