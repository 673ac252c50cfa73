#include "liggghts/common/fix_per_ball_rows.h"

#include <algorithm>
#include <cstdio>
#include <string>

#include "atom.h"
#include "error.h"
#include "memory.h"

using namespace LAMMPS_NS;

FixPerBallRows::FixPerBallRows(LAMMPS* lmp, int narg, char** arg, int width)
    : Fix(lmp, narg, arg), width_(width)
{
  restart_peratom = 1;
  create_attribute = 1;
  FixPerBallRows::grow_arrays(atom->nmax);
  atom->add_callback(0);
  atom->add_callback(1);
  for (int i = 0; i < atom->nlocal; ++i) FixPerBallRows::set_arrays(i);
}

FixPerBallRows::~FixPerBallRows()
{
  atom->delete_callback(id, 0);
  atom->delete_callback(id, 1);
  memory->destroy(rows_);
}

void FixPerBallRows::grow_arrays(int nmax)
{
  memory->grow(rows_, nmax, width_, "per_ball_rows");
}

void FixPerBallRows::copy_arrays(int i, int j, int)
{
  std::copy(rows_[i], rows_[i] + width_, rows_[j]);
}

void FixPerBallRows::set_arrays(int i)
{
  std::fill(rows_[i], rows_[i] + width_, 0.0);
}

int FixPerBallRows::pack_exchange(int i, double* buffer)
{
  std::copy(rows_[i], rows_[i] + width_, buffer);
  return width_;
}

int FixPerBallRows::unpack_exchange(int i, double* buffer)
{
  std::copy(buffer, buffer + width_, rows_[i]);
  return width_;
}

int FixPerBallRows::pack_restart(int i, double* buffer)
{
  buffer[0] = width_ + 1;
  std::copy(rows_[i], rows_[i] + width_, buffer + 1);
  return width_ + 1;
}

void FixPerBallRows::unpack_restart(int i, int nth)
{
  const double* extra = atom->extra[i];
  for (int skipped = 0; skipped < nth; ++skipped) extra += static_cast<int>(*extra);
  if (static_cast<int>(*extra) != width_ + 1) {
    const std::string message = "fix " + std::string(style) + ": the restart file holds " +
                                std::to_string(static_cast<int>(*extra) - 1) +
                                " numbers per ball, this version reads " + std::to_string(width_) +
                                "; run from the start, or use the version that wrote the file";
    // The engine aborts before its own line reaches a redirected output.
    std::fprintf(stderr, "ERROR: %s\n", message.c_str());
    error->one(FLERR, message.c_str());
  }
  std::copy(extra + 1, extra + 1 + width_, rows_[i]);
}

double FixPerBallRows::memory_usage()
{
  return static_cast<double>(atom->nmax) * width_ * sizeof(double);
}
