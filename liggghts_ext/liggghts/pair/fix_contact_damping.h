#pragma once

#include "liggghts/common/fix_per_ball_rows.h"

namespace LAMMPS_NS {

/// Sum of the tangential damping coefficients of each ball's contacts with balls [kg/s] at the last
/// step. Kept across ranks and restarts. Created by `pair_style gran ... surface fast
/// tangential_damping bounded`.
class FixContactDamping : public FixPerBallRows {
 public:
  static constexpr const char* style_name = "mill/contact_damping";

  FixContactDamping(class LAMMPS*, int, char**);

  int setmask() override { return 0; }
  int pack_comm(int, int*, double*, int, int*) override;
  void unpack_comm(int, int, double*) override;

  /// Return the sums of local balls and ghosts, after the owners have sent those of the ghosts.
  double* up_to_date();

  /// Return the sum of a local ball, to which the walls add.
  double& of_ball(int i) { return *row(i); }
};

}  // namespace LAMMPS_NS
