#include <gtest/gtest.h>

#include <map>

#include "core/kernels/kernel.h"
#include "core/neighbor/cloud.h"

namespace {

using namespace millscale::kernels;
using namespace millscale::neighbor;

using Pairs = std::vector<std::array<int, 2>>;

/// List by definition: each local ball with every later ball whose surface is within the gap.
/// Rounding may put a pair exactly at the limit on either side. `slack` is relative to the limit.
Pairs brute_force(const Cloud& cloud, double gap, double slack = 0.0)
{
  Pairs found;
  for (int i = 0; i < cloud.nlocal(); ++i)
    for (int j = i + 1; j < cloud.all(); ++j) {
      const auto &a = cloud.position[i], &b = cloud.position[j];
      const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
      const double limit = (cloud.radius[i] + gap + cloud.radius[j]) * (1.0 + slack);
      if (x * x + y * y + z * z <= limit * limit) found.push_back({i, j});
    }
  return found;
}

Pairs pairs_of(const PairList& list)
{
  Pairs found;
  for (int i = 0; i < list.nlocal(); ++i)
    for (int k = 0; k < list.partners[i]; ++k) {
      EXPECT_EQ(list.own[list.first[i] + k], i);
      const int j = list.other[list.first[i] + k];
      found.push_back({std::min(i, j), std::max(i, j)});  // either ball may hold the pair
    }
  EXPECT_EQ(found.size(), static_cast<std::size_t>(list.entries));
  std::sort(found.begin(), found.end());
  return found;
}

void expect_brute_force(const PairList& list, const Cloud& cloud, double gap, const char* scene)
{
  const Pairs found = pairs_of(list);
  const Pairs needed = brute_force(cloud, gap, -1e-14), allowed = brute_force(cloud, gap, 1e-14);
  EXPECT_TRUE(std::includes(found.begin(), found.end(), needed.begin(), needed.end())) << scene;
  EXPECT_TRUE(std::includes(allowed.begin(), allowed.end(), found.begin(), found.end())) << scene;
  EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end()) << scene << ": twice";
}

/// The list by the fastest kernel; each kernel has its own test.
void build(PairList& list, const Cloud& cloud, double gap)
{
  build_within(list, cloud, gap, best_implementation().list_partners);
}

struct Scene {
  const char* name;
  Cloud cloud;
  int at_least;  ///< least number of pairs, so that the scene is a test
};

Cloud dense()
{
  return random_cloud({400, 0.1}, 2);
}

Cloud of_sizes_one_to_five()
{
  Cloud cloud = random_cloud({400, 0.3, 0.005, 0.025}, 3);
  for (int i = 0; i < 400; i += 10) cloud.radius[i] = i % 20 ? 0.005 : 0.025;
  return cloud;
}

/// Radii from 1 to 10, each of the same probability.
Cloud of_sizes_one_to_ten(int ghosts)
{
  return random_cloud({500, 0.15, 0.002, 0.02, 1, ghosts}, 13);
}

/// Balls of two sizes, one to ten; every `each`-th ball is large.
Cloud of_two_sizes(int each, double edge, int ghosts)
{
  Cloud cloud = random_cloud({900, edge, 0.002, 0.002, 1, ghosts}, 14);
  for (int i = 0; i < cloud.all(); i += each) cloud.radius[i] = 0.02;
  return cloud;
}

Cloud line(int axis, double spacing)
{
  Cloud cloud;
  for (int i = 0; i < 300; ++i) {
    std::array<double, 3> x{0.0, -3.0, 2.0};
    x[axis] += spacing * ((i * 77) % 300);  // not in order along the line
    cloud.add(x, 0.02);
  }
  return cloud;
}

Cloud at_one_point()
{
  Cloud cloud;
  for (int i = 0; i < 50; ++i) cloud.add({0.3, -0.2, 1e3}, 0.02);
  return cloud;
}

Cloud two_clusters_far_apart()
{
  Cloud cloud = random_cloud({200, 0.2}, 4);
  for (int i = 0; i < 200; i += 2) {
    cloud.position[i][0] += 1e6;
    cloud.position[i][2] -= 1e6;
  }
  return cloud;
}

Cloud of_negative_coordinates()
{
  Cloud cloud = random_cloud({400, 0.4}, 5);
  for (auto& x : cloud.position)
    for (double& coordinate : x) coordinate -= 7.3;
  return cloud;
}

/// Centres on the borders of cells: a lattice with the spacing of the cells, and a copy moved by a
/// rounding error.
Cloud on_the_borders_of_cells(double reach)
{
  Cloud cloud;
  for (int i = 0; i < 512; ++i) {
    std::array<double, 3> x{-0.3 + reach * (i % 8), 0.7 + reach * (i / 8 % 8), reach * (i / 64)};
    if (i % 3 == 1) x[i % 2] = std::nextafter(x[i % 2], i % 5 ? 10.0 : -10.0);
    cloud.add(x, 0.02);
  }
  return cloud;
}

Cloud with_ghosts()
{
  return random_cloud({400, 0.3, 0.01, 0.03, 1, 150}, 6);
}

constexpr double gap = 0.005;

std::vector<Scene> scenes()
{
  Cloud two;
  two.add({0.0, 0.0, 0.0}, 0.02);
  two.add({0.0, 0.03, 0.0}, 0.02);
  Cloud one;
  one.add({1.0, 2.0, 3.0}, 0.02);
  return {{"random", random_cloud({400, 0.4}, 1), 100},
          {"dense", dense(), 5000},
          {"sizes 1 to 5", of_sizes_one_to_five(), 400},
          {"sizes 1 to 10", of_sizes_one_to_ten(0), 2000},
          {"sizes 1 to 10, ghosts", of_sizes_one_to_ten(200), 2000},
          {"few large balls", of_two_sizes(50, 0.1, 0), 1500},
          {"few large balls, ghosts", of_two_sizes(50, 0.1, 400), 1500},
          {"few small balls", of_two_sizes(2, 0.3, 0), 1400},
          {"few small balls, ghosts", of_two_sizes(2, 0.3, 400), 1000},
          {"line x, touching", line(0, 0.04), 299},
          {"line y, as wide as the reach", line(1, 0.045), 0},
          {"line z, separated", line(2, 1.0), 0},
          {"one point", at_one_point(), 50 * 49 / 2},
          {"one ball", one, 0},
          {"two balls", two, 1},
          {"two clusters", two_clusters_far_apart(), 300},
          {"negative coordinates", of_negative_coordinates(), 100},
          {"borders of cells", on_the_borders_of_cells(0.045), 300},
          {"borders, touching", on_the_borders_of_cells(0.04), 1000},
          {"ghosts", with_ghosts(), 500}};
}

TEST(PairList, IsBruteForceInEveryScene)
{
  for (const Implementation& each : kernels())
    for (const Scene& scene : scenes()) {
      PairList list;
      build_within(list, scene.cloud, gap, each.list_partners);
      expect_brute_force(list, scene.cloud, gap, scene.name);
      EXPECT_GE(list.entries, scene.at_least) << scene.name;
    }
}

TEST(PairList, HasThePairsAtTheVeryReachWhateverTheRounding)
{
  // 129 of these spacings, times one over the spacing, is rounded to less than 129.
  const double spacing = 0.06120876588780821;
  Cloud cloud;
  for (int i = 0; i < 400; ++i)  // two lines, since cells of a single line are wider
    cloud.add({spacing * (i / 2), 0.1 * spacing * (i % 2), 0.0}, spacing / 4);
  PairList list;
  build(list, cloud, spacing / 2);
  expect_brute_force(list, cloud, spacing / 2, "at the reach");
  EXPECT_GT(list.entries, 50);
}

TEST(PairList, WithoutAGapHasTheBallsThatTouch)
{
  for (const Scene& scene : scenes()) {
    PairList list;
    build(list, scene.cloud, 0.0);
    expect_brute_force(list, scene.cloud, 0.0, scene.name);
  }
}

TEST(PairList, BuiltAgainKnowsNothingOfTheLastScene)
{
  PairList list;
  CellGrid grid;
  for (const Scene& scene : scenes()) {
    build_within(list, grid, scene.cloud, gap, best_implementation().list_partners);
    std::fill(list.displacement.begin(), list.displacement.end(), 1.0);
    std::fill(list.touching.begin(), list.touching.end(), 1);
    build_within(list, grid, scene.cloud, gap, best_implementation().list_partners);
    expect_brute_force(list, scene.cloud, gap, scene.name);
    const std::size_t room = list.entries + spare_entries;
    EXPECT_GE(list.other.size(), room);
    EXPECT_EQ(list.touching, std::vector<int>(room, 0)) << scene.name;
    EXPECT_GE(list.displacement.size(), 3 * room);
  }
}

TEST(PairList, HasNoPairsOfGhosts)
{
  const Cloud cloud = with_ghosts();
  PairList list;
  build(list, cloud, gap);
  int with_a_ghost = 0;
  for (const auto& pair : pairs_of(list)) {
    EXPECT_LT(pair[0], cloud.nlocal());
    with_a_ghost += pair[1] >= cloud.nlocal();
  }
  EXPECT_EQ(list.nlocal(), cloud.nlocal());
  EXPECT_GT(with_a_ghost, 100);
}

TEST(PairList, OfARankWithoutBallsIsEmpty)
{
  Cloud nobody, only_ghosts = random_cloud({30, 0.1}, 7);
  only_ghosts.ghosts = 30;
  for (const Cloud& cloud : {nobody, only_ghosts}) {
    PairList list;
    build(list, cloud, gap);
    EXPECT_EQ(list.nlocal(), 0);
    EXPECT_EQ(list.entries, 0);
  }
}

TEST(PairList, HasThePairsWithinTheSumOfBothSkins)
{
  const Cloud cloud = random_cloud({500, 0.4, 0.005, 0.025, 1, 120}, 10);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> share(0.0, 0.01);
  std::vector<double> skin;
  for (int i = 0; i < cloud.all(); ++i) skin.push_back(share(random));
  Cloud wider = cloud;
  for (int i = 0; i < cloud.all(); ++i) wider.radius[i] += skin[i];
  for (const Implementation& each : kernels()) {
    PairList list;
    CellGrid grid;
    millscale::neighbor::build(list, grid, cloud.view(), skin.data(), each.list_partners);
    expect_brute_force(list, wider, 0.0, each.name);
    EXPECT_GT(list.entries, 300);
  }
}

/// Two ranks cut along y, periodic along y: each has the images of all balls within reach as
/// ghosts.
TEST(PairList, OfTwoRanksHasEachPairOfARankOnceAndEachOtherPairOnBoth)
{
  constexpr double length = 0.2, skin = 0.001;
  Cloud all = random_cloud({700, length, 0.002, 0.02}, 15);
  for (auto& x : all.position) x[1] += 0.5 * length;
  const double cut = 2.0 * (0.02 + skin);
  const auto rank_of = [&](int i) { return all.position[i][1] < 0.5 * length ? 0 : 1; };
  std::map<std::array<int, 2>, int> listed;
  for (int rank = 0; rank < 2; ++rank) {
    Cloud cloud;
    std::vector<int> tag;
    for (int i = 0; i < all.all(); ++i)
      if (rank_of(i) == rank) cloud.add(all.position[i], all.radius[i]), tag.push_back(i);
    const double low = rank * 0.5 * length, high = low + 0.5 * length;
    for (const int image : {-1, 0, 1})
      for (int i = 0; i < all.all(); ++i) {
        std::array<double, 3> x = all.position[i];
        x[1] += image * length;
        if (x[1] < low - cut || x[1] >= high + cut || (image == 0 && rank_of(i) == rank)) continue;
        cloud.add(x, all.radius[i]), tag.push_back(i);
        ++cloud.ghosts;
      }
    PairList list;
    build(list, cloud, 2.0 * skin);
    for (const auto& pair : pairs_of(list))
      ++listed[{std::min(tag[pair[0]], tag[pair[1]]), std::max(tag[pair[0]], tag[pair[1]])}];
  }
  int of_both = 0;
  for (int i = 0; i < all.all(); ++i)
    for (int j = i + 1; j < all.all(); ++j) {
      const auto &a = all.position[i], &b = all.position[j];
      double y = std::abs(a[1] - b[1]);
      y = std::min(y, length - y);
      const double limit = all.radius[i] + all.radius[j] + 2.0 * skin;
      const double square = std::pow(a[0] - b[0], 2) + y * y + std::pow(a[2] - b[2], 2);
      if (std::abs(std::sqrt(square) - limit) < 1e-14) continue;  // rounding decides
      const int wanted = square > limit * limit ? 0 : rank_of(i) == rank_of(j) ? 1 : 2;
      const auto found = listed.find({i, j});
      ASSERT_EQ(found == listed.end() ? 0 : found->second, wanted) << i << ' ' << j;
      of_both += wanted == 2;
    }
  EXPECT_GT(of_both, 150);
}

/// Return how many candidates a ball has in a bed of this share of its volume.
double candidates_each(const Cloud& cloud, double gap)
{
  CellGrid grid;
  const std::vector<double> skin(cloud.all(), gap / 2);
  grid.sort(cloud.view(), skin.data());
  long candidates = 0;
  grid.for_each([&](int, const Centre&, const Candidates& found) {
    for (int k = 0; k < found.count; ++k) candidates += found.spans[k].end - found.spans[k].first;
  });
  return static_cast<double>(candidates) / cloud.all();
}

TEST(PairList, LargeBallsAmongSmallOnesAddFewCandidates)
{
  constexpr double radius = 0.002, skin = 0.0005;
  Cloud cloud = random_cloud({20000, 0.1, radius, radius}, 16);
  const double equal = candidates_each(cloud, skin);
  for (int i = 0; i < cloud.all(); i += 1000) cloud.radius[i] = 10.0 * radius;
  EXPECT_LT(candidates_each(cloud, skin), 2.0 * equal);
  EXPECT_GT(candidates_each(cloud, skin), equal);
}

TEST(PairList, MissesNoContactUntilABallHasMovedHalfTheGap)
{
  Cloud cloud = random_cloud({600, 0.45, 0.005, 0.025}, 8);
  PairList list;
  build(list, cloud, gap);
  const Pairs listed = pairs_of(list);
  const std::size_t touched_before = brute_force(cloud, 0.0).size();
  std::mt19937 random(9);
  std::normal_distribution<double> normal;
  for (auto& x : cloud.position) {
    std::array<double, 3> step{normal(random), normal(random), normal(random)};
    const double length = std::hypot(step[0], step[1], step[2]);
    for (int d = 0; d < 3; ++d) x[d] += 0.4999 * gap * step[d] / length;
  }
  const Pairs touching = brute_force(cloud, 0.0);
  EXPECT_TRUE(std::includes(listed.begin(), listed.end(), touching.begin(), touching.end()));
  EXPECT_NE(touching.size(), touched_before);
}

}  // namespace
