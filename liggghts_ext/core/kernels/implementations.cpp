#include <algorithm>
#include <chrono>
#include <vector>

#include "core/kernels/kernel.h"
#include "core/kernels/levels.h"

namespace millscale::kernels {
namespace {

// __builtin_cpu_supports takes literals only; it reads the extended state that the system saves.
bool supports_v2()
{
  __builtin_cpu_init();
  return __builtin_cpu_supports("x86-64-v2");
}
bool supports_v3()
{
  __builtin_cpu_init();
  return __builtin_cpu_supports("x86-64-v3");
}
bool supports_v4()
{
  __builtin_cpu_init();
  return __builtin_cpu_supports("x86-64-v4");
}

/// A bed for measurements: balls on a cubic grid, whose pairs are neighbours along the axes. Every
/// other pair overlaps.
class GridBed {
 public:
  GridBed()
  {
    const Rows rows = store_.resize(count);
    for (int i = 0; i < count; ++i) {
      const int at[3] = {i % edge, i / edge % edge, i / (edge * edge)};
      const auto along = [&](int d) { return spacing * at[d] + (at[d] % 2 ? gap : -gap); };
      rows.position[i] = {along(0), along(1), along(2), 0.5 * spacing};
      rows.velocity[i] = {
          {0.1 * at[0], 0.1 * at[1], 0.1 * at[2]}, 0.03, {1.0 * at[2], 2.0, 3.0}, 0.0};
      for (const int step : {1, edge, edge * edge})
        if (i + step < count && at[step == 1 ? 0 : step == edge ? 1 : 2] + 1 < edge) {
          own_.push_back(i);
          other_.push_back(i + step);
        }
    }
    entries_ = static_cast<int>(own_.size());
    own_.resize(entries_ + neighbor::spare_entries);
    other_.resize(own_.size());
    touching_.resize(own_.size());
    displacement_.resize(3 * own_.size());
  }

  /// Return the time of an evaluation [s].
  double time_of(Evaluate evaluate)
  {
    const Rows rows = store_.rows();
    const Task task{{nullptr, nullptr, nullptr, nullptr, nullptr, type_.data(), count, 0},
                    &rows,
                    {entries_, own_.data(), other_.data(), touching_.data(), displacement_.data()},
                    {&law_, 1, 1},
                    {},
                    {1e-6, true, true},
                    {}};
    const auto begin = std::chrono::steady_clock::now();
    for (int repeat = 0; repeat < 4; ++repeat) evaluate(task);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() / 4;
  }

 private:
  static constexpr int edge = 10, count = edge * edge * edge;
  static constexpr double spacing = 0.02, gap = 1e-4;
  RowStore store_;
  std::vector<int> own_, other_, touching_, type_ = std::vector<int>(count, 1);
  std::vector<double> displacement_;
  int entries_ = 0;
  contact::ContactLaw<double> law_ = contact::contact_law({3e7, 7e6, 0.5, 0.5, 0.01});
};

/// Return the fastest of the implementations with packs, by the least time of several rounds, a few
/// milliseconds in all. Without any, return the plainest.
const Implementation& fastest()
{
  const auto& all = implementations();
  GridBed bed;
  double least[3] = {1.0, 1.0, 1.0};
  for (int round = 0; round < 10; ++round)
    for (std::size_t k = 0; k < all.size(); ++k)
      if (all[k].evaluate_rows && all[k].supported())
        least[k] = std::min(least[k], bed.time_of(all[k].evaluate_rows));
  return all[std::min_element(least, least + 3) - least];
}

}  // namespace

const std::array<Implementation, 3>& implementations()
{
  static const std::array<Implementation, 3> all{{
      {"x86-64-v2", "one contact at a time", "SSE3, SSSE3, SSE4.1, SSE4.2, POPCNT", supports_v2,
       v2::evaluate, nullptr, nullptr, nullptr, nullptr, neighbor::v2::list_partners, &v2::wall},
      {"x86-64-v3", "packs of four contacts, eight in mixed precision, in 32-byte registers",
       "AVX2, FMA, BMI1, BMI2, F16C, LZCNT, MOVBE", supports_v3, v3::evaluate, v3::evaluate_mixed,
       v3::evaluate_rows, v3::evaluate_rows_mixed, v3::advance, neighbor::v3::list_partners,
       &v3::wall},
      {"x86-64-v4", "packs of eight contacts, sixteen in mixed precision, in 64-byte registers",
       "AVX-512 F, BW, CD, DQ, VL", supports_v4, v4::evaluate, v4::evaluate_mixed,
       v4::evaluate_rows, v4::evaluate_rows_mixed, v4::advance, neighbor::v4::list_partners,
       &v4::wall},
  }};
  return all;
}

const Implementation* find_implementation(const std::string& name)
{
  for (const Implementation& each : implementations())
    if (each.name == name && each.supported()) return &each;
  return nullptr;
}

const Implementation& best_implementation()
{
  static const Implementation& best = fastest();
  return best;
}

}  // namespace millscale::kernels
