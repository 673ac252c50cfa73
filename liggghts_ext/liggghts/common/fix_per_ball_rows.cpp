#include "liggghts/common/fix_per_ball_rows.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <string>

#include "atom.h"
#include "error.h"

using namespace LAMMPS_NS;

FixPerBallRows::FixPerBallRows(LAMMPS* lmp, int narg, char** arg, int width, int rest)
    : Fix(lmp, narg, arg), width_(width), rest_width_(rest)
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
}

void FixPerBallRows::grow_arrays(int nmax)
{
  const std::size_t balls = nmax, in_line = std::size(Line{}.numbers);
  lines_.resize((balls * width_ + in_line - 1) / in_line);
  rests_.resize(balls * rest_width_);
  first_ = reinterpret_cast<double*>(lines_.data());
  first_rest_ = rests_.data();
}

void FixPerBallRows::copy_arrays(int i, int j, int)
{
  std::copy_n(row(i), width_, row(j));
  std::copy_n(rest(i), rest_width_, rest(j));
}

void FixPerBallRows::set_arrays(int i)
{
  std::fill_n(row(i), width_, 0.0);
  std::fill_n(rest(i), rest_width_, 0.0);
}

int FixPerBallRows::pack_exchange(int i, double* buffer)
{
  std::copy_n(rest(i), rest_width_, std::copy_n(row(i), width_, buffer));
  return width_ + rest_width_;
}

int FixPerBallRows::unpack_exchange(int i, double* buffer)
{
  std::copy_n(buffer, width_, row(i));
  std::copy_n(buffer + width_, rest_width_, rest(i));
  return width_ + rest_width_;
}

int FixPerBallRows::pack_restart(int i, double* buffer)
{
  buffer[0] = size_restart(i);
  FixPerBallRows::pack_exchange(i, buffer + 1);
  return size_restart(i);
}

void FixPerBallRows::unpack_restart(int i, int nth)
{
  double* extra = atom->extra[i];
  for (int skipped = 0; skipped < nth; ++skipped) extra += static_cast<int>(*extra);
  if (static_cast<int>(*extra) != size_restart(i)) {
    const std::string message = "fix " + std::string(style) + ": the restart file holds " +
                                std::to_string(static_cast<int>(*extra) - 1) +
                                " numbers per ball, this version reads " +
                                std::to_string(width_ + rest_width_) +
                                "; run from the start, or use the version that wrote the file";
    // The engine aborts before its own line reaches a redirected output.
    std::fprintf(stderr, "ERROR: %s\n", message.c_str());
    error->one(FLERR, message.c_str());
  }
  FixPerBallRows::unpack_exchange(i, extra + 1);
}

double FixPerBallRows::memory_usage()
{
  return static_cast<double>(lines_.capacity() * sizeof(Line) + rests_.capacity() * sizeof(double));
}
