#include "liggghts/measure/compute_mill_detach.h"

#include <cstring>

#include "atom.h"
#include "error.h"
#include "group.h"
#include "memory.h"
#include "modify.h"
#include "update.h"

#include "liggghts/measure/fix_mill_detach_track.h"

using namespace LAMMPS_NS;
namespace detachment = millscale::detachment;

namespace {

constexpr int columns = 24;
constexpr int statistics_size = 12;

void put_event(const detachment::Event& event, double*& out)
{
  *out++ = event.count;
  *out++ = event.angle;
  *out++ = event.mill_angle;
  *out++ = event.groove;
  for (double x : event.position) *out++ = x;
  for (double v : event.velocity) *out++ = v;
}

void put_statistics(const detachment::AngleStatistics& angle, double*& out)
{
  *out++ = angle.count;
  *out++ = angle.mean;
  *out++ = angle.standard_deviation();
}

}  // namespace

ComputeMillDetach::ComputeMillDetach(LAMMPS* lmp, int& iarg, int narg, char** arg)
    : Compute(lmp, iarg, narg, arg)
{
  vector_flag = peratom_flag = 1;
  size_vector = statistics_size;
  extvector = 0;
  size_peratom_cols = columns;
  vector = new double[statistics_size];
  track_arguments_ = {std::string(id) + "_track", group->names[igroup], "mill/detach/track"};
  track_arguments_.insert(track_arguments_.end(), arg + iarg, arg + narg);
  iarg = narg;
}

ComputeMillDetach::~ComputeMillDetach()
{
  // At the end of the program the engine deletes all fixes before the computes.
  if (modify->find_fix(track_arguments_[0].c_str()) >= 0)
    modify->delete_fix(track_arguments_[0].c_str());
  memory->destroy(columns_);
  delete[] vector;
}

void ComputeMillDetach::post_create()
{
  std::vector<char*> arguments;
  for (std::string& word : track_arguments_) arguments.push_back(word.data());
  modify->add_fix(static_cast<int>(arguments.size()), arguments.data());
}

FixMillDetachTrack* ComputeMillDetach::tracker()
{
  auto* fix = dynamic_cast<FixMillDetachTrack*>(modify->find_fix_id(track_arguments_[0].c_str()));
  if (!fix) {
    const std::string message =
        "its fix " + track_arguments_[0] + " was removed; define the compute again";
    error->compute_error(FLERR, this, message.c_str());
  }
  return fix;
}

void ComputeMillDetach::init()
{
  tracker();
}

void ComputeMillDetach::compute_vector()
{
  invoked_vector = update->ntimestep;
  const FixMillDetachTrack& track = *tracker();
  const FixMillDetachTrack::Statistics all = track.statistics_of_all_ranks();
  double* out = vector;
  put_statistics(all.liner_off, out);
  put_statistics(all.flight, out);
  put_statistics(all.outermost, out);

  double balls_in[3] = {0.0, 0.0, 0.0};
  for (int i = 0; i < atom->nlocal; ++i)
    if (atom->mask[i] & groupbit) balls_in[static_cast<int>(track.state(i)) - 1] += 1.0;
  MPI_Allreduce(balls_in, out, 3, MPI_DOUBLE, MPI_SUM, world);
}

void ComputeMillDetach::compute_peratom()
{
  invoked_peratom = update->ntimestep;
  if (atom->nmax > rows_) {
    rows_ = atom->nmax;
    memory->grow(columns_, rows_, columns, "mill/detach:columns");
    array_atom = columns_;
  }
  const FixMillDetachTrack& track = *tracker();
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!(atom->mask[i] & groupbit)) {
      std::fill(columns_[i], columns_[i] + columns, 0.0);
      continue;
    }
    const detachment::Record& ball = track.record(i);
    double* out = columns_[i];
    *out++ = ball.state;
    put_event(ball.liner_off, out);
    put_event(ball.flight, out);
    *out++ = ball.in_flight != 0.0 ? track.mill_time() - ball.flight.time : 0.0;
    *out++ = ball.outermost;
    *out++ = ball.carrier;
  }
}

double ComputeMillDetach::memory_usage()
{
  return static_cast<double>(rows_) * columns * sizeof(double);
}
