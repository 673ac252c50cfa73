#ifdef FIX_CLASS

FixStyle(mill / forces, FixMillForces)

#else

#ifndef LMP_FIX_MILL_FORCES_H
#define LMP_FIX_MILL_FORCES_H

#include "fix.h"

namespace LAMMPS_NS {

/// Carries each ball's force and torque through a restart, so that n steps + restart + n steps
/// equal 2n steps. Without it the engine evaluates the forces anew with the velocities of the full
/// step, while a running simulation evaluates them at the half step: the dashpots then differ by
/// O(dt), and the packed bed gets a bump. Define it last: docs/styles.md.
class FixMillForces : public Fix {
 public:
  FixMillForces(class LAMMPS*, int, char**);
  ~FixMillForces() override;

  int setmask() override;
  void init() override;
  void setup(int) override;

  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  int pack_exchange(int, double*) override;
  int unpack_exchange(int, double*) override;
  int pack_restart(int, double*) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override;
  int maxsize_restart() override;

 private:
  static constexpr int width = 6;  ///< force and torque
  bool restored_ = false;          ///< stored_ holds what the restart file held
  double** stored_ = nullptr;      ///< (n, width)
};

}  // namespace LAMMPS_NS

#endif
#endif
