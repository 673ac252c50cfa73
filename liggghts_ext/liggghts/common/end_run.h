#pragma once

#include <mpi.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "comm.h"
#include "error.h"
#include "pointers.h"

namespace millscale {

/// Ends the run from this rank alone, with the reason on screen and in the log. The other ranks may
/// be anywhere in their step.
class EndRun : LAMMPS_NS::Pointers {
 public:
  explicit EndRun(LAMMPS_NS::LAMMPS* engine) : Pointers(engine) {}

  [[noreturn]] void because(const std::string& reason)
  {
    if (comm->nprocs == 1) error->all(FLERR, reason.c_str());
    for (FILE* file : {screen, logfile})
      if (file) std::fprintf(file, "ERROR on proc %d: %s\n", comm->me, reason.c_str());
    std::fflush(nullptr);  // MPI_Abort does not flush
    MPI_Abort(world, 1);
    std::abort();
  }
};

}  // namespace millscale
