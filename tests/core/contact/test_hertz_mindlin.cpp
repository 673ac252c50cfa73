#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "core/contact/hertz_mindlin.h"

namespace {

using namespace millscale::contact;

const Material paper_ball{2.0 * 2.3e7 * 1.3, 0.3, 2678.0};

/// Ratio of the relative speeds after and before an impact, by integrating the contact in small
/// steps.
double realised_restitution(const Pair& pair, double speed)
{
  const double step = 1e-4 * hertz_collision_time(pair, speed);
  double overlap = 0.0, rate = speed;
  const auto acceleration = [&pair](double d, double v) {
    const Coefficients c = coefficients(pair, d > 0.0 ? d : 0.0);
    return -(c.normal_stiffness * d + c.normal_damping * v) / pair.mass;
  };
  do {
    const double middle = rate + 0.5 * step * acceleration(overlap, rate);
    const double at_middle = overlap + 0.5 * step * rate;
    overlap += step * middle;
    rate += step * acceleration(at_middle, middle);
  } while (overlap > 0.0);
  return -rate / speed;
}

TEST(Moduli, OfEqualSolidsHaveTheirClosedForms)
{
  const double E = paper_ball.youngs_modulus, nu = paper_ball.poisson_ratio;
  EXPECT_NEAR(shear_modulus(paper_ball), 2.3e7, 1e-7);
  EXPECT_NEAR(effective_youngs_modulus(paper_ball, paper_ball), E / (2.0 * (1.0 - nu * nu)), 1e-6);
  EXPECT_NEAR(effective_shear_modulus(paper_ball, paper_ball),
              shear_modulus(paper_ball) / (2.0 * (2.0 - nu)), 1e-6);
}

TEST(Moduli, AreSymmetricAndARigidPartnerDoublesThem)
{
  const Material steel{210e9, 0.25, 7850.0}, rigid{1e30, 0.3, 7850.0};
  EXPECT_DOUBLE_EQ(effective_youngs_modulus(paper_ball, steel),
                   effective_youngs_modulus(steel, paper_ball));
  EXPECT_DOUBLE_EQ(effective_shear_modulus(paper_ball, steel),
                   effective_shear_modulus(steel, paper_ball));
  EXPECT_NEAR(effective_youngs_modulus(paper_ball, rigid) /
                  effective_youngs_modulus(paper_ball, paper_ball),
              2.0, 1e-12);
}

TEST(Damping, RatioHasItsLimits)
{
  EXPECT_DOUBLE_EQ(damping_ratio(1.0), 0.0);
  EXPECT_NEAR(damping_ratio(0.1), 0.54, 0.005);
  EXPECT_NEAR(damping_factor(1e-300), 1.0, 2e-5);
  EXPECT_THROW(damping_ratio(0.0), std::invalid_argument);
  EXPECT_THROW(damping_ratio(1.01), std::invalid_argument);
  EXPECT_THROW(damping_ratio(NAN), std::invalid_argument);
}

TEST(Damping, GivesTheRestitutionAskedForAtEverySpeed)
{
  for (const double e : {0.1, 0.2, 0.5, 0.9})
    for (const double speed : {0.1, 5.0}) {
      const Pair pair = ball_on_ball(paper_ball, 0.02, e);
      EXPECT_NEAR(realised_restitution(pair, speed), e, 2e-3) << "e " << e << " at " << speed;
    }
}

TEST(Coefficients, AreTheForceAndItsSlope)
{
  const Pair pair = ball_on_ball(paper_ball, 0.02, 0.1);
  const double overlap = 1e-4, step = 1e-9;
  const auto force = [&pair](double d) { return coefficients(pair, d).normal_stiffness * d; };
  EXPECT_NEAR(force(overlap),
              4.0 / 3.0 * pair.youngs_modulus * std::sqrt(0.01) * std::pow(overlap, 1.5),
              1e-12 * force(overlap));
  // The damping uses the tangent stiffness: gamma_n = 2 zeta sqrt(S_n m*).
  const double slope = (force(overlap + step) - force(overlap - step)) / (2.0 * step);
  const Coefficients c = coefficients(pair, overlap);
  EXPECT_NEAR(c.normal_damping / (2.0 * damping_ratio(0.1) * std::sqrt(slope * pair.mass)), 1.0,
              1e-6);
  EXPECT_NEAR(c.tangential_damping / c.normal_damping,
              std::sqrt(c.tangential_stiffness / (1.5 * c.normal_stiffness)), 1e-14);
}

TEST(Coefficients, TangentialOverNormalSlopeIsMindlins)
{
  // 2 (1 - nu) / (2 - nu) for equal solids. Mindlin, J. Appl. Mech. 16 (1949) 259.
  const Coefficients c = coefficients(ball_on_ball(paper_ball, 0.02, 0.1), 1e-4);
  EXPECT_NEAR(c.tangential_stiffness / (1.5 * c.normal_stiffness), 2.0 * 0.7 / 1.7, 1e-14);
}

/// Chung, Ooi, Granular Matter 13 (2011) 643-656, doi 10.1007/s10035-011-0277-0, tests 1 and 2.
struct Benchmark {
  Pair pair;
  double speed, force, overlap, time;
};

TEST(Impact, ReproducesTheBenchmarksOfChungAndOoi)
{
  const Material glass{4.8e10, 0.20, 2800.0}, limestone{2.0e10, 0.25, 2500.0};
  const Material aluminium{7e10, 0.30, 2699.0}, magnesium{4e10, 0.35, 1800.0};
  const auto on_rigid_plane = [](const Material& m) {
    return ball_on_wall(m, {1e30, m.poisson_ratio, m.density}, 0.1, 1.0);
  };
  for (const Benchmark& b :
       {Benchmark{ball_on_ball(glass, 0.01, 1.0), 20.0, 10697.0, 274.1e-6, 40.3e-6},
        Benchmark{ball_on_ball(limestone, 0.01, 1.0), 20.0, 7108.0, 368.3e-6, 54.1e-6},
        Benchmark{on_rigid_plane(aluminium), 0.2, 11370.0, 49.7e-6, 731e-6},
        Benchmark{on_rigid_plane(magnesium), 0.2, 7233.0, 52.1e-6, 766e-6}}) {
    const double overlap = hertz_overlap(b.pair, b.speed);
    EXPECT_NEAR(overlap / b.overlap, 1.0, 2e-3);
    EXPECT_NEAR(coefficients(b.pair, overlap).normal_stiffness * overlap / b.force, 1.0, 2e-3);
    EXPECT_NEAR(hertz_collision_time(b.pair, b.speed) / b.time, 1.0, 2e-3);
  }
}

TEST(Impact, UndampedCollisionConservesEnergyAndLastsItsTime)
{
  const Pair pair = ball_on_ball(paper_ball, 0.02, 1.0);
  EXPECT_NEAR(realised_restitution(pair, 5.0), 1.0, 1e-4);
  const double overlap = hertz_overlap(pair, 5.0);
  const double stored = 0.4 * coefficients(pair, overlap).normal_stiffness * overlap * overlap;
  EXPECT_NEAR(stored / (0.5 * pair.mass * 25.0), 1.0, 1e-12);
  EXPECT_NEAR(hertz_collision_time(pair, 5.0) * 5.0 / overlap, 2.94, 0.005);
}

TEST(ContactErrors, NameTheValueAndTheRange)
{
  EXPECT_THROW(ball_on_ball({0.0, 0.3, 2678.0}, 0.02, 0.1), std::invalid_argument);
  EXPECT_THROW(ball_on_ball({6e7, 0.51, 2678.0}, 0.02, 0.1), std::invalid_argument);
  EXPECT_THROW(ball_on_ball({6e7, -0.1, 2678.0}, 0.02, 0.1), std::invalid_argument);
  EXPECT_THROW(ball_on_ball({6e7, 0.3, NAN}, 0.02, 0.1), std::invalid_argument);
  EXPECT_THROW(ball_on_ball(paper_ball, -0.02, 0.1), std::invalid_argument);
  EXPECT_THROW(ball_on_wall(paper_ball, {6e7, 0.3, 0.0}, 0.02, 0.1), std::invalid_argument);
  EXPECT_THROW(hertz_overlap(ball_on_ball(paper_ball, 0.02, 0.1), 0.0), std::invalid_argument);
}

}  // namespace
