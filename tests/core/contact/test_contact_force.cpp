#include <gtest/gtest.h>

#include <random>
#include <utility>

#include "core/contact/contact_force.h"
#include "core/contact/written_out.h"

namespace {

using namespace millscale::contact;
using millscale::Vector;
using millscale::Vector3;
using written_out::Forces;
using written_out::vector;

constexpr double dt = 1e-5;
const EffectiveMaterial steel{3.3e7, 7.0e6, 0.59, 0.5, 0.01};

ContactForce<double> force_of(const BallPair<double>& pair, const ContactTerms& terms = {},
                              bool advance = true)
{
  return contact_force(contact_of(pair), contact_law(steel), terms, dt, advance);
}

/// Two unequal balls that overlap by 2 % to 20 % of the smaller radius. The overlap, a difference
/// of lengths fifty times as large, is then known to 1e-14.
BallPair<double> random_pair(unsigned seed, double displacement = 1e-4)
{
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> share;
  const auto triple = [&](double scale) {
    return Vector3<double>{scale * normal(random), scale * normal(random), scale * normal(random)};
  };
  BallPair<double> pair;
  pair.radius_i = 0.01 + 0.03 * share(random);
  pair.radius_j = 0.01 + 0.03 * share(random);
  pair.mass_i = 0.1 + 0.5 * share(random);
  pair.mass_j = 0.1 + 0.5 * share(random);
  const double smaller = std::fmin(pair.radius_i, pair.radius_j);
  const double distance = pair.radius_i + pair.radius_j - (0.02 + 0.18 * share(random)) * smaller;
  const Vector3<double> direction = triple(1.0);
  pair.separation = distance / std::sqrt(dot(direction, direction)) * direction;
  pair.r2 = dot(pair.separation, pair.separation);
  pair.velocity = triple(0.3);
  pair.spin_i = triple(10.0);
  pair.spin_j = triple(10.0);
  pair.displacement = triple(displacement);
  pair.damping_share = share(random);
  return pair;
}

BallPair<double> exchanged(const BallPair<double>& p)
{
  const Vector3<double> zero{0.0, 0.0, 0.0};
  BallPair<double> other = p;
  other.separation = zero - p.separation;
  other.velocity = zero - p.velocity;
  other.displacement = zero - p.displacement;
  std::swap(other.radius_i, other.radius_j);
  std::swap(other.mass_i, other.mass_j);
  std::swap(other.spin_i, other.spin_j);
  return other;
}

/// Expect a = b within a fraction of the size of b.
void expect_close(const Vector3<double>& a, const Vector& b, double tolerance)
{
  EXPECT_LE(written_out::size(written_out::sum(vector(a), -1.0, b)),
            tolerance * written_out::size(b))
      << a.x << " " << a.y << " " << a.z << ", expected " << b[0] << " " << b[1] << " " << b[2];
}

void expect_equal_to_written_out(const BallPair<double>& pair, const EffectiveMaterial& law,
                                 const ContactTerms& terms, bool advance)
{
  const Forces expected = written_out::pair_force(pair, law, terms, dt, advance);
  const auto got = contact_force(contact_of(pair), contact_law(law), terms, dt, advance);
  // About thirty roundings of 1e-16, the error of the overlap of 1e-14, and a force that is a
  // difference.
  expect_close(got.force, expected.force, 1e-12);
  expect_close(got.torque_i, expected.torque_i, 1e-12);
  expect_close(got.torque_j, expected.torque_j, 1e-12);
  expect_close(got.displacement, expected.displacement, 1e-12);
}

/// Return whether the contact slips in the written-out law: the displacement is cut to Coulomb's
/// limit.
bool slips(const BallPair<double>& pair, const EffectiveMaterial& law)
{
  EffectiveMaterial sticking = law;
  sticking.sliding = 1e9;
  const auto displacement = [&](const EffectiveMaterial& m) {
    return written_out::size(written_out::pair_force(pair, m, {}, dt, true).displacement);
  };
  return displacement(law) < 0.999 * displacement(sticking);
}

TEST(ContactForce, IsTheWrittenOutLawStickingAndSlipping)
{
  int slipping = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    const BallPair<double> pair = random_pair(seed, seed % 2 ? 1e-3 : 1e-5);
    slipping += slips(pair, steel);
    for (const bool advance : {true, false}) expect_equal_to_written_out(pair, steel, {}, advance);
  }
  EXPECT_GT(slipping, 50);
  EXPECT_LT(slipping, 250);
}

TEST(ContactForce, IsTheWrittenOutLawWithEveryChoiceOfTerms)
{
  for (unsigned choice = 0; choice < 16; ++choice)
    for (unsigned seed = 0; seed < 20; ++seed)
      expect_equal_to_written_out(
          random_pair(seed), steel,
          {bool(choice & 1), bool(choice & 2), bool(choice & 4), bool(choice & 8)}, true);
}

TEST(ContactForce, WithoutSpinMotionAndFrictionIsHertz)
{
  BallPair<double> pair = random_pair(1);
  pair.velocity = pair.spin_i = pair.spin_j = pair.displacement = {0.0, 0.0, 0.0};
  const auto got = force_of(pair);
  const double distance = std::sqrt(pair.r2);
  const double overlap = pair.radius_i + pair.radius_j - distance;
  const double radius = pair.radius_i * pair.radius_j / (pair.radius_i + pair.radius_j);
  const double hertz =
      4.0 / 3.0 * steel.youngs_modulus * std::sqrt(radius) * std::pow(overlap, 1.5);
  expect_close(got.force, vector(hertz / distance * pair.separation), 1e-13);
  for (const auto& torque : {got.torque_i, got.torque_j})  // 0/0 in Coulomb's limit and in cdt
    EXPECT_EQ(dot(torque, torque), 0.0);
  EXPECT_EQ(dot(got.displacement, got.displacement), 0.0);
}

TEST(ContactForce, EqualSpinsRollWithoutTorque)
{
  BallPair<double> pair = random_pair(2);
  pair.spin_j = pair.spin_i;
  const auto with = force_of(pair);
  const auto without = force_of(pair, {true, true, false, false});
  expect_close(with.torque_i, vector(without.torque_i), 0.0);
  expect_close(with.torque_j, vector(without.torque_j), 0.0);
}

TEST(ContactForce, ExchangedBallsFeelTheOppositeForceAndTheirOwnTorque)
{
  for (unsigned seed = 0; seed < 100; ++seed) {
    const BallPair<double> pair = random_pair(seed);
    const auto one = force_of(pair);
    const auto other = force_of(exchanged(pair));
    const Vector3<double> zero{0.0, 0.0, 0.0};
    expect_close(zero - other.force, vector(one.force), 1e-13);
    expect_close(other.torque_i, vector(one.torque_j), 1e-13);
    expect_close(other.torque_j, vector(one.torque_i), 1e-13);
    expect_close(zero - other.displacement, vector(one.displacement), 1e-13);
  }
}

TEST(ContactForce, DoesNotTurnThePairAsAWhole)
{
  // The tangential force and the torques act at the middle of the overlap, so the angular momentum
  // of the pair about this point stays constant.
  for (unsigned seed = 0; seed < 100; ++seed) {
    const BallPair<double> pair = random_pair(seed);
    const auto got = force_of(pair);
    const Vector3<double> orbital = cross(pair.separation, got.force);
    const Vector3<double> total = orbital + got.torque_i + got.torque_j;
    EXPECT_LE(std::sqrt(dot(total, total)), 1e-13 * std::sqrt(dot(orbital, orbital)));
  }
}

TEST(ContactForce, OnABallWithoutCurvatureAndMotionIsThatOfAWall)
{
  // The larger ball is 1e6 times as large. Its curvature changes the effective radius by a fraction
  // of 1e-6 and the force by half of this. The overlap, a thousandth of the small radius, is known
  // to 1e-16 * 1e6 / 1e-3 = 1e-7. Slip and the dashpots add a factor of a few.
  for (unsigned seed = 0; seed < 50; ++seed) {
    BallPair<double> pair = random_pair(seed, seed % 2 ? 1e-4 : 1e-6);
    const double overlap = 1e-3 * pair.radius_i;
    const Vector3<double> normal = 1.0 / std::sqrt(pair.r2) * pair.separation;
    pair.radius_j = 1e6 * pair.radius_i;
    pair.mass_j = 1e9 * pair.mass_i;
    pair.spin_j = {0.0, 0.0, 0.0};
    pair.separation = (pair.radius_i + pair.radius_j - overlap) * normal;
    pair.r2 = dot(pair.separation, pair.separation);
    pair.damping_share = 0.6;
    ContactTerms terms;
    terms.limited_damping = true;
    const auto ball = force_of(pair, terms);

    const BallOnWall<double> on_wall{
        normal,        overlap,     pair.radius_i,     pair.mass_i,
        pair.velocity, pair.spin_i, pair.displacement, pair.damping_share};
    const auto wall = contact_force(contact_of(on_wall), contact_law(steel), terms, dt, true);
    EXPECT_NEAR(ball.damping, wall.damping, 5e-6 * wall.damping);
    expect_close(ball.force, vector(wall.force), 5e-6);
    expect_close(ball.torque_i, vector(wall.torque_i), 5e-6);
    expect_close(ball.displacement, vector(wall.displacement), 5e-6);
  }
}

TEST(ContactForce, BringsTheCoefficientsOfHertzMindlin)
{
  // Test each coefficient alone: change one input and compare the change of force.
  BallPair<double> pair = random_pair(3);
  pair.velocity = pair.spin_i = pair.spin_j = pair.displacement = {0.0, 0.0, 0.0};
  const double distance = std::sqrt(pair.r2);
  const double overlap = pair.radius_i + pair.radius_j - distance;
  const Pair effective{pair.radius_i * pair.radius_j / (pair.radius_i + pair.radius_j),
                       pair.mass_i * pair.mass_j / (pair.mass_i + pair.mass_j),
                       steel.youngs_modulus, steel.shear_modulus, steel.damping};
  const Coefficients k = coefficients(effective, overlap);
  const Vector3<double> normal = 1.0 / distance * pair.separation;
  const Vector3<double> some{normal.y, normal.z, normal.x};
  const Vector3<double> along = cross(normal, some);
  const auto force = [&](const Vector3<double>& velocity, const Vector3<double>& displacement) {
    pair.velocity = velocity;
    pair.displacement = displacement;
    return force_of(pair, {}, false).force;
  };
  const Vector3<double> zero{0.0, 0.0, 0.0}, rest = force(zero, zero);
  const double speed = 1e-3, shift = 1e-7;  // small: Coulomb's limit is not reached
  expect_close(rest, vector(k.normal_stiffness * overlap * normal), 1e-13);
  // A change is known to the round-off of the force at rest, a fraction of about 1e-16 * 1e3.
  expect_close(force(speed * normal, zero) - rest, vector(-speed * k.normal_damping * normal),
               1e-11);
  expect_close(force(speed * along, zero) - rest, vector(-speed * k.tangential_damping * along),
               1e-11);
  expect_close(force(zero, shift * along) - rest, vector(-shift * k.tangential_stiffness * along),
               1e-11);
}

}  // namespace
