#pragma once

#include <iosfwd>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace millscale {

/// Adds our fixes and computes to this engine instance. Call once, after LAMMPS is constructed and
/// before the deck is read; the `clear` command builds a new Modify and loses them.
void register_styles(LAMMPS_NS::LAMMPS& engine);

/// Writes one line per style of ours, for `liggghts_mill -h`.
void list_styles(std::ostream& out);

}  // namespace millscale
