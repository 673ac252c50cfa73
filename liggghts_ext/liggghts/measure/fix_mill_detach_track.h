#pragma once

#include <string>
#include <vector>

#include "core/kernels/advance.h"
#include "core/measure/detachment.h"
#include "liggghts/common/ends_steps.h"
#include "liggghts/common/fix_per_ball_rows.h"

namespace LAMMPS_NS {

class FixMillSimilarity;
class FixWallMill;

/// Per-ball detachment records, updated at the end of every step and kept across ranks and
/// restarts. compute mill/detach creates this fix and publishes the records. Arguments:
/// docs/reference/styles/compute-mill-detach.md.
class FixMillDetachTrack : public FixPerBallRows, public EndsSteps {
 public:
  /// Statistics of confirmed events since the records began, on this rank.
  struct Statistics {
    millscale::detachment::AngleStatistics liner_off, flight, outermost;
  };

  FixMillDetachTrack(class LAMMPS*, int, char**);

  int setmask() override;
  void init() override;
  void end_of_step() override;
  bool needs_arrays() const override { return false; }
  void end_step(const millscale::kernels::Advanced&) override;

  /// Return whether contacts with the liner are known from analytic walls alone.
  bool reads_analytic_walls_only() const;
  /// Mark the contacts with the walls. Return what the pass over the balls must look for.
  const millscale::kernels::ContactWatch& begin_pass();

  const millscale::detachment::Record& record(int i) const;
  /// Return the state in the record of a ball. Reads the record only if its contacts are not known.
  millscale::detachment::State state(int i) const;
  Statistics statistics_of_all_ranks() const;
  double mill_time() const;

  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int unpack_exchange(int, double*) override;
  void unpack_restart(int, int) override;
  void write_restart(FILE*) override;
  void restart(char*) override;

 private:
  void parse(int narg, char** arg);
  void take_liner();
  struct Now;
  Now now() const;
  void observe_all();
  void observe(const millscale::kernels::Moment& ball, const Now& step);
  bool of_group(int i) const;
  void forget(int i);
  void mark_walls(std::vector<signed char>& marks) const;
  void count(const millscale::detachment::Confirmed&, const millscale::detachment::Record&);
  bool looks_at_carriers() const;
  void mark_contacts();
  double least_acceleration2() const;
  signed char mesh_contacts(int i) const;
  bool may_change(const millscale::kernels::Moment& ball, const Now& step) const;
  void prefetch(int i) const;

  std::string mill_id_;
  FixMillSimilarity* mill_fix_ = nullptr;
  std::vector<FixWallMill*> analytic_walls_;
  millscale::detachment::Mill mill_;
  bool liner_given_ = false;  ///< the arguments give the liner
  int lifters_ = 0;
  double lifter_top_radius_ = 0.0, phase_ = 0.0;
  double inner_radius_ = 0.0;      ///< of the liner; 0: a plain drum [m]
  double gap_ = 1.0;               ///< in ball radii
  double force_tolerance_ = 1e-9;  ///< in ball weights
  Statistics statistics_;
  /// For each ball: its contacts at the last step and its pending events; -1: its record must be
  /// read.
  std::vector<signed char> seen_;
  // Parts of the record, if it is known: records lie far apart in memory.
  std::vector<float> carrier_;
  std::vector<millscale::Vector> flight_place_;
  std::vector<signed char> marks_;       ///< contacts of each ball at this step, as bits
  std::vector<signed char> wall_marks_;  ///< those with walls, for the pass over the balls
  std::vector<signed char> never_seen_;  ///< marks that no ball has, to observe all balls
  std::vector<millscale::kernels::Moment> moments_;
  millscale::kernels::ContactWatch watch_{};
};

}  // namespace LAMMPS_NS
