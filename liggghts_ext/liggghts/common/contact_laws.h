#pragma once

#include <vector>

#include "core/contact/contact_force.h"

namespace LAMMPS_NS {

class LAMMPS;

/// Return the contact laws of all pairs of atom types, [a * types + b] from 0, from the deck's
/// `property/global` fixes. The engine's error about a missing property names `asker`. Friction and
/// rolling friction are read only if asked for. Throws std::invalid_argument if a value is not
/// physical.
std::vector<millscale::contact::ContactLaw<double>> contact_laws(LAMMPS* engine, const char* asker,
                                                                 bool sliding, bool rolling);

}  // namespace LAMMPS_NS
