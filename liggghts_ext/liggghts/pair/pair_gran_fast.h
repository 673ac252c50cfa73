#pragma once

#include <optional>
#include <string>
#include <vector>

#include "granular_pair_style.h"
#include "pointers.h"

#include "core/kernels/kernel.h"
#include "core/neighbor/pair_list.h"

namespace LAMMPS_NS {

class FixAdaptiveSkin;
class FixContactDamping;
class ReadsOverlap;

/// `pair_style gran model hertz [tangential history] [rolling_friction cdt] surface fast`: the
/// engine's contacts with own neighbour list and kernel.
/// Options and limits: docs/reference/styles/pair-gran-surface-fast.md.
class PairGranFast : public LIGGGHTS::PairStyles::IGranularPairStyle, protected Pointers {
 public:
  /// Register the model with the engine, before a deck is read.
  static void add_to_engine();

  PairGranFast(class LAMMPS*, class PairGran*, int64_t hash);

  void settings(int, char**, LIGGGHTS::IContactHistorySetup*) override;
  void init_granular() override;
  void compute_force(class PairGran*, int eflag, int vflag, int addflag) override;
  void write_restart_settings(FILE*) override;
  void read_restart_settings(FILE*, int64_t hash) override;

  int get_history_offset(const std::string) override;
  double stressStrainExponent() override { return 1.5; }
  int64_t hashcode() override { return hash_; }
  bool contact_match(const std::string type, const std::string model) override;

  /// Return the largest overlap of two balls of this rank and their ghosts at the present step [m],
  /// if a style has said that it will read it.
  std::optional<double> largest_overlap() const;

  // What the time loop needs, which keeps the balls in rows between two neighbour lists.

  /// Return why the rows cannot be kept; empty if they can.
  std::string needs_engine_loop() const;
  /// Return whether this style checks its list at the present step, from the engine's arrays.
  bool checks_list_now() const;
  bool mixed() const { return mixed_; }
  bool limited_damping() const { return terms_.limited_damping; }
  const millscale::kernels::Implementation& kernel() const { return *kernel_; }
  FixContactDamping* damping() const { return damping_; }
  FixAdaptiveSkin& skin() const { return *skin_; }
  /// Build the neighbour list of the engine's balls and ghosts.
  void build_list();
  /// Add the forces between the balls of the rows to the force rows.
  void evaluate_rows();

 private:
  void require_covered();
  void refuse_friction_of_balls();
  template <class Style>
  Style* own_fix(const char* id);
  bool by_position_only() const;
  millscale::kernels::Task task(const millscale::kernels::Rows& rows);
  void find_overlap_readers();
  double* begin_overlap();
  void check_list();
  millscale::neighbor::Particles particles() const;

  class PairGran* pair_;
  int64_t hash_;
  std::string tangential_;
  millscale::contact::ContactTerms terms_;
  class FixContactDamping* damping_ = nullptr;
  class FixAdaptiveSkin* skin_ = nullptr;
  class FixPairContactHistory* history_ = nullptr;
  class FixMillLedger* ledger_ = nullptr;    ///< the energy budget, if there is one
  class FixMillImpacts* impacts_ = nullptr;  ///< the spectra of impacts, if there are any
  bool reset_on_separation_ = true;
  bool mixed_ = false;
  int check_every_ = 0;  ///< steps between searches for missed contacts; 0: never
  const millscale::kernels::Implementation* kernel_;
  std::vector<millscale::contact::ContactLaw<double>> laws_;
  class FixBallRows* rows_ = nullptr;
  millscale::neighbor::CellGrid grid_;
  int only_type_ = 0;
  std::vector<ReadsOverlap*> overlap_readers_;
  std::optional<double> overlap_;  ///< largest, at step `overlap_step_` [m]
  long long overlap_step_ = 0;
};

}  // namespace LAMMPS_NS
