#pragma once

#include <cmath>

#include "core/liner/profile.h"

namespace millscale::liner {

/// Area of the cavity [m^2], exact. Each piece adds the triangle from the axis to its chord. An arc
/// also adds the circular segment R^2 (h - sin h cos h) beyond the chord, h being half the arc's
/// angle. The segment is subtracted if the arc bulges into the cavity.
inline double area(const Profile& profile)
{
  double sector = 0.0;
  for (const Piece& piece : profile.pieces()) {
    sector += 0.5 * cross(piece.begin, piece.end);
    if (!piece.is_arc()) continue;
    const double h = piece.half_angle;
    const double segment = piece.arc_radius * piece.arc_radius * (h - std::sin(h) * std::cos(h));
    sector += piece.arc_radius > 0.0 ? segment : -segment;
  }
  return profile.sectors() * sector;
}

}  // namespace millscale::liner
