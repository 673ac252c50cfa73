#pragma once

#include "core/contact/contact_force.h"
#include "core/contact/damping_limit.h"
#include "core/kernels/rows.h"
#include "core/neighbor/cells.h"

namespace millscale::ledger {
class PairSums;
}

namespace millscale::pairs {

/// What the force of all pairs needs. Nothing is owned here. The list is a `HalfList`.
struct Task {
  Balls balls;
  const Rows* rows;  ///< room for as many balls, in the kernel's precision
  int entries;
  const int *own, *other;
  int* touching;
  double* displacement;
  const contact::ContactLaw<double>* law;  ///< of types a and b: law[a * types + b], from 0
  int types;
  int only_type;  ///< the type of all balls; 0 where they differ
  contact::ContactTerms terms;
  double dt;            ///< [s]
  bool advance;         ///< false at set-up: memories are used as they are
  bool forget_apart;    ///< a contact's memory ends when the balls part, not at the next list
  double (*force)[3];   ///< of all balls, owned and ghost; only owned balls get any [N]
  double (*torque)[3];  ///< [N m]
  double* damping;  ///< if limited, of all balls: see `contact::damping_share`; of owned ones the
                    ///< step's own sum afterwards [kg/s]
};

using Evaluate = void (*)(const Task&);

/// The same source compiled for levels of x86-64: the forces of all pairs, the partners of a ball.
namespace v2 {
void evaluate(const Task&);
/// The same, and what the contacts do with the energy: for `fix mill/ledger`.
void evaluate(const Task&, ledger::PairSums&);
int* list_partners(const Candidates&, Centre, int* out);
}  // namespace v2
namespace v3 {
void evaluate(const Task&);
void evaluate_mixed(const Task&);
int* list_partners(const Candidates&, Centre, int* out);
}  // namespace v3
namespace v4 {
void evaluate(const Task&);
void evaluate_mixed(const Task&);
int* list_partners(const Candidates&, Centre, int* out);
}  // namespace v4

struct Kernel {
  const char* level;        ///< "x86-64-v3", ...
  Evaluate evaluate;        ///< in double precision
  Evaluate evaluate_mixed;  ///< overlaps and sums over time in double precision, else in single
  ListPartners list_partners;
};

inline constexpr int levels = 3;
/// Of level 2, 3 or 4; level 2 has no mixed kernel (null). Whether this machine can run it: `runs`.
Kernel kernel(int level);
bool runs(int level);
/// The best this machine can run.
Kernel best_kernel();

}  // namespace millscale::pairs
