#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include "fix.h"

namespace LAMMPS_NS {

/// Makes restart files exact and verifiable. Exact: tangential displacements are those of the step.
/// Balls are sorted at these steps as after a restart, so that both runs add up forces in the same
/// order. Verifiable: checks that a file is complete, appends a signature line and flushes the file
/// to the disk. The last line: docs/reference/files.md, restart files.
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
