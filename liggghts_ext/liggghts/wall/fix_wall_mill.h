#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/contact/contact_force.h"
#include "core/kernels/advance.h"
#include "core/kernels/wall.h"
#include "core/liner/contacts.h"
#include "core/liner/end_walls.h"
#include "liggghts/common/fix_per_ball_rows.h"
#include "liggghts/mill/liner_arguments.h"

namespace LAMMPS_NS {

class FixContactDamping;
class FixMillImpacts;
class FixMillLedger;
class FixMillLinerLoads;
class FixMillSimilarity;

/// The rotating liner as an analytic wall, with exact arcs or the mesh's polygon, and flat ends. It
/// needs no mesh, no neighbour list of the wall and no collective communication. Arguments and
/// f_ID[k]: docs/reference/styles/fix-wall-mill.md.
class FixWallMill : public FixPerBallRows {
 public:
  FixWallMill(class LAMMPS*, int, char**);

  int setmask() override;
  void init() override;
  void setup(int) override;
  void post_force(int) override;

  /// Evaluate the contacts of all local balls at this step and advance their histories by dt [s];
  /// 0: at set-up. Return the force of each contact, in ascending order of the balls. The caller
  /// adds the forces. The result is valid until the next call.
  const std::vector<millscale::kernels::WallForce>& evaluate(
      const millscale::kernels::WallInput& input, double dt);

  double compute_vector(int) override;

  const std::string& mill_id() const { return mill_id_; }
  /// Liner given by the arguments of the wall, used if the mill has none.
  millscale::liner::Widths widths() const;
  bool has_ends() const { return ends_.has_value(); }
  /// Profile that the contacts follow, after `init`.
  const millscale::liner::Profile& contact_profile() const { return finder_->profile(); }
  /// Number of patches of the liner, after `init`; those of the ends follow.
  int liner_patches() const { return static_cast<int>(finder_->patches().size()); }

  /// Return this rank's contribution to the torque on all surfaces that turn with the mill [N m].
  /// The torque is about the mill's origin, at the last evaluation of the forces.
  const millscale::Vector& torque_on_turning() const { return torque_on_turning_; }

  /// Return this rank's contribution to the torque on the ends, turning or at rest [N m]. The
  /// torque is about the mill's origin, at the last evaluation of the forces.
  const millscale::Vector& torque_on_ends() const { return torque_on_ends_; }
  bool ends_turn() const { return ends_turn_; }

  /// Mark the balls in contact at the last evaluation of the forces. Add the bits of `wall` for the
  /// wall and the bits of `groove` for a groove. marks: of local balls.
  void mark_contacts(std::vector<signed char>& marks, signed char wall, signed char groove) const;

 private:
  /// A surface of liner or end that a patch belongs to.
  struct Surface {
    double key;        ///< identifies the history of a contact, never 0
    signed char mark;  ///< bit in `touching_`
  };

  /// Balls that may touch the wall before the next neighbour list. Entry by entry, with a few
  /// entries more for the last pack.
  struct Near {
    std::vector<int> ball;
    std::vector<int> sector;            ///< of the last search
    std::vector<int> patch, second;     ///< the only ones that the ball may touch, or none
    std::vector<double> x, z, along;    ///< centre at the last search, in the wall's directions [m]
    std::vector<double> clear2;         ///< square of the distance that the centre can move before
                                        ///< it may touch another patch [m^2]
    std::vector<std::uint64_t> tracks;  ///< bits of the entries that have a patch
    int count = 0;

    void clear();
    void add(int i);
    void end();
    millscale::kernels::NearBalls view() const;
  };

  void parse(int narg, char** arg);
  void take_liner();
  void check_box() const;
  double largest_ball() const;
  void check_balls_fit(double largest) const;
  void check_balls_are_inside() const;
  void read_materials();
  void make_patches();
  millscale::kernels::WallFrame frame_now() const;
  void add_forces(double dt);
  void find_near();
  double* slot(int i, int contact) const;
  void count_touching();
  void fetch_ahead(int block) const;
  void look_at(int entry, bool moved);
  void add_contact(int i, int patch);
  void evaluate_batch();
  void store_history(int i, int begin, int end);
  void add_to_sums(int k);

  std::string mill_id_;
  FixMillSimilarity* mill_fix_ = nullptr;
  FixMillLedger* ledger_ = nullptr;     ///< the energy budget, if there is one
  FixMillImpacts* impacts_ = nullptr;   ///< the spectra of impacts, if there are any
  FixMillLinerLoads* loads_ = nullptr;  ///< loads of the liner, if they are wanted
  bool records_ = false;                ///< the contacts of this step count among the loads
  millscale::LinerArguments liner_arguments_;
  double chord_error_ = 0.0;  ///< of the grooves' polygon [m]; 0: exact arcs
  std::shared_ptr<const millscale::liner::Profile> liner_;  ///< exact arcs, or their chords
  std::unique_ptr<millscale::liner::ContactFinder> finder_;
  std::optional<millscale::liner::EndWalls> ends_;
  bool ends_turn_ = true;
  int wall_type_ = 0, end_type_ = 0;
  int end_laws_ = 0;  ///< index of the first law of the ends
  millscale::contact::ContactTerms terms_;
  FixContactDamping* damping_ = nullptr;  ///< sums of ball-ball contacts, if limited
  std::vector<millscale::contact::ContactLaw<double>> law_of_type_;
  std::vector<millscale::liner::Patch> patches_;  ///< of the liner, then lower and upper end
  std::vector<Surface> surfaces_;                 ///< of the patches
  const millscale::kernels::WallKernels* kernels_;
  Near near_;                          ///< balls that may touch, or did
  std::vector<signed char> touching_;  ///< contacts of each ball at the last evaluation, as bits

  // The evaluation of a step.
  millscale::kernels::WallTask task_{};
  millscale::kernels::WallBatch batch_;
  std::vector<millscale::kernels::WallForce> forces_;
  int slot_before_[millscale::kernels::WallBatch::most];  ///< of the contacts of the batch, or none
  double on_wall_[6] = {};  ///< force and torque on liner and ends, this rank
  millscale::Vector torque_on_turning_{}, torque_on_ends_{};
};

}  // namespace LAMMPS_NS
