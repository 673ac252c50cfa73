#pragma once

#include <cstdio>
#include <string>

namespace millscale {

/// A number as people write it, for error messages: 9.81, not 9.810000.
inline std::string format(double value)
{
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

}  // namespace millscale
