#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fix.h"

#include "core/liner/lifters.h"
#include "core/math/mill_frame.h"
#include "core/math/vector.h"
#include "core/similarity/law.h"
#include "core/similarity/rotation.h"
#include "liggghts/mill/mesh_walls.h"

namespace LAMMPS_NS {

/// Derives the scaled mill's gravity and speed from the physical mill. Applies that gravity, turns
/// the given wall meshes and hands the liner of the scaled mill to the styles that need it.
/// Arguments and f_ID[k]: docs/reference/styles/fix-mill-similarity.md.
class FixMillSimilarity : public Fix {
 public:
  FixMillSimilarity(class LAMMPS*, int, char**);

  int setmask() override;
  void post_create() override;
  void pre_delete(bool unfixflag) override;
  void init() override;
  void setup_pre_force(int) override;
  void setup(int) override;
  void initial_integrate(int) override;
  void post_force(int) override;
  double compute_scalar() override;
  double compute_vector(int) override;
  void write_restart(FILE*) override;
  void restart(char*) override;

  const millscale::similarity::ScaledMill& scaled() const { return scaled_; }
  /// Cross-section of the scaled mill's liner; a plain drum if the deck states none.
  const std::shared_ptr<const millscale::liner::Profile>& liner() const { return liner_; }
  /// Whether the deck states the liner here, and not (as older decks) in each style.
  bool states_liner() const { return states_liner_; }
  /// Widths of the scaled mill's lifters; none of a liner by a profile file.
  const std::optional<millscale::liner::Widths>& widths() const { return widths_; }
  double mill_angle() const;
  double mill_time() const;
  double speed_now() const;
  /// Mill angle at the step before [rad].
  double angle_before_step() const;
  /// Largest speed of the scaled mill [rad/s].
  double largest_speed() const { return scaled_.mill.omega * schedule_.fastest(); }
  double gravity() const { return scaled_.mill.gravity; }
  millscale::MillFrame frame() const { return {axis_, down_, origin_}; }
  const millscale::Vector& axis() const { return axis_; }
  const millscale::Vector& down() const { return down_; }
  const millscale::Vector& origin() const { return origin_; }
  const MeshWalls& meshes() const { return meshes_; }

 private:
  struct Arguments;
  void parse(int narg, char** arg);
  void read_start(const std::string& when);
  void make_liner(const Arguments&);
  void normalise_directions();
  void continue_rotation(const millscale::similarity::Rotation& before, bool same_changes);
  double next_mark() const;
  void set_wall_velocity();
  void warn(const std::string& message) const;
  [[noreturn]] void fail(const std::string& message);

  millscale::similarity::ScaledMill scaled_{};
  millscale::similarity::Rotation rotation_;
  std::vector<millscale::similarity::SpeedChange> changes_;
  millscale::similarity::SpeedSchedule schedule_;  ///< from mill angle 0 on
  double mark_ = 0.0;                              ///< mill angle between the marks [rad]; 0: none
  bool starts_at_creation_ = true;

  std::shared_ptr<const millscale::liner::Profile> liner_;
  std::optional<millscale::liner::Widths> widths_;
  bool states_liner_ = false;

  millscale::Vector axis_{0, 1, 0}, down_{0, 0, -1}, origin_{0, 0, 0};
  MeshWalls meshes_;
  double nodes_angle_ = 0.0;   ///< angle the mesh nodes stand at [rad]
  double stored_angle_ = 0.0;  ///< angle of the node positions the engine rotates from [rad]
  bigint last_step_ = 0;
};

}  // namespace LAMMPS_NS
