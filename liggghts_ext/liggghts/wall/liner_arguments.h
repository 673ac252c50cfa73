#pragma once

#include <string>

#include "core/liner/liner.h"
#include "liggghts/common/argument_list.h"

namespace millscale {

/// Keywords of the liner's shape, for the error that names what a style accepts.
inline constexpr const char* liner_keywords =
    "lifters, lifter_top_radius, lifter_top_width, groove_width, phase";

/// Reads the value of a keyword of the liner's shape [m, rad]; false if it is none.
inline bool read_liner_keyword(const std::string& key, ArgumentList& list, liner::Widths& widths)
{
  if (key == "lifters")
    widths.lifters = list.count(key, liner::most_lifters);
  else if (key == "lifter_top_radius")
    widths.lifter_top_radius = list.number(key);
  else if (key == "lifter_top_width")
    widths.lifter_top_width = list.number(key);
  else if (key == "groove_width")
    widths.groove_width = list.number(key);
  else if (key == "phase")
    widths.phase = list.number(key);
  else
    return false;
  return true;
}

}  // namespace millscale
