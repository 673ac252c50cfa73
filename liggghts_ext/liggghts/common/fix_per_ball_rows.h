#pragma once

#include <cstddef>
#include <vector>

#include "fix.h"

namespace LAMMPS_NS {

/// A fix with a row of numbers for each ball. Rows follow the ball across ranks and through
/// restarts. Rows of new balls are zero unless set_arrays sets them. A row may have a second part,
/// of numbers that are seldom needed, which is stored elsewhere.
class FixPerBallRows : public Fix {
 public:
  /// Make rows of `width` numbers and a second part of `rest` numbers.
  FixPerBallRows(class LAMMPS*, int narg, char** arg, int width, int rest = 0);
  ~FixPerBallRows() override;

  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double*) override;
  int unpack_exchange(int, double*) override;
  int pack_restart(int, double*) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override { return width_ + rest_width_ + 1; }
  int maxsize_restart() override { return width_ + rest_width_ + 1; }
  double memory_usage() override;

 protected:
  double* row(int i) const { return first_ + static_cast<std::ptrdiff_t>(i) * width_; }
  double* rest(int i) const { return first_rest_ + static_cast<std::ptrdiff_t>(i) * rest_width_; }

 private:
  /// A cache line, on which a row of 2^k <= 8 numbers lies alone or with whole others.
  struct alignas(64) Line {
    double numbers[8];
  };

  int width_, rest_width_;
  std::vector<Line> lines_;    ///< the rows, one after the other
  std::vector<double> rests_;  ///< (n, rest)
  double* first_ = nullptr;    ///< of lines_
  double* first_rest_ = nullptr;
};

}  // namespace LAMMPS_NS
