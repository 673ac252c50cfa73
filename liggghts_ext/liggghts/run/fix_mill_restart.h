#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include "fix.h"

namespace LAMMPS_NS {

/// Makes restart files exact and known to be whole. Exact: the tangential memories in them are
/// those of the step, and the balls are sorted at these steps, as in a run that goes on from the
/// file, so that both add up forces in the same order. Known to be whole: looks whether a file is
/// all there, signs it with its last line and hands it to the disk.
/// The last line: docs/reference/files.md, restart files.
class FixMillRestart : public Fix {
 public:
  FixMillRestart(class LAMMPS*, int, char**);

  int setmask() override;
  void pre_exchange() override;
  void write_restart(FILE*) override;
  void restart(char*) override {}
  void write_restart_file(char*) override;

 private:
  struct Cost {
    double loop_time = 0.0, processor_time = 0.0;  ///< [s]
  };

  Cost cost() const;
  std::string sign(const std::string& file, const std::vector<int>& chunks, const Cost&) const;
};

}  // namespace LAMMPS_NS
