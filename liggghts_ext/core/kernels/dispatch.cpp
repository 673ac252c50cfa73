#include <cstdlib>

#include "core/kernels/kernel.h"

namespace millscale::pairs {

Kernel kernel(int level)
{
  if (level == 4) return {"x86-64-v4", v4::evaluate, v4::evaluate_mixed, v4::list_partners};
  if (level == 3) return {"x86-64-v3", v3::evaluate, v3::evaluate_mixed, v3::list_partners};
  return {"x86-64-v2", v2::evaluate, nullptr, v2::list_partners};
}

bool runs(int level)
{
  __builtin_cpu_init();
  if (level == 4) return __builtin_cpu_supports("x86-64-v4");
  if (level == 3) return __builtin_cpu_supports("x86-64-v3");
  return level == 2;
}

Kernel best_kernel()
{
  for (int level = 4; level > 2; --level)
    if (runs(level)) return kernel(level);
  return kernel(2);
}

}  // namespace millscale::pairs
