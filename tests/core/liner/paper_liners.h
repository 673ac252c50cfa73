#pragma once

#include <vector>

#include "core/liner/liner.h"

namespace millscale::test {

/// Table 4's physical mill in both readings of its lifters.
inline liner::Liner trapezoid_mill(double phase = 0.0)
{
  return liner::Liner(liner::Widths{3.9, 3.61, 0.25, 0.635, 25, phase});
}

inline liner::Liner parallel_mill(double phase = 0.0)
{
  return liner::Liner(liner::Slopes{3.9, 3.61, 0.25, 0.0, 25, phase});
}

/// The paper's mill, coarse and flat lifters, the fewest lifters there can be, and no lifter.
inline std::vector<liner::Liner> various_liners()
{
  using liner::Liner;
  using liner::Slopes;
  using liner::Widths;
  return {trapezoid_mill(),
          parallel_mill(0.3),
          Liner(Widths{1.0, 0.7, 0.2, 0.9, 5, -1.0}),
          Liner(Slopes{1.0, 0.9, 0.3, 1.2, 3, 4.0}),
          Liner(Slopes{1.0, 0.5, 0.3, 0.2, 2, 0.1}),
          Liner(Widths{2.0, 0.0, 0.0, 0.0, 0, 0.5})};
}

}  // namespace millscale::test
