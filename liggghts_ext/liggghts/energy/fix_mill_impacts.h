#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/energy/contact_work.h"
#include "core/energy/energy_budget.h"
#include "core/energy/impact_sums.h"
#include "core/kernels/kernel.h"
#include "core/kernels/wall.h"
#include "core/liner/contacts.h"
#include "core/neighbor/pair_list.h"
#include "liggghts/common/ends_steps.h"
#include "liggghts/common/fix_per_ball_rows.h"

namespace LAMMPS_NS {

class FixMillSimilarity;

/// Spectra of the energy that contacts dissipate, and of the energy of their approach, to a file.
/// `pair_style gran ... surface fast` and fix wall/mill record each contact if this fix exists.
/// Arguments and f_ID[k]: docs/reference/styles. Definition: docs/theory/impacts.md.
class FixMillImpacts : public FixPerBallRows, public EndsSteps {
 public:
  /// Contacts of a ball with liner and ends that are remembered.
  static constexpr int wall_slots = millscale::liner::Contacts::most + 2;
  /// No slot.
  static constexpr int begins = -1;

  FixMillImpacts(class LAMMPS*, int, char**);

  int setmask() override;
  void init() override;
  void setup(int) override;
  void end_of_step() override;
  bool needs_arrays() const override;
  void end_step(const millscale::kernels::Advanced&) override { end_of_step(); }
  void post_run() override;
  double compute_vector(int) override;
  void write_restart(FILE*) override;
  void restart(char*) override;

  double memory_usage() override;
  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double*) override;
  int unpack_exchange(int, double*) override;
  int pack_restart(int, double*) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override;
  int maxsize_restart() override;

  /// Return where the kernel records the contacts of the list at this step. laws: of the contacts,
  /// beyond the step. moves: false at set-up.
  millscale::energy::WorkRecord* begin_balls(millscale::neighbor::PairList&,
                                             const millscale::kernels::Laws& laws, bool moves);
  /// Add what the kernel recorded to the sums.
  void end_balls();

  /// Contacts of a ball with the wall, begin to end of a batch.
  struct OnWall {
    const millscale::kernels::WallBatch& batch;
    int begin, end;
    const int* slot_before;  ///< of each contact of the batch, or `begins`
    int slots_before;        ///< that the ball may have had
    const double *velocity, *spin;
    double dt;  ///< 0 at set-up
  };
  /// Record the contacts of ball i. They get slots in ascending order, without those that do not
  /// overlap.
  void record_wall(int i, const OnWall&);
  /// Prefetch what the contacts of ball i with the wall keep.
  void prefetch_wall(int i) const
  {
    __builtin_prefetch(row(i), 1);
    __builtin_prefetch(row(i) + 8, 1);
  }

  // The contacts of balls that leave their rank, in the order of the engine's histories.

  static constexpr int exchanged_numbers = millscale::energy::CarriedWork::numbers;
  void forget_kept();
  void keep(int i, const millscale::energy::CarriedWork&);
  /// Return contact k of ball i; none if it is not known.
  millscale::energy::CarriedWork kept(int i, int k) const;

 private:
  using Pairings = std::array<double, millscale::energy::pairings>;

  /// Contacts that last [-], and what they have dissipated so far [J].
  struct Open {
    Pairings contacts{}, dissipated{}, stored{};
  };
  /// The window of the file; the same on all ranks.
  struct Window {
    double begun = 0.0;                ///< 1: the measurement has begun
    double open = 0.0, written = 0.0;  ///< 1: yes
    double first_angle = 0.0, last_angle = 0.0, first_time = 0.0, last_time = 0.0;
  };
  /// Sums of a rank.
  struct Sums {
    std::array<millscale::energy::ImpactTotals, millscale::energy::pairings> totals{};
    Pairings end_terms{};      ///< of runs that ended, see `half_kick` [J]
    Open at_begin;             ///< of the window
    Pairings work_at_begin{};  ///< of the window [J]
  };

  void parse(int narg, char** arg);
  millscale::energy::WallContactWork* wall_slot(int i, int slot) const;
  void end_contact(millscale::energy::Pairing, int impact_class, double dissipated,
                   double available, double share);
  double share_of(int entry) const;
  double stored(int entry) const;
  template <class Visit>
  void for_each_open(const Visit&) const;
  Open open_contacts() const;
  Pairings half_kick() const;
  void begin();
  void open_window();
  void write();
  bool put_file(const std::string& name, const Sums&, const Open&,
                const std::vector<millscale::energy::ImpactSpectra>&) const;
  std::vector<double> numbers_of_rank() const;
  void add_numbers(const double* from);
  template <class Numbers>
  void sum_over_ranks(Numbers&, int count) const;
  void compute_published();

  static constexpr int published = 10;
  std::string mill_id_, file_;
  double from_ = 0.0, to_ = -1.0;  ///< mill angles of the window [rad]
  FixMillSimilarity* mill_fix_ = nullptr;
  millscale::energy::ImpactClasses classes_;
  std::vector<millscale::energy::ImpactSpectra> spectra_;  ///< of the classes, in the window
  Sums sums_;
  Window window_;
  bool forces_carried_ = false;  ///< after a restart: the loads at set-up are those of the file
  Pairings last_kick_{};         ///< of the end of the last run

  millscale::neighbor::PairList* list_ = nullptr;  ///< of the pair style
  millscale::kernels::Laws laws_{};                ///< of the same
  millscale::energy::WorkRecord record_{};
  std::vector<millscale::energy::EndedContact> ended_;
  std::vector<std::vector<millscale::energy::CarriedWork>> kept_;
  bool any_kept_ = false;

  bigint published_step_ = -1;
  std::array<double, published> published_{};
};

}  // namespace LAMMPS_NS
