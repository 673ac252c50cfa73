#pragma once

#include "fix.h"

#include "core/neighbor/adaptive_skin.h"

namespace LAMMPS_NS {

class FixMillSimilarity;

/// Margins of the balls for the neighbour list of `pair_style gran ... surface fast`, which makes
/// this fix; asks for a new list when a ball has left its own.
class FixPairMargins : public Fix {
 public:
  static constexpr const char* style_name = "mill/pair_margins";

  FixPairMargins(class LAMMPS*, int, char**);

  int setmask() override;
  void init() override;
  void post_integrate() override;
  int pack_comm(int, int*, double*, int, int*) override;
  void unpack_comm(int, int, double*) override;

  /// Of the balls and ghosts at a list's birth [m]; sorts them into the grid. `by_places`: the list
  /// must depend on nothing but where the balls are.
  const double* at_birth(const millscale::pairs::Balls&, millscale::pairs::CellGrid&,
                         bool by_places);

 private:
  const FixMillSimilarity* mill_ = nullptr;
  millscale::pairs::Margins margins_;
  bigint birth_ = 0;
};

}  // namespace LAMMPS_NS
