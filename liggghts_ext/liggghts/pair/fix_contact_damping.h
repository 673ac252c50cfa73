#pragma once

#include "liggghts/common/fix_per_ball_rows.h"

namespace LAMMPS_NS {

/// Sum of the tangential damping coefficients of each ball's contacts with balls [kg/s], of the
/// last step, for balls and ghosts, across ranks and restarts. Made by `pair_style gran ... surface
/// fast tangential_damping bounded`.
class FixContactDamping : public FixPerBallRows {
 public:
  static constexpr const char* style_name = "mill/contact_damping";

  FixContactDamping(class LAMMPS*, int, char**);

  int setmask() override { return 0; }
  int pack_comm(int, int*, double*, int, int*) override;
  void unpack_comm(int, int, double*) override;

  /// (balls and ghosts); the ghosts' are those of their balls.
  double* up_to_date();

  /// Sum of an owned ball, to which the walls add theirs.
  double& of_ball(int i) { return *row(i); }
};

}  // namespace LAMMPS_NS
