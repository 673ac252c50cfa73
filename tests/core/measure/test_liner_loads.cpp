#include <gtest/gtest.h>

#include <cmath>

#include "core/measure/liner_loads.h"

namespace {

using namespace millscale::charge;
using millscale::pi;

TEST(LinerLoads, FollowASectorAroundTheMill)
{
  // Four sectors of three places; sector 1 has a load of 1 N in each step.
  LinerLoadSums sums({1, 4, 2, 3});
  const int steps = 12000;
  const double dt = 0.01, turned = 2.0 * pi / steps;
  for (int step = 0; step < steps; ++step) {
    sums.begin_step((step + 0.5) * turned, dt);
    LinerLoads loads{};
    loads[normal_impulse] = dt;
    sums.add(0, 1, 1, loads);
  }
  sums.advance();
  double whole = 0.0;
  for (int place = 0; place < 12; ++place) {
    // Each sector is in a place for a twelfth of the turn.
    EXPECT_NEAR(sums.time(place), 4.0 * steps * dt / 12.0, 1e-9);
    EXPECT_NEAR(sums.of_place(0, place, 1)[normal_impulse], steps * dt / 12.0, 1e-9);
    EXPECT_EQ(sums.of_place(0, place, 0)[normal_impulse], 0.0);
    whole += sums.of_place(0, place, 1)[normal_impulse];
  }
  EXPECT_NEAR(sums.of_sector(0, 1, 1)[normal_impulse], whole, 1e-9);
  EXPECT_EQ(sums.of_sector(0, 2, 1)[normal_impulse], 0.0);
  EXPECT_NEAR(sums.total()[normal_impulse], whole, 1e-9);
}

TEST(LinerLoads, PutALoadWhereItsSectorIs)
{
  for (const double turns : {0.0, 0.3, 7.0, 12.6}) {
    LinerLoadSums sums({1, 5, 1, 4});
    const double angle = 2.0 * pi * turns + 1e-9;
    sums.begin_step(angle, 1.0);
    LinerLoads loads{};
    loads[impacts] = 1.0;
    sums.add(0, 3, 0, loads);
    sums.advance();
    const double place = std::fmod(angle + 3.0 * 2.0 * pi / 5.0, 2.0 * pi) / (2.0 * pi) * 20.0;
    EXPECT_EQ(sums.of_place(0, static_cast<int>(place), 0)[impacts], 1.0) << turns;
  }
}

TEST(LinerLoads, GoOnFromTheirParts)
{
  const LinerLoadSums::Size size{2, 3, 2, 2};
  const auto step = [](LinerLoadSums& sums, int k) {
    sums.begin_step(0.1 * k, 0.01);
    LinerLoads loads{};
    loads[slip_work] = 0.1 + k;
    sums.add(k % 2, k % 3, k / 2 % 2, loads);
  };
  LinerLoadSums whole(size), first(size), second(size);
  for (int k = 0; k < 50; ++k) step(whole, k);
  for (int k = 0; k < 20; ++k) step(first, k);
  first.advance();
  second.set_parts(first.parts().data());
  second.times() = first.times();
  for (int k = 20; k < 50; ++k) step(second, k);
  whole.advance();
  second.advance();
  EXPECT_EQ(whole.part_count(), whole.parts().size());
  const auto expected = whole.parts(), got = second.parts();
  for (std::size_t k = 0; k < expected.size(); ++k) EXPECT_NEAR(got[k], expected[k], 1e-12);
  for (int place = 0; place < size.places(); ++place)
    EXPECT_NEAR(second.time(place), whole.time(place), 1e-12);
}

TEST(FinnieEnergy, IsThePublishedFunctionOfTheAngle)
{
  const double mass = 0.3, speed = 4.0;
  for (const double angle : {0.01, 0.2, std::atan(1.0 / 3.0) - 1e-9, 0.5, 1.0, 1.5}) {
    const double sine = std::sin(angle), cosine = std::cos(angle);
    const double f = std::tan(angle) <= 1.0 / 3.0 ? std::sin(2.0 * angle) - 3.0 * sine * sine
                                                  : cosine * cosine / 3.0;
    EXPECT_NEAR(finnie_energy_of(mass, speed * sine, speed * cosine),
                0.5 * mass * speed * speed * f, 1e-8)
        << angle;
  }
  EXPECT_EQ(finnie_energy_of(mass, speed, 0.0), 0.0);
}

}  // namespace
