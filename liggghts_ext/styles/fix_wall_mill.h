#ifdef FIX_CLASS

FixStyle(wall / mill, FixWallMill)

#else

#ifndef LMP_FIX_WALL_MILL_H
#define LMP_FIX_WALL_MILL_H

#include <memory>
#include <string>
#include <vector>

#include "contact/wall_force.h"
#include "fix_per_ball_rows.h"
#include "liner/touches.h"

namespace LAMMPS_NS {

class FixMillSimilarity;

/// The rotating lifter-liner as an analytic wall with exact arcs: no mesh, no wall neighbour list,
/// no collective. Arguments and f_ID[k]: docs/styles.md.
class FixWallMill : public FixPerBallRows {
 public:
  FixWallMill(class LAMMPS*, int, char**);

  int setmask() override;
  void init() override;
  void setup(int) override;
  void post_force(int) override;
  double compute_vector(int) override;

  /// What ball i touched at the last evaluation of the forces.
  void contacts(int i, bool& wall, bool& liner) const;

 private:
  struct BallOnWall {
    double youngs_modulus, shear_modulus, damping;
    millscale::contact::Friction friction;
  };
  /// Where the mill is and how it moves at this step, for all balls.
  struct MillNow {
    millscale::Vector axis, across, down, origin, omega;
    double cosine, sine;
  };

  void parse(int narg, char** arg);
  void make_liner();
  void check_balls_fit();
  void read_materials();
  MillNow mill_now() const;
  void evaluate(double dt);
  void evaluate_ball(int i, const MillNow& mill, double dt);

  std::string mill_id_;
  FixMillSimilarity* mill_fix_ = nullptr;
  millscale::liner::Widths widths_;
  std::unique_ptr<millscale::liner::Liner> liner_;
  int wall_type_ = 0;
  bool rolling_ = true;
  std::vector<BallOnWall> of_type_;
  double on_wall_[6] = {};  ///< force and torque on the wall, this rank
  double** memory_ =
      nullptr;  ///< (n, slots * slot_size): key and tangential displacement of each touch
};

}  // namespace LAMMPS_NS

#endif
#endif
