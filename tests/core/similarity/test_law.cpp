#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <tuple>

#include "core/paper_table.h"
#include "core/similarity/law.h"

namespace {

using namespace millscale::similarity;
using millscale::test::number;
using millscale::test::paper_table;

constexpr double rounding = 1e-14;
const OperatingPoint paper_mill{3.9, 0.02, 9.81, 1.0};
const double factors[] = {1.0, 1.083, 1.3, 2.6, 10.0};

ScalingRequest request(double S, Scheme scheme, Policy policy = Policy::paper)
{
  return {S, scheme, policy, scheme == Scheme::froude ? 0.7 : 0.0, false};
}

/// Froude number on the path of the ball's centre.
double centre_froude(const OperatingPoint& mill)
{
  return froude_number(mill.radius - mill.ball_radius, mill.gravity, mill.omega);
}

/// Message of the error that scaling throws; empty if scaling throws none.
std::string error_of(const OperatingPoint& mill, const ScalingRequest& wanted)
{
  try {
    scale(mill, wanted);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Law, Table2AtConstantGravity)
{
  for (const double S : factors) {
    const ScaledMill scaled = scale(paper_mill, request(S, Scheme::constant_gravity));
    EXPECT_NEAR(scaled.mill.radius / paper_mill.radius, 1.0 / S, rounding);
    EXPECT_NEAR(factor(scaled.base, dimension::length), 1.0 / S, rounding);
    EXPECT_NEAR(scaled.mill.gravity / paper_mill.gravity, 1.0, rounding);
    EXPECT_NEAR(scaled.mill.omega / paper_mill.omega, std::sqrt(S), 10 * rounding);
    EXPECT_NEAR(scaled.predicted_energy_ratio, 1.0 / S, rounding);
  }
}

TEST(Law, Table2AtConstantSpeed)
{
  for (const double S : factors) {
    const ScaledMill scaled = scale(paper_mill, request(S, Scheme::constant_speed));
    EXPECT_NEAR(scaled.mill.radius / paper_mill.radius, 1.0 / S, rounding);
    EXPECT_NEAR(factor(scaled.base, dimension::length), 1.0 / S, rounding);
    EXPECT_NEAR(scaled.mill.gravity / paper_mill.gravity, 1.0 / S, rounding);
    EXPECT_NEAR(scaled.mill.omega / paper_mill.omega, 1.0, rounding);
    EXPECT_NEAR(scaled.predicted_energy_ratio, 1.0 / (S * S), rounding);
  }
}

/// Half a unit of the last of two printed decimals.
constexpr double printed = 0.005 + 1e-12;

TEST(Law, Tables6And7OfThePaper)
{
  using Table = std::tuple<const char*, Scheme>;
  for (const auto& [file, scheme] : {Table{"table6_constant_gravity.csv", Scheme::constant_gravity},
                                     Table{"table7_constant_speed.csv", Scheme::constant_speed}}) {
    const auto rows = paper_table(file);
    ASSERT_EQ(rows.size(), 6u);
    for (const auto& row : rows) {
      // The paper computed with its rounded S: 3.9 / 2.3 would give 5.785, but 5.79 is printed.
      const double S = number(row, "S");
      const ScaledMill scaled = scale(paper_mill, request(S, scheme));
      EXPECT_NEAR(scaled.mill.gravity, number(row, "gravity_m_s2"), printed) << file << " S " << S;
      EXPECT_NEAR(scaled.mill.omega, number(row, "omega_rad_s"), printed) << file << " S " << S;
      EXPECT_NEAR(scaled.froude, number(row, "froude"), printed) << file << " S " << S;
    }
  }
}

TEST(Law, EverySchemeKeepsTheFroudeNumberOfItsPath)
{
  for (const Scheme scheme : {Scheme::constant_gravity, Scheme::constant_speed, Scheme::froude})
    for (const double S : factors) {
      const auto kept = [&](Policy policy) {
        return scale(paper_mill, request(S, scheme, policy));
      };
      EXPECT_NEAR(kept(Policy::paper).froude, froude_number(paper_mill), rounding);
      for (const Policy policy : {Policy::corrected, Policy::offset_liner})
        EXPECT_NEAR(centre_froude(kept(policy).mill), centre_froude(paper_mill), rounding);
    }
}

TEST(Law, OffsetLinerScalesTheCentrePathExactly)
{
  const OperatingPoint mill =
      scale(paper_mill, request(2.6, Scheme::constant_gravity, Policy::offset_liner)).mill;
  EXPECT_NEAR(mill.radius - mill.ball_radius, (3.9 - 0.02) / 2.6, rounding);
}

TEST(Law, CorrectedSpeedFollowsTheCentrePath)
{
  // omega' = omega sqrt((R - a) / (R/S - a)): about +0.4 % at a/R = 0.5 %, +8 % at 2 % and S = 8.
  const auto excess = [](double ball_radius, double S) {
    const OperatingPoint mill{3.9, ball_radius, 9.81, 1.0};
    return scale(mill, request(S, Scheme::constant_gravity, Policy::corrected)).mill.omega /
           std::sqrt(S);
  };
  EXPECT_NEAR(excess(0.02, 2.6), std::sqrt(3.88 / 1.48 / 2.6), rounding);
  EXPECT_NEAR(excess(0.02, 2.6), 1.004, 1e-3);
  EXPECT_NEAR(excess(0.078, 8.0), 1.08, 5e-3);
}

TEST(Law, ScalingTwiceIsScalingByTheProduct)
{
  for (const Scheme scheme : {Scheme::constant_gravity, Scheme::constant_speed})
    for (const Policy policy : {Policy::paper, Policy::corrected, Policy::offset_liner}) {
      const OperatingPoint half_way = scale(paper_mill, request(1.3, scheme, policy)).mill;
      const OperatingPoint twice = scale(half_way, request(2.0, scheme, policy)).mill;
      const OperatingPoint once = scale(paper_mill, request(2.6, scheme, policy)).mill;
      EXPECT_NEAR(twice.radius, once.radius, 10 * rounding);
      EXPECT_NEAR(twice.gravity, once.gravity, 10 * rounding);
      EXPECT_NEAR(twice.omega, once.omega, 10 * rounding);
    }
}

TEST(Law, FrictionMatchedIsThePapersLawWithFrictionOverS)
{
  for (const Scheme scheme : {Scheme::constant_gravity, Scheme::constant_speed})
    for (const double S : factors) {
      const ScaledMill matched = scale(paper_mill, request(S, scheme, Policy::friction_matched));
      const ScaledMill paper = scale(paper_mill, request(S, scheme));
      EXPECT_EQ(matched.mill.radius, paper.mill.radius);
      EXPECT_EQ(matched.mill.omega, paper.mill.omega);
      EXPECT_EQ(matched.mill.gravity, paper.mill.gravity);
      EXPECT_EQ(paper.friction_ratio, 1.0);
      EXPECT_NEAR(matched.friction_ratio * S, 1.0, rounding);
    }
}

ScalingRequest friction_request(double S, double exponent)
{
  ScalingRequest wanted = request(S, Scheme::constant_gravity, Policy::friction_matched);
  wanted.friction_exponent = exponent;
  return wanted;
}

TEST(Law, FrictionMatchedTwiceIsFrictionMatchedByTheProduct)
{
  for (const double k : {0.5, 1.0, 1.17, 2.0}) {
    const double once = scale(paper_mill, friction_request(2.6, k)).friction_ratio;
    const double twice = scale(paper_mill, friction_request(1.3, k)).friction_ratio *
                         scale(paper_mill, friction_request(2.0, k)).friction_ratio;
    EXPECT_NEAR(twice, once, rounding);
    EXPECT_EQ(scale(paper_mill, friction_request(1.0, k)).friction_ratio, 1.0);
  }
  EXPECT_NEAR(scale(paper_mill, friction_request(4.0, 0.5)).friction_ratio, 0.5, rounding);
  EXPECT_NEAR(scale(paper_mill, friction_request(4.0, 2.0)).friction_ratio, 1.0 / 16, rounding);
}

TEST(Law, FroudeSchemeContainsTheOtherTwo)
{
  const double S = 2.6;
  const auto free = [S](double time_factor) {
    return scale(paper_mill, {S, Scheme::froude, Policy::paper, time_factor, false}).mill;
  };
  EXPECT_NEAR(free(1.0 / std::sqrt(S)).gravity, 9.81, 10 * rounding);
  EXPECT_NEAR(free(1.0).gravity, 9.81 / S, 10 * rounding);
  EXPECT_NEAR(free(1.0).omega, 1.0, rounding);
}

TEST(Law, EnergyRatioIsForceTimesHeight)
{
  for (const Scheme scheme : {Scheme::constant_gravity, Scheme::constant_speed, Scheme::froude}) {
    const ScaledMill scaled = scale(paper_mill, request(2.6, scheme));
    EXPECT_NEAR(scaled.predicted_energy_ratio, scaled.mill.gravity / 9.81 / 2.6, rounding);
    EXPECT_NEAR(scaled.centre_path_energy_ratio, scaled.mill.gravity / 9.81 * 1.48 / 3.88,
                rounding);
  }
}

TEST(Law, FactorOfAQuantityFollowsFromItsDimension)
{
  const BaseFactors base{0.5, 2.0, 4.0};
  EXPECT_DOUBLE_EQ(factor(base, dimension::force), 0.5 * 2.0 / 16.0);
  EXPECT_DOUBLE_EQ(factor(base, dimension::power), 0.25 * 2.0 / 64.0);
  EXPECT_DOUBLE_EQ(factor(base, {0, 0, 0}), 1.0);
}

TEST(LawErrors, NameTheValueAndWhatIsAccepted)
{
  const auto error = [](double S, OperatingPoint mill = paper_mill) {
    return error_of(mill, request(S, Scheme::constant_gravity));
  };
  EXPECT_NE(error(0.99).find("must be >= 1"), std::string::npos);
  EXPECT_NE(error(0.99).find("0.99"), std::string::npos);
  EXPECT_NE(error(195.0).find("S < 195"), std::string::npos);
  EXPECT_NE(error(NAN).find("got nan"), std::string::npos);
  EXPECT_NE(error(INFINITY).find("got inf"), std::string::npos);
  EXPECT_NE(error(2.0, {-3.9, 0.02, 9.81, 1.0}).find("mill radius"), std::string::npos);
  EXPECT_NE(error(2.0, {3.9, 0.0, 9.81, 1.0}).find("ball radius"), std::string::npos);
  EXPECT_NE(error(2.0, {3.9, 0.02, 0.0, 1.0}).find("gravity"), std::string::npos);
  EXPECT_NE(error(2.0, {3.9, 0.02, 9.81, NAN}).find("speed"), std::string::npos);
}

TEST(LawErrors, CentrifugingNeedsPermission)
{
  const OperatingPoint fast{3.9, 0.02, 9.81, 1.6};
  ScalingRequest wanted = request(2.6, Scheme::constant_gravity);
  EXPECT_NE(error_of(fast, wanted).find("Froude number"), std::string::npos);
  wanted.allow_centrifuging = true;
  EXPECT_EQ(error_of(fast, wanted), "");
}

TEST(LawErrors, TimeFactorBelongsToSchemeFroude)
{
  EXPECT_NE(error_of(paper_mill, {2.6, Scheme::constant_speed, Policy::paper, 1.0, false}), "");
  EXPECT_NE(error_of(paper_mill, {2.6, Scheme::froude, Policy::paper, 0.0, false}), "");
}

TEST(LawErrors, FrictionExponentIsInRangeAndOfFrictionMatchedOnly)
{
  for (const double k : {0.0, -1.0, 2.01, static_cast<double>(NAN)})
    EXPECT_NE(error_of(paper_mill, friction_request(2.6, k)).find("must be > 0 and <= 2"),
              std::string::npos);
  EXPECT_EQ(error_of(paper_mill, friction_request(2.6, 2.0)), "");
  for (const Policy policy : {Policy::paper, Policy::corrected, Policy::offset_liner}) {
    ScalingRequest wanted = request(2.6, Scheme::constant_gravity, policy);
    wanted.friction_exponent = 1.1;
    EXPECT_NE(error_of(paper_mill, wanted).find("only policy friction-matched"), std::string::npos);
  }
}

TEST(LawErrors, UnknownNamesListTheKnownOnes)
{
  EXPECT_EQ(scheme_from_name("constant-speed"), Scheme::constant_speed);
  EXPECT_EQ(policy_from_name("offset-liner"), Policy::offset_liner);
  EXPECT_EQ(policy_from_name("friction-matched"), Policy::friction_matched);
  EXPECT_THROW(scheme_from_name("constant_gravity"), std::invalid_argument);
  EXPECT_THROW(policy_from_name(""), std::invalid_argument);
}

}  // namespace
