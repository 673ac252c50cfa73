#pragma once

#include <iosfwd>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace millscale {

/// Add millscale's fixes and computes to this engine instance. Call once, after LAMMPS is
/// constructed and before the deck is read. The `clear` command builds a new Modify, which loses
/// the styles.
void register_styles(LAMMPS_NS::LAMMPS& engine);

/// Write one line per style of millscale, for `liggghts_mill -h`.
void list_styles(std::ostream& out);

}  // namespace millscale
