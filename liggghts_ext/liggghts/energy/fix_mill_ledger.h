#pragma once

#include <array>
#include <string>
#include <vector>

#include "fix.h"

#include "core/energy/contact_sums.h"
#include "core/energy/energy_budget.h"

namespace LAMMPS_NS {

class FixMillSimilarity;

/// Energy budget of the charge: work of the mill, energies of the balls, energy stored and
/// dissipated by contacts, and the spectrum of impacts. `pair_style gran ... surface fast` and fix
/// wall/mill add their contacts if this fix exists. Arguments and f_ID[k]:
/// docs/reference/styles/fix-mill-ledger.md. Method: docs/theory/energy-budget.md.
class FixMillLedger : public Fix {
 public:
  FixMillLedger(class LAMMPS*, int, char**);

  int setmask() override;
  void init() override;
  void setup_pre_force(int) override;
  void setup(int) override;
  void pre_force(int) override;
  void end_of_step() override;
  void post_run() override;
  double compute_vector(int) override;
  void write_restart(FILE*) override;
  void restart(char*) override;

  millscale::energy::PairSums& between_balls() { return between_balls_; }
  millscale::energy::ContactSums& on_wall() { return on_wall_; }

 private:
  /// Energies of balls and contacts at one step [J].
  struct Energies {
    double translation = 0.0, rotation = 0.0, potential = 0.0;
    std::array<millscale::energy::Stored, millscale::energy::pairings> stored{};
  };
  /// The mill angles between which impacts go to the spectrum [rad].
  struct Window {
    double from = 0.0, to = -1.0, first = 0.0, last = 0.0;
    double written = 0.0;  ///< 1: complete and written
  };
  /// Contents of a restart file, summed over the ranks.
  struct State;

  void parse(int narg, char** arg);
  millscale::energy::Works powers(double shift) const;
  Energies energies() const;
  Energies energies_of_all_ranks() const;
  State state_of_all_ranks() const;
  void compute_terms();
  void write_impacts();
  bool put_impacts(const std::string& name, const State& all) const;

  static constexpr int numbers = 25;
  std::string mill_id_, file_;
  FixMillSimilarity* mill_fix_ = nullptr;
  millscale::energy::PairSums between_balls_;
  millscale::energy::ContactSums on_wall_;
  millscale::energy::WorkSums work_;
  Energies begin_;               ///< of all ranks, at the begin of the budget
  double begun_ = 0.0;           ///< 1: the budget has begun
  bool forces_carried_ = false;  ///< after a restart: the waiting half step is that of the file
  Window window_;
  bigint terms_step_ = -1;  ///< step of `terms_`
  std::array<double, numbers> terms_{};
};

}  // namespace LAMMPS_NS
