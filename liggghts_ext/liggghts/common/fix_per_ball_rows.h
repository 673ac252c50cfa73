#pragma once

#include "fix.h"

namespace LAMMPS_NS {

/// A fix with a row of numbers for each ball. Rows follow the ball across ranks and through
/// restarts. Rows of new balls are zero unless set_arrays sets them.
class FixPerBallRows : public Fix {
 public:
  FixPerBallRows(class LAMMPS*, int narg, char** arg, int width);
  ~FixPerBallRows() override;

  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double*) override;
  int unpack_exchange(int, double*) override;
  int pack_restart(int, double*) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override { return width_ + 1; }
  int maxsize_restart() override { return width_ + 1; }
  double memory_usage() override;

 protected:
  double* row(int i) const { return rows_[i]; }

 private:
  int width_;
  double** rows_ = nullptr;  ///< (n, width)
};

}  // namespace LAMMPS_NS
