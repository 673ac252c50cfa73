#include <gtest/gtest.h>

#include "core/contact/contact_force.h"
#include "core/contact/hertz_mindlin.h"

namespace {

using namespace millscale::contact;
using millscale::dot;
using millscale::Vector;
using millscale::vector3;

const Material ball_material{5.98e7, 0.3, 2678.0};
constexpr double ball_radius = 0.02;

/// Coefficients of friction [-].
struct Friction {
  double sliding, rolling;
};

struct Touch {
  double overlap;
  Vector normal, velocity, spin;
};

/// Force of a flat wall on the ball. Advances the tangential displacement by dt; dt = 0 keeps it.
ContactForce<double> wall_force(const Pair& pair, const Friction& friction, const Touch& touch,
                                double dt, Vector& displacement)
{
  const auto law = contact_law(
      {pair.youngs_modulus, pair.shear_modulus, pair.damping, friction.sliding, friction.rolling});
  const auto force =
      contact_force(contact_of(BallOnWall<double>{vector3(touch.normal), touch.overlap, pair.radius,
                                                  pair.mass, vector3(touch.velocity),
                                                  vector3(touch.spin), vector3(displacement), 0.0}),
                    law, {}, dt, dt > 0.0);
  displacement = millscale::to_array(force.displacement);
  return force;
}

struct Impact {
  Vector velocity, spin;
  double largest_energy;  ///< relative to the energy before
};

double kinetic(const Pair& pair, const Vector& v, const Vector& w)
{
  const double inertia = 0.4 * pair.mass * pair.radius * pair.radius;
  return 0.5 * pair.mass * dot(v, v) + 0.5 * inertia * dot(w, w);
}

/// Impact of a ball on the flat wall y = 0 at an incidence [rad] from the normal. Velocity Verlet
/// with forces at the half step, as in the engine.
Impact impact(double restitution, const Friction& friction, double speed, double incidence,
              double dt)
{
  const Pair pair = ball_on_wall(ball_material, ball_material, ball_radius, restitution);
  const double inertia = 0.4 * pair.mass * ball_radius * ball_radius;
  Vector v{speed * std::sin(incidence), -speed * std::cos(incidence), 0.0}, w{}, displacement{};
  double height = ball_radius;
  Vector force{}, torque{};
  Impact result{{}, {}, 0.0};
  const double before = kinetic(pair, v, w);
  for (int step = 0; step < 10'000'000; ++step) {
    for (int d = 0; d < 3; ++d) {
      v[d] += 0.5 * dt * force[d] / pair.mass;
      w[d] += 0.5 * dt * torque[d] / inertia;
    }
    height += dt * v[1];
    if (height >= ball_radius) break;
    const auto on_ball =
        wall_force(pair, friction, {ball_radius - height, {0.0, 1.0, 0.0}, v, w}, dt, displacement);
    force = millscale::to_array(on_ball.force);
    torque = millscale::to_array(on_ball.torque_i);
    for (int d = 0; d < 3; ++d) {
      v[d] += 0.5 * dt * force[d] / pair.mass;
      w[d] += 0.5 * dt * torque[d] / inertia;
    }
    result.largest_energy = std::max(result.largest_energy, kinetic(pair, v, w) / before);
  }
  result.velocity = v;
  result.spin = w;
  return result;
}

TEST(WallContact, RestitutionIsAsRequested)
{
  // First order in dt: at a two-thousandth of the impact's duration the error is below 1e-3.
  for (double e : {0.1, 0.2, 0.5, 0.8, 1.0})
    EXPECT_NEAR(impact(e, {0.0, 0.0}, 3.9, 0.0, 2e-6).velocity[1] / 3.9, e, 2e-3) << e;
}

TEST(WallContact, ElasticImpactReachesHertzOverlapAndDuration)
{
  const Pair pair = ball_on_wall(ball_material, ball_material, ball_radius, 1.0);
  const double dt = 1e-6, speed = 2.0;
  Vector displacement{}, v{0.0, -speed, 0.0};
  double height = ball_radius, deepest = 0.0, time = 0.0;
  double force = 0.0;
  do {
    v[1] += 0.5 * dt * force / pair.mass;
    height += dt * v[1];
    if (height >= ball_radius) break;
    force = wall_force(pair, {0.0, 0.0}, {ball_radius - height, {0, 1, 0}, v, {}}, dt, displacement)
                .force.y;
    v[1] += 0.5 * dt * force / pair.mass;
    deepest = std::max(deepest, ball_radius - height);
    time += dt;
  } while (time < 1.0);
  EXPECT_NEAR(deepest / hertz_overlap(pair, speed), 1.0, 1e-4);
  EXPECT_NEAR(time / hertz_collision_time(pair, speed), 1.0, 1e-3);
}

TEST(WallContact, KineticEnergyNeverRisesAtAnyIncidence)
{
  const double degree = std::acos(-1.0) / 180.0;
  for (double e : {0.2, 0.98})
    for (double mu : {0.092, 0.5})
      for (int angle = 5; angle <= 85; angle += 5) {
        const Impact after = impact(e, {mu, 0.01}, 3.9, angle * degree, 5e-6);
        // The elastic forces return at most the energy they stored; 1e-3 is the error of the step.
        EXPECT_LE(after.largest_energy, 1.0 + 1e-3) << e << " " << mu << " " << angle;
      }
}

TEST(WallContact, GrossSlidingFollowsTheClosedForm)
{
  // v_t'/v_t = 1 - mu (1 + e) cot(theta), omega' = -(5/2) mu (1 + e) v_n / R (rigid-body impulse).
  const double mu = 0.092, e = 1.0, theta = 70.0 * std::acos(-1.0) / 180.0, speed = 3.9;
  const Impact after = impact(e, {mu, 0.0}, speed, theta, 1e-6);
  EXPECT_NEAR(after.velocity[0] / (speed * std::sin(theta)), 1.0 - mu * (1 + e) / std::tan(theta),
              1e-3);
  // The lever arm is the radius less half the overlap, so the spin is too small by at most this
  // fraction.
  const double spin = 2.5 * mu * (1 + e) * speed * std::cos(theta) / ball_radius;
  const Pair pair = ball_on_wall(ball_material, ball_material, ball_radius, e);
  const double shortest = 1.0 - 0.5 * hertz_overlap(pair, speed * std::cos(theta)) / ball_radius;
  EXPECT_LT(std::abs(after.spin[2]) / spin, 1.0);
  EXPECT_GT(std::abs(after.spin[2]) / spin, shortest - 1e-3);
}

TEST(WallContact, RollingFrictionOpposesTheSpinAndIgnoresTwist)
{
  const Pair pair = ball_on_wall(ball_material, ball_material, ball_radius, 0.2);
  Vector displacement{};
  const double overlap = 1e-4;
  const Touch rolling{overlap, {0, 1, 0}, {0, 0, 0}, {0, 0, 3.0}};
  const double elastic = coefficients(pair, overlap).normal_stiffness * overlap;
  const auto without = wall_force(pair, {0.0, 0.0}, rolling, 1e-5, displacement).torque_i;
  const auto with = wall_force(pair, {0.0, 0.01}, rolling, 1e-5, displacement).torque_i;
  EXPECT_NEAR(with.z - without.z, -0.01 * elastic * ball_radius, 1e-12 * elastic);

  const Touch twisting{overlap, {0, 1, 0}, {0, 0, 0}, {0, 3.0, 0}};
  const auto twist = wall_force(pair, {0.5, 0.01}, twisting, 1e-5, displacement).torque_i;
  EXPECT_NEAR(twist.y, 0.0, 1e-15);
}

TEST(WallContact, AtSetUpTheDisplacementIsUsedAndNotChanged)
{
  const Pair pair = ball_on_wall(ball_material, ball_material, ball_radius, 0.2);
  const Touch sliding{1e-4, {0, 1, 0}, {0.3, 0, 0}, {}};
  Vector displacement{-2e-6, 0.0, 0.0};
  const Vector before = displacement;
  wall_force(pair, {0.5, 0.0}, sliding, 0.0, displacement);
  EXPECT_EQ(displacement, before);
  wall_force(pair, {0.5, 0.0}, sliding, 1e-6, displacement);
  EXPECT_NE(displacement, before);
}

TEST(WallContact, SlidingForceIsCoulombs)
{
  const Pair pair = ball_on_wall(ball_material, ball_material, ball_radius, 1.0);
  Vector displacement{1e-3, 0.0, 0.0};  // far beyond the limit
  const auto on_ball =
      wall_force(pair, {0.5, 0.0}, {1e-4, {0, 1, 0}, {1, 0, 0}, {}}, 1e-6, displacement);
  EXPECT_NEAR(on_ball.force.x, -0.5 * on_ball.force.y, 1e-12 * on_ball.force.y);
}

}  // namespace
