#include <gtest/gtest.h>

#include <limits>

#include "core/energy/contact_sums.h"
#include "core/energy/energy_budget.h"
#include "core/energy/impact_spectrum.h"

namespace {

using namespace millscale::energy;
namespace contact = millscale::contact;

TEST(ImpactSpectrum, AnEnergyLiesBetweenTheEdgesOfItsBin)
{
  for (double energy = 2e-11; energy < 900.0; energy *= 1.7) {
    const int bin = ImpactSpectrum::bin_of(energy);
    EXPECT_LE(ImpactSpectrum::edge(bin), energy);
    EXPECT_GT(ImpactSpectrum::edge(bin + 1), energy);
  }
}

TEST(ImpactSpectrum, TheEndsTakeWhatIsBeyond)
{
  EXPECT_EQ(ImpactSpectrum::bin_of(0.0), 0);
  EXPECT_EQ(ImpactSpectrum::bin_of(1e-300), 0);
  EXPECT_EQ(ImpactSpectrum::bin_of(1e9), ImpactSpectrum::bins - 1);
  EXPECT_EQ(ImpactSpectrum::bin_of(std::numeric_limits<double>::infinity()),
            ImpactSpectrum::bins - 1);
  EXPECT_EQ(ImpactSpectrum::bin_of(std::numeric_limits<double>::quiet_NaN()), 0);
}

TEST(ContactSums, ImpactsOfTheWindowGoToTheSpectrumAndAllToTheSums)
{
  ContactSums sums;
  sums.begin_contact(1e-3, 1.0);
  sums.in_window = true;
  sums.begin_contact(1e-3, 0.5);
  sums.begin_contact(0.0, 1.0);  // separation
  EXPECT_DOUBLE_EQ(sums.impacts, 1.5);
  EXPECT_DOUBLE_EQ(sums.impact_energy, 1.5e-3);
  const int bin = ImpactSpectrum::bin_of(1e-3);
  EXPECT_DOUBLE_EQ(sums.spectrum.count[bin], 0.5);
  EXPECT_DOUBLE_EQ(sums.spectrum.energy_sum[bin], 0.5e-3);
}

TEST(PairSums, AContactBeginsOnceUntilSeparation)
{
  PairSums sums;
  const int touching[] = {1, 0};
  sums.begin_list(touching, 2);
  EXPECT_FALSE(sums.begins(0));  // contact of the previous list
  EXPECT_TRUE(sums.begins(1));
  EXPECT_FALSE(sums.begins(1));
  sums.separated(1);
  EXPECT_TRUE(sums.begins(1));
}

TEST(WorkSums, ARunInTwoPartsIsTheRunInOne)
{
  const auto power = [](double value) {
    Works w;
    w.of_mill = value;
    return w;
  };
  WorkSums whole, parts;
  whole.wait_for(power(1.0), 0.1);
  parts.wait_for(power(1.0), 0.1);
  whole.step(power(2.0), power(3.0), 0.1);
  parts.step(power(2.0), power(3.0), 0.1);
  EXPECT_DOUBLE_EQ(whole.done.of_mill, 0.05 * (1.0 + 2.0));
  whole.step(power(4.0), power(5.0), 0.1);
  // The engine evaluates the forces anew between two runs; the waiting half kick uses these forces.
  parts.wait_for(power(3.0), 0.1);
  parts.step(power(4.0), power(5.0), 0.1);
  EXPECT_DOUBLE_EQ(parts.done.of_mill, whole.done.of_mill);
  EXPECT_DOUBLE_EQ(whole.done.of_mill, 0.05 * (1.0 + 2.0 + 3.0 + 4.0));
}

TEST(Terms, TangentialDissipationIsTheWorkDoneOnTheContactLessWhatItStores)
{
  std::array<double, contact::works> work{};
  work[contact::normal_spring] = -5.0;
  work[contact::normal_dashpot] = -7.0;
  work[contact::tangential_spring] = -11.0;
  work[contact::tangential_dashpot] = -2.0;
  work[contact::rolling] = -0.5;
  const PairingTerms t = terms_of(work, {1.0, 1.0}, {5.5, 4.0}, 6.0);
  EXPECT_DOUBLE_EQ(t.elastic_normal, 4.5);
  EXPECT_DOUBLE_EQ(t.spring_error, 0.5);
  EXPECT_DOUBLE_EQ(t.dissipated_normal, 7.0);
  EXPECT_DOUBLE_EQ(t.dissipated_tangential, 11.0 + 2.0 - 3.0);
  EXPECT_DOUBLE_EQ(t.dissipated_rolling, 0.5);
  EXPECT_DOUBLE_EQ(t.tangential_slip, 6.0);
}

}  // namespace
