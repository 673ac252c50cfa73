#pragma once

#include <string>
#include <vector>

#include "verlet.h"

#include "core/kernels/advance.h"

namespace LAMMPS_NS {

class EndsSteps;
class Fix;
class FixBallRows;
class FixMillDetachTrack;
class FixMillGuard;
class FixMillSimilarity;
class FixWallMill;
class PairGranFast;

/// The time loop of liggghts_mill, in the place of the engine's. Between two neighbour lists it
/// keeps the balls in the rows of the contact kernels. One pass over the rows ends a step and
/// begins the next one. For output and for fixes that read the balls, it copies the end of the step
/// to the engine's arrays. Restart files, and fixes that may change the balls, need a step of the
/// engine. The results have the same bits as those of the engine's loop, which runs where a deck
/// needs it; `run_style verlet` asks for it. What needs it, and why:
/// docs/reference/styles/time-loop.md.
class MillLoop : public Verlet {
 public:
  explicit MillLoop(class LAMMPS*);

  static void replace_engine_loop(class LAMMPS&);

  void init() override;
  void setup() override;
  void setup_minimal(int) override;
  void run(int) override;

 private:
  void choose_loop();
  std::string find_participants();
  std::string engine_settings() const;
  std::string place_in_step(Fix*, int mask);
  std::string time_integration() const;
  bool needs_engine_step() const;
  bool needs_arrays() const;
  int agree(int bits) const;
  bool rebuild_due();
  void send_or_rebuild(bool rebuild);
  void step_of_engine();
  void step_on_rows();
  void end_step();
  void write_output();
  void read_arrays();
  void write_arrays(int begin, int end);
  void read_list();
  const std::vector<millscale::kernels::WallForce>& evaluate_walls();
  void advance(const std::vector<millscale::kernels::WallForce>& wall_forces, bool copy);
  void copy_ghosts();

  /// A fix that acts at the end of steps.
  struct AtEnd {
    Fix* fix;
    EndsSteps* known;  ///< the same; null if it reads the engine's arrays whenever it acts
    bool only_reads;   ///< changes no ball
  };

  std::string reason_;  ///< why the engine's loop must run; empty: ours runs
  FixBallRows* rows_ = nullptr;
  PairGranFast* pair_ = nullptr;
  FixMillSimilarity* mill_ = nullptr;
  FixMillDetachTrack* track_ = nullptr;
  Fix* integration_ = nullptr;
  std::vector<FixWallMill*> walls_;
  bool gravity_first_ = false;
  std::vector<AtEnd> at_end_;  ///< in the order of the engine
  std::vector<FixMillGuard*> guards_;

  bool on_rows_ = false;      ///< the rows are up to date, and begin the present step
  int signals_ = 0;           ///< received by any rank, as bits
  bool restart_due_ = false;  ///< at the present step
  millscale::kernels::Advanced found_;
  std::vector<millscale::kernels::WallForce> wall_forces_;  ///< of several walls
  std::vector<millscale::kernels::ListStart> start_;
  std::vector<millscale::kernels::Kick> kick_;
};

}  // namespace LAMMPS_NS
