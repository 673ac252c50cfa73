// liggghts_mill: the LIGGGHTS executable with the millscale styles. All stock options work.
#include <mpi.h>

#include <csignal>
#include <cstring>
#include <iostream>
#include <memory>

#include "input.h"
#include "lammps.h"
#include "signal_handling.h"
#include "universe.h"

#include "liggghts/driver/register_styles.h"

namespace {

bool asks_for_help(int argc, char** argv)
{
  for (int i = 1; i < argc; ++i)
    if (!std::strcmp(argv[i], "-h") || !std::strcmp(argv[i], "-help")) return true;
  return false;
}

/// Handle signals like the stock executable: an interrupt ends the run after the current step, USR1
/// writes a restart file.
void handle_signals()
{
  struct sigaction quit = {};
  quit.sa_handler = LAMMPS_NS::SignalHandler::int_handler;
  sigaction(SIGINT, &quit, nullptr);
  sigaction(SIGTERM, &quit, nullptr);  // mpirun turns an interrupt into SIGTERM for its children
  struct sigaction write_restart = {};
  write_restart.sa_handler = LAMMPS_NS::SignalHandler::usr1_handler;
  sigaction(SIGUSR1, &write_restart, nullptr);
}

/// Suppress the engine's remarks. After one error in five the engine prints a remark from a string
/// it has freed, if its version names the public one. Restart files contain the version's text, so
/// only its case changes.
void suppress_remarks(LAMMPS_NS::LAMMPS& engine)
{
  if (char* name = std::strstr(engine.universe->version, "PUBLIC")) std::memcpy(name, "Public", 6);
}

}  // namespace

int main(int argc, char** argv)
{
  handle_signals();
  MPI_Init(&argc, &argv);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  // The engine prints its own help and exits inside its constructor.
  if (rank == 0 && asks_for_help(argc, argv)) millscale::list_styles(std::cout);
  std::cout.flush();
  {
    auto engine = std::make_unique<LAMMPS_NS::LAMMPS>(argc, argv, MPI_COMM_WORLD);
    suppress_remarks(*engine);
    millscale::register_styles(*engine);
    engine->input->file();
  }
  MPI_Finalize();
  return 0;
}
