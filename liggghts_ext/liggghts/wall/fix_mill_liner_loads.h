#pragma once

#include <memory>
#include <string>
#include <vector>

#include "fix.h"

#include "core/liner/arc_bins.h"
#include "core/measure/liner_loads.h"

namespace LAMMPS_NS {

class FixMillSimilarity;
class FixWallMill;

/// Loads of the balls on the liner of a fix wall/mill, by arc length of a pitch, by place in space
/// and by lifter, between two mill angles, to two files. The wall adds its contacts.
/// Arguments and f_ID[k]: docs/reference/styles/fix-mill-liner-loads.md.
/// Files: docs/reference/files.md, liner_loads.csv, lifter_loads.csv.
class FixMillLinerLoads : public Fix {
 public:
  FixMillLinerLoads(class LAMMPS*, int, char**);

  int setmask() override;
  void init() override;
  void post_run() override;
  double compute_vector(int) override;
  void write_restart(FILE*) override;
  void restart(char*) override;

  const std::string& wall_id() const { return wall_id_; }

  /// Begin a step of dt [s]. Return whether the contacts of this step count. All ranks must call
  /// this at every step.
  bool begin_step(double dt);

  /// Add a contact. patch: of the wall; centre: of the ball, in the frame of the mill at rest.
  void add(int type, int patch, millscale::liner::Point centre,
           const millscale::charge::LinerLoads& loads);

 private:
  /// What is gathered besides the sums, alike on all ranks.
  struct Window {
    double steps = 0.0, first_angle = 0.0, last_angle = 0.0;
    double written = 0.0;  ///< 1: complete, and in the files
  };
  /// Head of the state in a restart file. Times and sums follow.
  struct State;

  void parse(int narg, char** arg);
  void find_wall_and_mill();
  int ball_classes() const;
  void make_sums();
  void gather();
  void write();
  bool put_map(const std::string& name) const;
  bool put_lifters(const std::string& name) const;

  std::string mill_id_, wall_id_;
  std::string map_file_ = "liner_loads.csv", lifters_file_ = "lifter_loads.csv";
  double from_ = 0.0, to_ = -1.0;  ///< mill angles of the window [rad]
  int bins_ = 100;                 ///< wanted in a pitch
  FixMillSimilarity* mill_fix_ = nullptr;
  FixWallMill* wall_ = nullptr;
  Window window_;
  std::unique_ptr<millscale::liner::ArcBins> arc_;
  std::unique_ptr<millscale::charge::LinerLoadSums> sums_;
  std::vector<double> state_;  ///< of a restart file, until the sums are made
};

}  // namespace LAMMPS_NS
