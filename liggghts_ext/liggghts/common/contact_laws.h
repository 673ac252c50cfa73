#pragma once

#include <vector>

#include "core/contact/material.h"

namespace LAMMPS_NS {

class LAMMPS;

/// Contact constants of two atom types from the deck's `property/global` fixes.
struct TypePair {
  double youngs_modulus, shear_modulus;  ///< effective [Pa]
  double damping;                        ///< damping factor [-]
  double sliding, rolling;               ///< coefficients of friction [-]
};

/// Of all pairs of types: [a * types + b], from 0. `asker` is named in the engine's error when a
/// property is missing; friction and rolling friction are read only if asked for.
/// Throws std::invalid_argument if a value is not physical.
std::vector<TypePair> contact_laws(LAMMPS* engine, const char* asker, bool sliding, bool rolling);

}  // namespace LAMMPS_NS
