#pragma once

#include <cmath>
#include <stdexcept>
#include <string>

#include "core/math/format.h"

/// Checks of arguments. Each throws std::invalid_argument with what is accepted and the value got.
namespace millscale {

[[noreturn]] inline void reject(const std::string& what, const std::string& accepted, double got)
{
  throw std::invalid_argument(what + ": " + accepted + ", got " + format(got));
}

inline void require_positive(const std::string& what, const std::string& unit, double value)
{
  if (!(value > 0.0 && std::isfinite(value))) reject(what, "must be > 0 " + unit, value);
}

inline void require_finite(const std::string& what, double value)
{
  if (!std::isfinite(value)) reject(what, "must be a finite number", value);
}

}  // namespace millscale
