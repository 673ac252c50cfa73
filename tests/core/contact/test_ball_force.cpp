#include <gtest/gtest.h>

#include <random>

#include "core/contact/wall_force.h"
#include "core/contact/written_out.h"

namespace {

using namespace millscale::contact;
using millscale::Vector;
using written_out::Forces;
using written_out::Law;
using written_out::vector;

constexpr double dt = 1e-5;
const Law steel{3.3e7, 7.0e6, 0.59, 0.5, 0.01};

BallLaw<double> ball_law_of(const Law& law)
{
  return ball_law(law.youngs_modulus, law.shear_modulus, law.damping, law.sliding, law.rolling);
}

/// Two unequal balls that overlap by 2 % to 20 % of the smaller radius, so that the overlap, a
/// difference of lengths fifty times as large, is known to 1e-14.
BallTouch<double> random_touch(unsigned seed, double memory = 1e-4)
{
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> share;
  const auto triple = [&](double scale) {
    return Triple<double>{scale * normal(random), scale * normal(random), scale * normal(random)};
  };
  BallTouch<double> touch;
  touch.radius_i = 0.01 + 0.03 * share(random);
  touch.radius_j = 0.01 + 0.03 * share(random);
  touch.mass_i = 0.1 + 0.5 * share(random);
  touch.mass_j = 0.1 + 0.5 * share(random);
  const double smaller = std::fmin(touch.radius_i, touch.radius_j);
  const double distance = touch.radius_i + touch.radius_j - (0.02 + 0.18 * share(random)) * smaller;
  const Triple<double> direction = triple(1.0);
  touch.apart = distance / std::sqrt(dot(direction, direction)) * direction;
  touch.square = dot(touch.apart, touch.apart);
  touch.velocity = triple(0.3);
  touch.spin_i = triple(10.0);
  touch.spin_j = triple(10.0);
  touch.displacement = triple(memory);
  return touch;
}

BallTouch<double> exchanged(const BallTouch<double>& t)
{
  const Triple<double> zero{0.0, 0.0, 0.0};
  return {zero - t.apart, t.square,          t.radius_j, t.radius_i, t.mass_j,
          t.mass_i,       zero - t.velocity, t.spin_j,   t.spin_i,   zero - t.displacement};
}

/// a = b up to a share of the size of b.
void expect_close(const Triple<double>& a, const Vector& b, double tolerance)
{
  EXPECT_LE(written_out::size(written_out::sum(vector(a), -1.0, b)),
            tolerance * written_out::size(b))
      << a.x << " " << a.y << " " << a.z << ", expected " << b[0] << " " << b[1] << " " << b[2];
}

void expect_equal_to_written_out(const BallTouch<double>& touch, const Law& law,
                                 const BallTerms& terms, bool advance)
{
  const Forces expected = written_out::ball_force(touch, law, terms, dt, advance);
  const auto got = ball_force(touch, ball_law_of(law), terms, dt, advance);
  // Thirty roundings of 1e-16, the overlap's of 1e-14, and a force that is a difference.
  expect_close(got.force, expected.force, 1e-12);
  expect_close(got.torque_i, expected.torque_i, 1e-12);
  expect_close(got.torque_j, expected.torque_j, 1e-12);
  expect_close(got.displacement, expected.displacement, 1e-12);
}

/// Whether the contact slips, by the written-out law: its memory is cut to Coulomb's limit.
bool slips(const BallTouch<double>& touch, const Law& law)
{
  Law sticking = law;
  sticking.sliding = 1e9;
  const auto memory = [&](const Law& l) {
    return written_out::size(written_out::ball_force(touch, l, {}, dt, true).displacement);
  };
  return memory(law) < 0.999 * memory(sticking);
}

TEST(BallForce, IsTheWrittenOutLawStickingAndSlipping)
{
  int slipping = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    const BallTouch<double> touch = random_touch(seed, seed % 2 ? 1e-3 : 1e-5);
    slipping += slips(touch, steel);
    for (const bool advance : {true, false}) expect_equal_to_written_out(touch, steel, {}, advance);
  }
  EXPECT_GT(slipping, 50);
  EXPECT_LT(slipping, 250);
}

TEST(BallForce, IsTheWrittenOutLawWithEveryChoiceOfTerms)
{
  for (unsigned choice = 0; choice < 8; ++choice)
    for (unsigned seed = 0; seed < 20; ++seed)
      expect_equal_to_written_out(random_touch(seed), steel,
                                  {bool(choice & 1), bool(choice & 2), bool(choice & 4)}, true);
}

TEST(BallForce, WithoutSpinMotionAndFrictionIsHertz)
{
  BallTouch<double> touch = random_touch(1);
  touch.velocity = touch.spin_i = touch.spin_j = touch.displacement = {0.0, 0.0, 0.0};
  const auto got = ball_force(touch, ball_law_of(steel), {}, dt, true);
  const double distance = std::sqrt(touch.square);
  const double overlap = touch.radius_i + touch.radius_j - distance;
  const double radius = touch.radius_i * touch.radius_j / (touch.radius_i + touch.radius_j);
  const double hertz =
      4.0 / 3.0 * steel.youngs_modulus * std::sqrt(radius) * std::pow(overlap, 1.5);
  expect_close(got.force, vector(hertz / distance * touch.apart), 1e-13);
  for (const auto& torque : {got.torque_i, got.torque_j})  // 0/0 in Coulomb's share and in cdt
    EXPECT_EQ(dot(torque, torque), 0.0);
  EXPECT_EQ(dot(got.displacement, got.displacement), 0.0);
}

TEST(BallForce, EqualSpinsRollWithoutTorque)
{
  BallTouch<double> touch = random_touch(2);
  touch.spin_j = touch.spin_i;
  const auto with = ball_force(touch, ball_law_of(steel), {}, dt, true);
  const auto without = ball_force(touch, ball_law_of(steel), {true, true, false}, dt, true);
  expect_close(with.torque_i, vector(without.torque_i), 0.0);
  expect_close(with.torque_j, vector(without.torque_j), 0.0);
}

TEST(BallForce, ExchangedBallsFeelTheOppositeForceAndTheirOwnTorque)
{
  for (unsigned seed = 0; seed < 100; ++seed) {
    const BallTouch<double> touch = random_touch(seed);
    const auto one = ball_force(touch, ball_law_of(steel), {}, dt, true);
    const auto other = ball_force(exchanged(touch), ball_law_of(steel), {}, dt, true);
    const Triple<double> zero{0.0, 0.0, 0.0};
    expect_close(zero - other.force, vector(one.force), 1e-13);
    expect_close(other.torque_i, vector(one.torque_j), 1e-13);
    expect_close(other.torque_j, vector(one.torque_i), 1e-13);
    expect_close(zero - other.displacement, vector(one.displacement), 1e-13);
  }
}

TEST(BallForce, DoesNotTurnThePairAsAWhole)
{
  // The tangential force and the torques about the middle of the overlap are of one point: the
  // angular momentum of the pair about it stays.
  for (unsigned seed = 0; seed < 100; ++seed) {
    const BallTouch<double> touch = random_touch(seed);
    const auto got = ball_force(touch, ball_law_of(steel), {}, dt, true);
    const Triple<double> orbital = cross(touch.apart, got.force);
    const Triple<double> total = orbital + got.torque_i + got.torque_j;
    EXPECT_LE(std::sqrt(dot(total, total)), 1e-13 * std::sqrt(dot(orbital, orbital)));
  }
}

TEST(BallForce, OnABallWithoutCurvatureAndMotionIsThatOfAWall)
{
  // The larger ball is 1e6 times as large: its curvature changes the effective radius by 1e-6 of
  // itself, the force by half of that; the overlap, a thousandth of the small radius, is known to
  // 1e-16 * 1e6 / 1e-3 = 1e-7. Slip and the dashpots add a factor of a few.
  for (unsigned seed = 0; seed < 50; ++seed) {
    BallTouch<double> touch = random_touch(seed, seed % 2 ? 1e-4 : 1e-6);
    const double overlap = 1e-3 * touch.radius_i;
    const Triple<double> normal = 1.0 / std::sqrt(touch.square) * touch.apart;
    touch.radius_j = 1e6 * touch.radius_i;
    touch.mass_j = 1e9 * touch.mass_i;
    touch.spin_j = {0.0, 0.0, 0.0};
    touch.apart = (touch.radius_i + touch.radius_j - overlap) * normal;
    touch.square = dot(touch.apart, touch.apart);
    touch.held = 0.6;
    BallTerms terms;
    terms.bounded = true;
    const auto ball = ball_force(touch, ball_law_of(steel), terms, dt, true);

    const Pair pair{touch.radius_i, touch.mass_i, steel.youngs_modulus, steel.shear_modulus,
                    steel.damping};
    Vector memory = vector(touch.displacement);
    const auto wall = wall_force(
        pair, {steel.sliding, steel.rolling},
        {touch.radius_i, overlap, vector(normal), vector(touch.velocity), vector(touch.spin_i)}, dt,
        memory, touch.held);
    EXPECT_NEAR(ball.damping, wall.damping, 5e-6 * wall.damping);
    expect_close(ball.force, wall.force, 5e-6);
    expect_close(ball.torque_i, wall.torque, 5e-6);
    expect_close(ball.displacement, memory, 5e-6);
  }
}

TEST(BallForce, BringsTheCoefficientsOfHertzMindlin)
{
  // Each coefficient alone: change one input, look at the change of force.
  BallTouch<double> touch = random_touch(3);
  touch.velocity = touch.spin_i = touch.spin_j = touch.displacement = {0.0, 0.0, 0.0};
  const double distance = std::sqrt(touch.square);
  const double overlap = touch.radius_i + touch.radius_j - distance;
  const Pair pair{touch.radius_i * touch.radius_j / (touch.radius_i + touch.radius_j),
                  touch.mass_i * touch.mass_j / (touch.mass_i + touch.mass_j), steel.youngs_modulus,
                  steel.shear_modulus, steel.damping};
  const Coefficients k = coefficients(pair, overlap);
  const Triple<double> normal = 1.0 / distance * touch.apart;
  const Triple<double> some{normal.y, normal.z, normal.x};
  const Triple<double> along = cross(normal, some);
  const auto force = [&](const Triple<double>& velocity, const Triple<double>& displacement) {
    touch.velocity = velocity;
    touch.displacement = displacement;
    return ball_force(touch, ball_law_of(steel), {}, dt, false).force;
  };
  const Triple<double> zero{0.0, 0.0, 0.0}, rest = force(zero, zero);
  const double speed = 1e-3, shift = 1e-7;  // small: Coulomb's limit is not reached
  expect_close(rest, vector(k.normal_stiffness * overlap * normal), 1e-13);
  // A change is known to round-off of the force at rest, about 1e-16 * 1e3 of itself.
  expect_close(force(speed * normal, zero) - rest, vector(-speed * k.normal_damping * normal),
               1e-11);
  expect_close(force(speed * along, zero) - rest, vector(-speed * k.tangential_damping * along),
               1e-11);
  expect_close(force(zero, shift * along) - rest, vector(-shift * k.tangential_stiffness * along),
               1e-11);
}

}  // namespace
