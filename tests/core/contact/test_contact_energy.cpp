#include <gtest/gtest.h>

#include <random>

#include "core/contact/contact_energy.h"
#include "core/contact/hertz_mindlin.h"
#include "core/contact/written_out.h"
#include "core/energy/energy_budget.h"

namespace {

using namespace millscale::contact;
using millscale::dot;
using millscale::to_array;
using millscale::Vector;
using millscale::vector3;
using millscale::Vector3;
namespace energy = millscale::energy;

constexpr double radius = 0.02, mass = 0.09, inertia = 0.4 * mass * radius * radius;
constexpr double young = 3.3e7, shear = 7.0e6;
double size_of(const Vector& a)
{
  return std::sqrt(dot(a, a));
}

constexpr double head_on = 1.0;  // relative speed [m/s]

struct Ball {
  Vector place, velocity, spin{};
  Loads loads{};
};

/// Collision of two equal balls along x with the engine's steps, and its energy budget.
struct Collision {
  double restitution, sliding, rolling_friction, dt;
  ContactTerms terms{};
  double hardness = 1.0;  ///< factor of both moduli
  Ball i{{0.0, 0.0, 0.0}, {-0.5 * head_on, 0.0, 0.0}};
  Ball j{{-2.0 * radius - 1e-12, 0.0, 0.0}, {0.5 * head_on, 0.0, 0.0}};
  Vector3<double> displacement{0.0, 0.0, 0.0};
  energy::WorkSums work{};
  energy::Stored stored{};
  double slip = 0.0, touched = 0.0;

  double kinetic() const
  {
    double sum = 0.0;
    for (const Ball* b : {&i, &j})
      sum += 0.5 * mass * dot(b->velocity, b->velocity) + 0.5 * inertia * dot(b->spin, b->spin);
    return sum;
  }

  Vector total(const Ball& b, int from) const
  {
    Vector sum{};
    for (const Load& load : b.loads)
      for (int d = 0; d < 3; ++d) sum[d] += load[from + d];
    return sum;
  }

  void kick(double duration)
  {
    for (Ball* b : {&i, &j})
      for (int d = 0; d < 3; ++d) {
        b->velocity[d] += duration / mass * total(*b, 0)[d];
        b->spin[d] += duration / inertia * total(*b, 3)[d];
      }
  }

  void press()
  {
    i.loads = j.loads = {};
    stored = {};
    BallPair<double> pair;
    pair.separation = vector3(i.place) - vector3(j.place);
    pair.r2 = dot(pair.separation, pair.separation);
    pair.radius_i = pair.radius_j = radius;
    pair.mass_i = pair.mass_j = mass;
    pair.velocity = vector3(i.velocity) - vector3(j.velocity);
    pair.spin_i = vector3(i.spin);
    pair.spin_j = vector3(j.spin);
    pair.displacement = displacement;
    if (!(pair.r2 < 4.0 * radius * radius)) return;
    const auto law = contact_law({hardness * young, hardness * shear, damping_factor(restitution),
                                  sliding, rolling_friction});
    const auto contact = contact_of(pair);
    const auto force = contact_force(contact, law, terms, dt, true);
    displacement = force.displacement;
    const EvaluatedContact evaluated(contact, force);
    evaluated.add_loads_on_i(i.loads);
    evaluated.add_loads_on_j(j.loads);
    stored = {evaluated.normal_energy(), evaluated.tangential_energy()};
    slip += evaluated.slip_work();
    touched += dt;
  }

  energy::Works powers(double shift) const
  {
    energy::Works sum;
    for (const Ball* b : {&i, &j}) {
      Vector v, w;
      for (int d = 0; d < 3; ++d) {
        v[d] = b->velocity[d] + shift / mass * total(*b, 0)[d];
        w[d] = b->spin[d] + shift / inertia * total(*b, 3)[d];
      }
      for (int k = 0; k < works; ++k)
        sum.on_balls[energy::ball_ball][k] += power(b->loads[k], v, w);
    }
    return sum;
  }

  void step()
  {
    kick(0.5 * dt);
    for (Ball* b : {&i, &j})
      for (int d = 0; d < 3; ++d) b->place[d] += dt * b->velocity[d];
    press();
    kick(0.5 * dt);
    work.step(powers(-0.25 * dt), powers(0.25 * dt), dt);
  }

  /// Step until the balls separate.
  void collide()
  {
    do step();
    while (stored.normal > 0.0);
  }

  energy::PairingTerms terms_now() const
  {
    return energy::terms_of(work.done.on_balls[energy::ball_ball], {}, stored, slip);
  }
};

double work_of_all(const Collision& c)
{
  double sum = 0.0;
  for (const double w : c.work.done.on_balls[energy::ball_ball]) sum += w;
  return sum;
}

constexpr double impact_energy = 0.5 * (0.5 * mass) * head_on * head_on;

/// Duration of an elastic impact by Hertz: 2.94 (largest overlap) / speed [s].
double duration()
{
  const double effective = 0.5 * mass, stiffness = 4.0 / 3.0 * young * std::sqrt(0.5 * radius);
  const double overlap = std::pow(1.25 * effective * head_on * head_on / stiffness, 0.4);
  return 2.94 * overlap / head_on;
}

TEST(ContactEnergy, KickByKickTheWorkIsTheChangeOfKineticEnergy)
{
  Collision c{0.3, 0.4, 0.02, duration() / 40.0};
  c.i.velocity = {-0.5, 0.7, -0.3};
  c.i.spin = {5.0, -20.0, 40.0};
  c.j.spin = {-9.0, 3.0, 7.0};
  const double before = c.kinetic();
  c.collide();
  // Each of the two sums has some hundred terms of this size.
  EXPECT_NEAR(work_of_all(c), c.kinetic() - before, 1e-13 * before);
  EXPECT_LT(c.kinetic(), 0.9 * before);
}

TEST(ContactEnergy, AnElasticContactStoresTheEnergyAndGivesItBack)
{
  // Error of the trapezium rule over the force. The second derivative is up to 1/(15 overlap^2) of
  // the energy per length squared, and the step v dt gives 1/12 of it. Contact begins and ends
  // within a step, which adds less than the error of one step.
  Collision c{1.0, 0.0, 0.0, duration() / 400.0};
  const double first_step = 2.94 / 400.0, bound = first_step * first_step;
  double most = 0.0;
  const double before = c.kinetic();
  do {
    c.step();
    most = std::max(most, c.stored.normal);
    EXPECT_NEAR(c.kinetic() + c.stored.normal, before, bound * impact_energy);
  } while (c.stored.normal > 0.0);
  // A step falls within half a step of the maximum, where the energy decreases with the
  // displacement squared.
  EXPECT_NEAR(most, impact_energy, 2.0 * bound * impact_energy);
  const energy::PairingTerms t = c.terms_now();
  EXPECT_EQ(t.dissipated_normal, 0.0);
  EXPECT_EQ(t.dissipated_tangential, 0.0);
  EXPECT_NEAR(t.spring_error, 0.0, bound * impact_energy);
}

TEST(ContactEnergy, ADampedImpactDissipatesOneMinusTheSquareOfRestitution)
{
  for (const double e : {0.1, 0.5, 0.9}) {
    Collision c{e, 0.5, 0.0, duration() / 1000.0};
    c.collide();
    const energy::PairingTerms t = c.terms_now();
    // The dashpot lags, which changes e by e ln(e)^2 dt / (2 t_c). A contact that begins up to a
    // step late, x = v dt / overlap = 0.003, changes e by x^(5/4) e ln(1/e) / 2.
    const double loss = -std::log(e);
    const double of_e = e * loss * loss * 1e-3 + 0.5 * e * loss * std::pow(2.94e-3, 1.25);
    EXPECT_NEAR(t.dissipated_normal, (1.0 - e * e) * impact_energy,
                (2.0 * e * of_e + 1e-5) * impact_energy)
        << e;
    EXPECT_EQ(t.elastic_normal, 0.0);
    EXPECT_LT(std::abs(t.spring_error), 1e-4 * impact_energy);
  }
}

TEST(ContactEnergy, ABallThatSlidesAllAlongLosesItsWorkToSlip)
{
  // Contact never sticks: the tangential impulse is mu (1 + e) m* v. The impact is so stiff that
  // the balls turn about each other by only 1.5 m/s x 0.13 ms / (2 R) = 0.005 rad. The normal speed
  // changes by this angle times 1.5 m/s, 0.7 %.
  Collision c{0.8, 0.1, 0.0, duration() / 16e3};
  c.hardness = 1e3;  // the impact lasts 1/16 as long
  c.i.velocity[1] = 1.5;
  const double before = c.kinetic();
  c.collide();
  const energy::PairingTerms t = c.terms_now();
  const double impulse = 0.1 * 1.8 * 0.5 * mass * head_on;
  // An impulse J reduces the speed of the surfaces by J (1/m* + 2 R^2 / I), which is J times 7/2 of
  // 1/m*.
  const double slows = impulse * 3.5 / (0.5 * mass);
  const double lost = impulse * (1.5 - 0.5 * slows);
  // The elastic displacement is mu F / k_t, 0.08 of the overlap; the sliding distance is 4
  // overlaps.
  EXPECT_NEAR(t.dissipated_tangential, lost, 0.02 * lost);
  EXPECT_NEAR(t.tangential_slip, lost, 0.02 * lost);
  EXPECT_NEAR(t.dissipated_tangential + t.dissipated_normal + t.spring_error, before - c.kinetic(),
              1e-13 * before);
}

TEST(ContactEnergy, LoadsByKindAddUpToForceAndTorques)
{
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto some = [&](double scale) {
    return Vector3<double>{scale * normal(random), scale * normal(random), scale * normal(random)};
  };
  for (int k = 0; k < 50; ++k) {
    BallPair<double> pair{{0.7 * 0.034, 0.0, 0.7 * 0.034},
                          0.98 * 0.034 * 0.034,
                          0.02,
                          0.015,
                          0.09,
                          0.04,
                          some(0.3),
                          some(10.0),
                          some(10.0),
                          some(k % 2 ? 1e-4 : 1e-6),
                          0.4};
    ContactTerms terms;
    terms.limited_damping = k % 3 == 0;
    const auto contact = contact_of(pair);
    const auto forces =
        contact_force(contact, contact_law({young, shear, 0.5, 0.4, 0.01}), terms, 1e-5, true);
    const EvaluatedContact evaluated(contact, forces);
    Loads on_i{}, on_j{};
    evaluated.add_loads_on_i(on_i);
    evaluated.add_loads_on_j(on_j);
    const Vector f = to_array(forces.force), ti = to_array(forces.torque_i),
                 tj = to_array(forces.torque_j);
    for (int d = 0; d < 3; ++d) {
      double sum[4] = {};
      for (int w = 0; w < works; ++w) {
        sum[0] += on_i[w][d];
        sum[1] += on_i[w][3 + d];
        sum[2] += on_j[w][d];
        sum[3] += on_j[w][3 + d];
      }
      EXPECT_NEAR(sum[0], f[d], 1e-12 * size_of(f));
      EXPECT_NEAR(sum[1], ti[d], 1e-12 * size_of(ti));
      EXPECT_NEAR(sum[2], -f[d], 1e-12 * size_of(f));
      EXPECT_NEAR(sum[3], tj[d], 1e-12 * size_of(tj));
    }
    // The elastic part is checked alone, so the rest of the sum is the damping part, divided or
    // not.
    const Vector displacement = to_array(forces.displacement);
    for (int d = 0; d < 3; ++d)
      EXPECT_NEAR(on_i[tangential_spring][d], -forces.tangential_stiffness * displacement[d],
                  1e-12 * size_of(f));
    // A contact that slips has no tangential damping force.
    EXPECT_TRUE(forces.slip == 0.0 || size_of(to_array(forces.tangential_damping_force)) == 0.0);
  }
}

TEST(ContactEnergy, OfAWallIsThatOfItsForce)
{
  const auto law = contact_law({young, shear, 0.5, 0.3, 0.01});
  for (const double along : {1e-6, 1e-3}) {  // sticks, slides
    const auto contact = contact_of(BallOnWall<double>{{0.0, 1.0, 0.0},
                                                       4e-4,
                                                       radius,
                                                       mass,
                                                       {0.2, -0.1, 0.05},
                                                       {3.0, 20.0, -8.0},
                                                       {along, 0.0, 0.0},
                                                       0.0});
    const auto on_ball = contact_force(contact, law, {}, 1e-5, true);
    const EvaluatedContact evaluated(contact, on_ball);
    Loads loads{};
    evaluated.add_loads_on_i(loads);
    const Vector of_force = to_array(on_ball.force), of_torque = to_array(on_ball.torque_i);
    for (int d = 0; d < 3; ++d) {
      double force = 0.0, torque = 0.0;
      for (const Load& load : loads) {
        force += load[d];
        torque += load[3 + d];
      }
      EXPECT_NEAR(force, of_force[d], 1e-12 * size_of(of_force));
      EXPECT_NEAR(torque, of_torque[d], 1e-12 * size_of(of_torque));
    }
    const double a = std::sqrt(radius * 4e-4);
    EXPECT_NEAR(evaluated.normal_energy(), 2.0 / 5.0 * 4.0 / 3.0 * young * a * 4e-4 * 4e-4, 1e-12);
    EXPECT_NEAR(evaluated.tangential_energy(),
                0.5 * 8.0 * shear * a * dot(on_ball.displacement, on_ball.displacement), 1e-15);
    EXPECT_EQ(evaluated.slip_work() > 0.0, along == 1e-3);
  }
}

TEST(ContactEnergy, OfAnApproachIsThatOfTheNormalSpeedAndZeroAtSeparation)
{
  const auto approach = [](double normal_speed) {
    Contact<double> contact{};
    contact.normal = {0.0, 1.0, 0.0};
    contact.velocity = {3.0, normal_speed, -1.0};
    contact.mass = 0.045;
    return EvaluatedContact(contact, {}).approach_energy();
  };
  EXPECT_DOUBLE_EQ(approach(-2.0), 0.09);
  EXPECT_EQ(approach(2.0), 0.0);
}

}  // namespace
