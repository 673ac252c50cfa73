#pragma once

#include <vector>

#include "core/liner/lifters.h"

namespace millscale::test {

/// Table 4's physical mill in both readings of its lifters.
inline liner::Lifters trapezoid_mill(double phase = 0.0)
{
  return liner::Lifters(liner::Widths{3.9, 3.61, 0.25, 0.635, 25, phase});
}

inline liner::Lifters parallel_mill(double phase = 0.0)
{
  return liner::Lifters(liner::Slopes{3.9, 3.61, 0.25, 0.0, 25, phase});
}

/// The paper's mill, coarse and flat lifters, the smallest number of lifters, and a drum without
/// lifters.
inline std::vector<liner::Lifters> various_liners()
{
  using liner::Lifters;
  using liner::Slopes;
  using liner::Widths;
  return {trapezoid_mill(),
          parallel_mill(0.3),
          Lifters(Widths{1.0, 0.7, 0.2, 0.9, 5, -1.0}),
          Lifters(Slopes{1.0, 0.9, 0.3, 1.2, 3, 4.0}),
          Lifters(Slopes{1.0, 0.5, 0.3, 0.2, 2, 0.1}),
          Lifters(Widths{2.0, 0.0, 0.0, 0.0, 0, 0.5})};
}

}  // namespace millscale::test
