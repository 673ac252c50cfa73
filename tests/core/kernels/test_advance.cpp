// The pass over the balls between two evaluations of the forces, bit by bit.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "core/kernels/kernel.h"

namespace {

using namespace millscale;
using namespace millscale::kernels;

constexpr double dt = 1e-4;
constexpr signed char in_contact = 4;

/// Balls at the end of a step, and what the pass needs besides.
struct Balls {
  int count;
  RowStore store;
  std::vector<Kick> kick;
  std::vector<ListStart> start;
  std::vector<WallForce> wall;
  std::vector<double> damping;
  std::vector<signed char> wall_marks, seen, marks;
  std::vector<Moment> moments;
  std::vector<std::array<double, 3>> arrays[5];  ///< position, velocity, spin, force, torque
  EndOfStep end{};
  ContactWatch watch{};
  Advance pass{};

  Balls(int balls, bool single) : count(balls), start(balls)
  {
    const Rows rows = store.resize(balls, single, true);
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    for (int i = 0; i < balls; ++i) {
      const double radius = 0.01 + 0.001 * (i % 5), mass = 0.03 + 0.01 * (i % 7);
      const auto any = [&](double size) { return size * normal(random); };
      rows.position[i] = {any(1.0), any(1.0), any(1.0), radius};
      rows.velocity[i] = {
          {any(1.0), any(1.0), any(1.0)}, mass, {any(9.0), any(9.0), any(9.0)}, 0.1};
      const double f[] = {any(5.0), any(5.0), any(5.0)}, t[] = {any(0.1), any(0.1), any(0.1)};
      const double sum = std::abs(any(20.0));
      for (int d = 0; d < 3; ++d) {
        if (single) {
          rows.single_force[i].force[d] = static_cast<float>(f[d]);
          rows.single_force[i].torque[d] = static_cast<float>(t[d]);
        } else {
          rows.force[i].force[d] = f[d];
          rows.force[i].torque[d] = t[d];
        }
      }
      if (single)
        rows.single_force[i].damping = static_cast<float>(sum);
      else
        rows.force[i].damping = sum;
      start[i] = {rows.position[i].x + any(1e-4), rows.position[i].y, rows.position[i].z, 1e-3};
      kick.push_back({0.5 * dt / mass, 0.5 * dt / 0.4 / (radius * radius * mass)});
      for (int c = 0; c < i % 4; ++c) {
        WallForce& on = wall.emplace_back();
        for (int d = 0; d < 3; ++d) on.force[d] = any(3.0), on.torque[d] = any(0.1);
        on.damping = std::abs(any(5.0));
        on.ball = i;
      }
      wall_marks.push_back(i % 3 == 0 ? in_contact | 1 : 0);
      seen.push_back(i % 2 ? in_contact : 0);
    }
    damping.assign(balls, -1.0);
    marks.assign(balls, -1);
    moments.resize(balls);
    watch = {wall_marks.data(), seen.data(), marks.data(), in_contact, 1e-12, moments.data()};
    pass.rows = rows;
    pass.single = single;
    pass.balls = balls;
    pass.kick = kick.data();
    pass.dt = dt;
    pass.gravity = {0.3, -0.2, -9.81};
    pass.wall_begin = wall.data();
    pass.wall_end = wall.data() + wall.size();
    pass.damping = damping.data();
    pass.start = start.data();
    pass.moved_limit2 = 1.0;
    pass.own_skins = true;
    pass.turn_columns[0] = {std::cos(1e-4), 0.0, -std::sin(1e-4)};
    pass.turn_columns[1] = {0.0, 1.0, 0.0};
    pass.turn_columns[2] = {std::sin(1e-4), 0.0, std::cos(1e-4)};
    pass.checks_speed = true;
    pass.speed_limit2 = 1e6;
    pass.watch = &watch;
    for (auto& array : arrays) array.assign(balls + 1, {-1.0, -2.0, -3.0});
    const auto three = [](auto& array) { return reinterpret_cast<double(*)[3]>(array.data()); };
    end = {three(arrays[0]), three(arrays[1]), three(arrays[2]), three(arrays[3]),
           three(arrays[4])};
  }
};

/// The same step by the arithmetic of the engine: forces, both halves of fix nve/sphere, checks.
struct Expected {
  std::vector<PositionRow> position;
  std::vector<VelocityRow> velocity;
  std::vector<double> damping;
  std::vector<signed char> marks;
  std::vector<int> noticed;
  std::vector<std::array<double, 3>> arrays[5];  ///< at the end of the step
  bool left = false;

  explicit Expected(const Balls& balls)
  {
    const Advance& a = balls.pass;
    std::size_t next = 0;
    for (int i = 0; i < balls.count; ++i) {
      double force[3], torque[3], sum;
      for (int d = 0; d < 3; ++d) {
        force[d] = a.single ? a.rows.single_force[i].force[d] : a.rows.force[i].force[d];
        torque[d] = a.single ? a.rows.single_force[i].torque[d] : a.rows.force[i].torque[d];
      }
      sum = a.single ? a.rows.single_force[i].damping : a.rows.force[i].damping;
      PositionRow x = a.rows.position[i];
      VelocityRow v = a.rows.velocity[i];
      const auto add_weight = [&] {
        for (int d = 0; d < 3; ++d) force[d] += v.mass * a.gravity[d];
      };
      if (a.gravity_first) add_weight();
      for (; next < balls.wall.size() && balls.wall[next].ball == i; ++next) {
        for (int d = 0; d < 3; ++d) force[d] += balls.wall[next].force[d];
        for (int d = 0; d < 3; ++d) torque[d] += balls.wall[next].torque[d];
        sum += balls.wall[next].damping;
      }
      if (!a.gravity_first) add_weight();
      double square = 0.0;
      for (int d = 0; d < 3; ++d) {
        const double by_contacts = force[d] - v.mass * a.gravity[d];
        square = d == 0 ? by_contacts * by_contacts : square + by_contacts * by_contacts;
      }
      marks.push_back(balls.wall_marks[i] | (square > 1e-12 * v.mass * v.mass ? in_contact : 0));
      if (marks.back() != balls.seen[i]) noticed.push_back(i);
      arrays[0].push_back({x.x, x.y, x.z});
      for (int half = 0; half < 2; ++half) {
        for (int d = 0; d < 3; ++d) {
          v.velocity[d] += balls.kick[i].linear * force[d];
          v.spin[d] += balls.kick[i].angular * torque[d];
        }
        if (half == 1) continue;
        arrays[1].push_back({v.velocity[0], v.velocity[1], v.velocity[2]});
        arrays[2].push_back({v.spin[0], v.spin[1], v.spin[2]});
      }
      arrays[3].push_back({force[0], force[1], force[2]});
      arrays[4].push_back({torque[0], torque[1], torque[2]});
      v.damping_share = dt * sum / v.mass;
      x.x += dt * v.velocity[0];
      x.y += dt * v.velocity[1];
      x.z += dt * v.velocity[2];
      const double from[] = {balls.start[i].x, balls.start[i].y, balls.start[i].z};
      const double now[] = {x.x, x.y, x.z};
      double moved = 0.0;
      for (int d = 0; d < 3; ++d) {
        const Vector* c = a.turn_columns;
        const double way = now[d] - (c[0][d] * from[0] + c[1][d] * from[1] + c[2][d] * from[2]);
        moved += way * way;
      }
      left |= !(moved <= balls.start[i].skin * balls.start[i].skin);
      position.push_back(x);
      velocity.push_back(v);
      damping.push_back(sum);
    }
  }
};

std::vector<const Implementation*> with_pass()
{
  std::vector<const Implementation*> found;
  for (const Implementation& each : implementations())
    if (each.advance && each.supported()) found.push_back(&each);
  return found;
}

void expect_same(const Balls& balls, const Expected& expected)
{
  const Rows& rows = balls.pass.rows;
  for (int i = 0; i < balls.count; ++i) {
    EXPECT_EQ(rows.position[i].x, expected.position[i].x);
    EXPECT_EQ(rows.position[i].y, expected.position[i].y);
    EXPECT_EQ(rows.position[i].z, expected.position[i].z);
    EXPECT_EQ(rows.position[i].radius, expected.position[i].radius);
    EXPECT_EQ(rows.velocity[i].mass, expected.velocity[i].mass);
    EXPECT_EQ(rows.velocity[i].damping_share, expected.velocity[i].damping_share);
    for (int d = 0; d < 3; ++d) {
      EXPECT_EQ(rows.velocity[i].velocity[d], expected.velocity[i].velocity[d]);
      EXPECT_EQ(rows.velocity[i].spin[d], expected.velocity[i].spin[d]);
      if (!balls.pass.single) continue;
      EXPECT_EQ(rows.single_velocity[i].velocity[d],
                static_cast<float>(expected.velocity[i].velocity[d]));
      EXPECT_EQ(rows.single_force[i].force[d], 0.0f);
    }
    EXPECT_EQ(balls.damping[i], expected.damping[i]);
    EXPECT_EQ(balls.marks[i], expected.marks[i]);
  }
}

TEST(Advance, HasTheBitsOfTheEngine)
{
  ASSERT_FALSE(with_pass().empty());
  for (const Implementation* each : with_pass())
    for (const bool single : {false, true})
      for (const bool gravity_first : {false, true})
        for (const int count : {0, 1, 3, 4, 5, 98, 103}) {
          SCOPED_TRACE(std::string(each->name) + " of " + std::to_string(count));
          Balls balls(count, single);
          balls.pass.gravity_first = gravity_first;
          const Expected expected(balls);
          const Advanced found = each->advance(balls.pass);
          expect_same(balls, expected);
          ASSERT_EQ(found.moments, static_cast<int>(expected.noticed.size()));
          for (int k = 0; k < found.moments; ++k)
            EXPECT_EQ(balls.moments[k].ball, expected.noticed[k]);
          EXPECT_EQ(found.left_skin, expected.left);
          EXPECT_FALSE(found.fast);
          EXPECT_FALSE(found.moved);
        }
}

TEST(Advance, CopiesTheEndOfTheStepAndBeginsTheNextAlike)
{
  for (const Implementation* each : with_pass())
    for (const bool single : {false, true})
      for (const int count : {1, 4, 7, 98}) {
        SCOPED_TRACE(std::string(each->name) + " of " + std::to_string(count));
        Balls balls(count, single);
        balls.pass.copy = &balls.end;
        Expected expected(balls);
        const Advanced found = each->advance(balls.pass);
        expect_same(balls, expected);
        ASSERT_EQ(found.moments, static_cast<int>(expected.noticed.size()));
        for (int k = 0; k < found.moments; ++k) {
          const Moment& moment = balls.moments[k];
          EXPECT_EQ(moment.ball, expected.noticed[k]);
          EXPECT_EQ(moment.radius, balls.pass.rows.position[moment.ball].radius);
          for (int d = 0; d < 3; ++d) {
            EXPECT_EQ(moment.position[d], expected.arrays[0][moment.ball][d]);
            EXPECT_EQ(moment.velocity[d], expected.arrays[1][moment.ball][d]);
          }
        }
        for (int k = 0; k < 5; ++k) {
          expected.arrays[k].push_back({-1.0, -2.0, -3.0});  // beyond the last ball: untouched
          EXPECT_EQ(balls.arrays[k], expected.arrays[k]) << k;
        }
      }
}

TEST(Advance, NoticesTheBallThatLeavesItsSkin)
{
  for (const Implementation* each : with_pass())
    for (const int far : {0, 6, 9}) {
      Balls balls(10, false);
      for (ListStart& start : balls.start) start.skin = 1.0;
      EXPECT_FALSE(each->advance(balls.pass).left_skin);
      balls.start[far].skin = 1e-9;
      EXPECT_TRUE(each->advance(balls.pass).left_skin);
      balls.pass.own_skins = false;
      EXPECT_FALSE(each->advance(balls.pass).left_skin);
      balls.start[far].x += 2.0;
      EXPECT_TRUE(each->advance(balls.pass).moved);
    }
}

TEST(Advance, NamesTheFirstBallThatIsTooFast)
{
  for (const Implementation* each : with_pass())
    for (const double speed : {2000.0, -2000.0, double(NAN)}) {
      Balls balls(10, false);
      balls.pass.rows.velocity[9].velocity[0] = speed;
      balls.pass.rows.velocity[6].velocity[2] = speed;
      const double before = balls.pass.rows.position[6].x;
      const Advanced found = each->advance(balls.pass);
      ASSERT_TRUE(found.fast);
      EXPECT_EQ(found.first_fast.ball, 6);
      EXPECT_EQ(found.first_fast.position[0], before);
    }
}

}  // namespace
