#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/contact/contact_force.h"
#include "core/liner/contacts.h"
#include "core/liner/end_walls.h"
#include "liggghts/common/fix_per_ball_rows.h"
#include "liggghts/mill/liner_arguments.h"
#include "liggghts/wall/wall_force.h"

namespace LAMMPS_NS {

class FixContactDamping;
class FixMillLedger;
class FixMillSimilarity;

/// The rotating liner as an analytic wall, with exact arcs or the mesh's polygon, and flat ends. It
/// needs no mesh, no neighbour list of the wall and no collective communication. Arguments and
/// f_ID[k]: docs/reference/styles.md.
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
  const std::vector<WallForce>& evaluate(const WallInput& input, double dt);

  double compute_vector(int) override;

  const std::string& mill_id() const { return mill_id_; }
  /// Liner given by the arguments of the wall, used if the mill has none.
  millscale::liner::Widths widths() const;
  bool has_ends() const { return ends_.has_value(); }

  /// Return this rank's contribution to the torque on all surfaces that turn with the mill [N m].
  /// The torque is about the mill's origin, at the last evaluation of the forces.
  const millscale::Vector& torque_on_turning() const { return torque_on_turning_; }

  /// Mark the balls in contact at the last evaluation of the forces. Add the bits of `wall` for the
  /// wall and the bits of `groove` for a groove. marks: of local balls.
  void mark_contacts(std::vector<signed char>& marks, signed char wall, signed char groove) const;

 private:
  /// Position and motion of the mill at this step.
  struct MillNow {
    millscale::MillFrame frame;
    millscale::Turn turn;  ///< turn by the mill's angle
    millscale::Vector omega;
  };

  /// One contact of a ball, before its force is known.
  struct Contact {
    double overlap;
    millscale::Vector normal;
    double key;              ///< key of the surface, never 0
    bool turns;              ///< the surface moves with the mill
    bool continued = false;  ///< in contact at the last evaluation
  };
  struct Contacts;

  /// A ball that may touch the wall before the next neighbour list.
  struct Near {
    int ball;
    millscale::liner::LastSearch last;
    millscale::liner::Point seen;  ///< centre at the last check, in the mill at rest
    double along;                  ///< position along the axis at the last check [m]
    double clear;  ///< distance the ball can move without a contact, ends included [m]
  };

  void parse(int narg, char** arg);
  void take_liner();
  void check_box() const;
  double largest_ball() const;
  void check_balls_fit(double largest) const;
  void check_balls_are_inside() const;
  void read_materials();
  MillNow mill_now() const;
  void add_forces(double dt);
  void find_near(const WallInput& input, const MillNow& mill);
  void count_touching();
  void fetch_ahead(const WallInput& input, const Near& near) const;
  void look_at(const WallInput& input, Near& near, const MillNow& mill, double dt);
  void touch_liner(const MillNow& mill, Near& near, double radius, Contacts& found) const;
  void touch_ends(const MillNow& mill, Near& near, double radius, Contacts& found) const;
  void press_all(const WallInput& input, int i, const MillNow& mill, const millscale::Vector& arm,
                 Contacts& found, double dt);
  void press(const WallInput& input, int i, const MillNow& mill, const millscale::Vector& arm,
             const Contact& contact, double dt, millscale::Vector& displacement,
             double damping_share);
  const millscale::contact::ContactLaw<double>& law_of(int i) const;
  double damping_share(const WallInput& input, int i, const Contacts& found, double dt) const;

  std::string mill_id_;
  FixMillSimilarity* mill_fix_ = nullptr;
  FixMillLedger* ledger_ = nullptr;  ///< the energy budget, if there is one
  millscale::LinerArguments liner_arguments_;
  double chord_error_ = 0.0;  ///< of the grooves' polygon [m]; 0: exact arcs
  std::shared_ptr<const millscale::liner::Profile> liner_;  ///< exact arcs, or their chords
  std::unique_ptr<millscale::liner::ContactFinder> finder_;
  std::optional<millscale::liner::EndWalls> ends_;
  bool ends_turn_ = true;
  int wall_type_ = 0;
  millscale::contact::ContactTerms terms_;
  FixContactDamping* damping_ = nullptr;  ///< sums of ball-ball contacts, if limited
  std::vector<millscale::contact::ContactLaw<double>> law_of_type_;
  std::vector<Near> near_;             ///< balls that may touch, or did
  std::vector<WallForce> forces_;      ///< of the last evaluation
  std::vector<signed char> touching_;  ///< contacts of each ball at the last evaluation, as bits
  double on_wall_[6] = {};             ///< force and torque on liner and ends, this rank
  millscale::Vector torque_on_turning_{};
};

}  // namespace LAMMPS_NS
