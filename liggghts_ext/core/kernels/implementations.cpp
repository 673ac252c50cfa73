#include <algorithm>

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

}  // namespace

const std::array<Implementation, 3>& implementations()
{
  static const std::array<Implementation, 3> all{{
      {"x86-64-v2", "one contact at a time", "SSE3, SSSE3, SSE4.1, SSE4.2, POPCNT", supports_v2,
       v2::evaluate, nullptr, nullptr, nullptr, nullptr, neighbor::v2::list_partners, &v2::wall},
      {"x86-64-v3", "four contacts at a time, eight in mixed precision, with 32-byte registers",
       "AVX2, FMA, BMI1, BMI2, F16C, LZCNT, MOVBE", supports_v3, v3::evaluate, v3::evaluate_mixed,
       v3::evaluate_rows, v3::evaluate_rows_mixed, v3::advance, neighbor::v3::list_partners,
       &v3::wall},
      {"x86-64-v4", "as x86-64-v3, with twice the registers and masks", "AVX-512 F, BW, CD, DQ, VL",
       supports_v4, v4::evaluate, v4::evaluate_mixed, v4::evaluate_rows, v4::evaluate_rows_mixed,
       v4::advance, neighbor::v4::list_partners, &v4::wall},
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
  const auto& all = implementations();
  const auto best =
      std::find_if(all.rbegin(), all.rend(), [](const auto& each) { return each.supported(); });
  return best == all.rend() ? all.front() : *best;
}

}  // namespace millscale::kernels
