#pragma once

#include "fix.h"

#include "core/neighbor/adaptive_skin.h"

namespace LAMMPS_NS {

class FixMillSimilarity;

/// Per-particle Verlet skin of the pair list of `pair_style gran ... surface fast`, which creates
/// this fix. Requests a new list when a particle has moved by more than its skin.
class FixAdaptiveSkin : public Fix {
 public:
  static constexpr const char* style_name = "mill/pair_margins";

  FixAdaptiveSkin(class LAMMPS*, int, char**);

  int setmask() override;
  void init() override;
  void post_integrate() override;
  int pack_comm(int, int*, double*, int, int*) override;
  void unpack_comm(int, int, double*) override;

  /// State, before `init`, that the pair style is in use. The skins then last as long as the list,
  /// which a run without set-up goes on with.
  void use() { in_use_ = true; }

  /// Return the skin of each particle, local and ghost, for a new list [m]. by_position_only: the
  /// list may depend on positions only.
  const double* at_build(const millscale::neighbor::Particles&, bool by_position_only);

  const millscale::neighbor::AdaptiveSkin& skin() const { return skin_; }
  /// Return the time since the list was built at a step [s].
  double time_since_build(bigint step) const;

 private:
  const FixMillSimilarity* mill_fix_ = nullptr;
  millscale::neighbor::AdaptiveSkin skin_;
  bigint build_step_ = 0;
  bool in_use_ = false;
};

}  // namespace LAMMPS_NS
