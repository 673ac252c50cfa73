#pragma once

#include <mpi.h>

#include <cstring>
#include <stdexcept>
#include <string>

#include "comm.h"
#include "error.h"
#include "lammps.h"

#include "core/mesh/stl_check.h"

namespace LAMMPS_NS {

/// Checks the STL file of a `fix ID group mesh/surface... file NAME ...` before the engine reads
/// it; rank 0 looks, and all end with its words.
inline void check_mesh_file(LAMMPS* engine, int narg, char** arg)
{
  if (narg < 5 || std::strcmp(arg[3], "file") != 0) return;
  const std::string name = arg[4];
  const std::string end = name.size() < 3 ? "" : name.substr(name.size() - 3);
  if (end != "stl" && end != "STL") return;  // as the engine decides
  std::string problem;
  if (engine->comm->me == 0) try {
      millscale::mesh::check_stl_file(name);
    } catch (const std::invalid_argument& found) {
      problem = found.what();
    }
  int failed = !problem.empty();
  MPI_Bcast(&failed, 1, MPI_INT, 0, engine->world);
  if (!failed) return;
  problem = std::string("Fix ") + arg[2] + " (id " + arg[0] + "): " + problem;
  engine->error->all(FLERR, problem.c_str());
}

}  // namespace LAMMPS_NS
