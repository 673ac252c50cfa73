#pragma once

#include <array>
#include <string>

#include "core/contact/contact_force.h"
#include "core/energy/contact_work.h"
#include "core/kernels/advance.h"
#include "core/kernels/rows.h"
#include "core/kernels/wall.h"
#include "core/neighbor/cells.h"
#include "core/neighbor/particles.h"

namespace millscale::energy {
class PairSums;
}

namespace millscale::kernels {

/// The pairs to evaluate: the arrays of a `neighbor::PairList`. The displacement of a pair that is
/// not in contact may be anything; a contact begins with none.
struct Pairs {
  int entries;
  const int *own, *other;
  int* touching;
  double* displacement;
};

/// The contact laws of the atom types.
struct Laws {
  const contact::ContactLaw<double>* of_types;  ///< types a and b: [a * types + b], from 0
  int types;
  int only_type;  ///< the type of all particles, from 1; 0 where they differ
};

/// One evaluation.
struct Step {
  double dt;                 ///< [s]
  bool advance;              ///< advance the tangential displacements; false at set-up
  bool reset_on_separation;  ///< end a contact's history at separation, not at the next list
};

/// Sums that the kernel adds to, for all particles; only local ones get any.
struct Sums {
  double (*force)[3];   ///< [N]
  double (*torque)[3];  ///< [N m]
  double* damping;      ///< if limited: sum of tangential coefficients [kg/s] of the step before;
                        ///< afterwards, for local particles, that of this step
};

/// What the force of all pairs needs. Nothing is owned here. Kernels `of rows` read positions,
/// velocities, spins, masses, radii and damping shares of all particles in `rows`, and add to the
/// force rows, which the caller clears. Of `particles` they read the types and counts, and of
/// `sums` nothing. The force rows of ghosts are not to be read.
struct Task {
  neighbor::Particles particles;
  const Rows* rows;  ///< as many as particles, in the kernel's precision
  Pairs pairs;
  Laws laws;
  contact::ContactTerms terms;
  Step step;
  Sums sums;
  double* largest_overlap = nullptr;     ///< raised to the largest overlap [m] if not null
  energy::WorkRecord* record = nullptr;  ///< of the work of contacts, if not null
};

using Evaluate = void (*)(const Task&);

/// One implementation of the kernels, compiled for a set of instructions.
struct Implementation {
  const char* name;                   ///< "x86-64-v3"
  const char* description;            ///< what it evaluates at a time
  const char* required_instructions;  ///< beyond x86-64
  bool (*supported)();                ///< whether this machine has the instructions
  Evaluate evaluate;                  ///< in double precision
  Evaluate evaluate_mixed;  ///< overlaps and sums over time in double precision, all else in single
                            ///< precision; null if there is none
  Evaluate evaluate_rows;   ///< of rows, in double precision; null if there is none
  Evaluate evaluate_rows_mixed;  ///< of rows, in mixed precision; null if there is none
  AdvanceBalls advance;          ///< null if there is none
  neighbor::ListPartners list_partners;
  const WallKernels* wall;
};

/// Return all implementations, from the plainest to the widest packs.
const std::array<Implementation, 3>& implementations();

/// Return the implementation with this name that the machine supports; null if there is none.
const Implementation* find_implementation(const std::string& name);

/// Return the implementation that is fastest on this machine, as measured at the first call. The
/// results do not depend on this choice: implementations with packs give the same bits.
const Implementation& best_implementation();

/// Evaluate in double precision, one contact at a time, and add to the energy budget.
void evaluate_with_budget(const Task&, energy::PairSums&);

}  // namespace millscale::kernels
