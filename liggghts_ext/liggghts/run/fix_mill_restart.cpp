#include "liggghts/run/fix_mill_restart.h"

#include <mpi.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>

#include "atom.h"
#include "atom_vec.h"
#include "comm.h"
#include "error.h"
#include "modify.h"
#include "output.h"
#include "timer.h"
#include "update.h"

#include "liggghts/run/restart_signature.h"

using namespace LAMMPS_NS;
using namespace FixConst;

FixMillRestart::FixMillRestart(LAMMPS* lmp, int narg, char** arg) : Fix(lmp, narg, arg)
{
  if (narg != 3) error->fix_error(FLERR, this, "takes no arguments");
  restart_global = 1;  // the engine calls write_restart() before it writes per-ball data
  restart_file = 1;    // and write_restart_file() after it has closed the file
}

int FixMillRestart::setmask()
{
  return PRE_EXCHANGE;
}

/// The engine builds new neighbour lists at the step of a restart file, and sorts at some builds.
void FixMillRestart::pre_exchange()
{
  if (atom->sortfreq > 0 && output->restart_requested(update->ntimestep))
    atom->nextsort = update->ntimestep;
}

/// The engine's contact history holds the tangential displacements of the last list build. At the
/// step of a file the build precedes the forces, so the displacements would be one step old.
void FixMillRestart::write_restart(FILE* file)
{
  for (int i = 0; i < modify->nfix; ++i)
    if (std::strcmp(modify->fix[i]->style, "contacthistory") == 0)
      modify->fix[i]->setup_pre_exchange();
  const int bytes = 0;  // no state of its own
  if (comm->me == 0) fwrite(&bytes, sizeof bytes, 1, file);
}

void FixMillRestart::write_restart_file(char* file)
{
  const int mine = atom->avec->size_restart();
  std::vector<int> chunks(comm->me == 0 ? static_cast<std::size_t>(comm->nprocs) : 0);
  MPI_Gather(&mine, 1, MPI_INT, chunks.data(), 1, MPI_INT, 0, world);
  const Cost so_far = cost();
  const std::string problem = comm->me == 0 ? sign(file, chunks, so_far) : "";
  // All ranks fail together: the engine does not flush its output when one rank aborts.
  int failed = !problem.empty();
  MPI_Bcast(&failed, 1, MPI_INT, 0, world);
  if (!failed) return;
  const std::string message = "restart file '" + std::string(file) + "' " + problem;
  error->all(FLERR, message.c_str());
}

/// Return the time of this run command's loop, and the processor time of all ranks since their
/// start; complete on rank 0 only.
FixMillRestart::Cost FixMillRestart::cost() const
{
  struct rusage used = {};
  getrusage(RUSAGE_SELF, &used);
  const double mine = static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
                      1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
  Cost total;
  MPI_Reduce(&mine, &total.processor_time, 1, MPI_DOUBLE, MPI_SUM, 0, world);
  if (update->whichflag == 1) total.loop_time = MPI_Wtime() - timer->array[TIME_LOOP];
  return total;
}

/// Sign a file. Return the fault, or nothing if the file is complete and on the disk.
std::string FixMillRestart::sign(const std::string& name, const std::vector<int>& chunks,
                                 const Cost& cost) const
{
  std::ostringstream content;
  content << std::ifstream(name, std::ios::binary).rdbuf();
  const std::string bytes = content.str();
  if (!millscale::ends_with_chunks(bytes, chunks))
    return "is not whole: is the disk full? It has " + std::to_string(bytes.size()) + " bytes";
  FILE* file = std::fopen(name.c_str(), "ab");
  if (!file) return "cannot be opened to sign it";
  std::fprintf(file,
               "\nmillscale restart step " BIGINT_FORMAT
               " bytes %zu crc32 %08x loop_time_s %.6f processor_time_s %.6f\n",
               update->ntimestep, bytes.size(), static_cast<unsigned>(millscale::crc32(bytes)),
               cost.loop_time, cost.processor_time);
  const bool on_disk = std::fflush(file) == 0 && fsync(fileno(file)) == 0;
  if (std::fclose(file) != 0 || !on_disk) return "cannot be signed: is the disk full?";
  return {};
}
