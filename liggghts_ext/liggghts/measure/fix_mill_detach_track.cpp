#include "liggghts/measure/fix_mill_detach_track.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "fix_contact_history_mesh.h"
#include "fix_mesh_surface.h"
#include "modify.h"
#include "tri_mesh.h"
#include "update.h"

#include "liggghts/common/keywords.h"
#include "liggghts/mill/mill_of.h"
#include "liggghts/wall/fix_wall_mill.h"
#include "liggghts/wall/style_liner.h"

using namespace LAMMPS_NS;
using namespace FixConst;
namespace detachment = millscale::detachment;
using detachment::Record;
using millscale::Vector;

namespace {

constexpr int record_size = detachment::record_size;
constexpr int all_balls = 0;  // the engine's first group
// Bits of a mark: the contacts of a ball. `seen_` adds the pending events in units of
// `pending_unit`.
constexpr signed char on_wall = 1, on_groove = 2, in_contact = 4;
constexpr signed char unknown = -1, pending_unit = 8;

/// The record in a row, in place and without a copy, because all balls are checked at each step.
/// Records consist of doubles only.
Record& record_in(double* row)
{
  static_assert(std::is_trivially_copyable_v<Record> && alignof(Record) == alignof(double));
  return *std::launder(reinterpret_cast<Record*>(row));
}

/// Return whether a wall triangle belongs to the groove. Such a triangle lies in the outer half of
/// the liner's height and faces the axis more than the circumference.
bool is_groove(TriMesh& mesh, int triangle, const detachment::Mill& mill, double inner_radius)
{
  Vector node[3], edge[2], centre{};
  for (int n = 0; n < 3; ++n) {
    mesh.node(triangle, n, node[n].data());
    for (int d = 0; d < 3; ++d) centre[d] += node[n][d] / 3.0;
  }
  for (int e = 0; e < 2; ++e)
    for (int d = 0; d < 3; ++d) edge[e][d] = node[e + 1][d] - node[0][d];
  const Vector normal = millscale::cross(edge[0], edge[1]);
  const Vector& axis = mill.frame.axis();
  Vector radial = mill.frame.arm(centre);
  const double along = millscale::dot(radial, axis);
  for (int d = 0; d < 3; ++d) radial[d] -= along * axis[d];
  const double radius = std::sqrt(millscale::dot(radial, radial));
  const double facing = std::abs(millscale::dot(normal, radial)) /
                        (radius * std::sqrt(millscale::dot(normal, normal)));
  return radius > 0.5 * (mill.radius + inner_radius) && facing > std::sqrt(0.5);
}

}  // namespace

FixMillDetachTrack::FixMillDetachTrack(LAMMPS* lmp, int narg, char** arg)
    : FixPerBallRows(lmp, narg, arg, record_size)
{
  restart_global = 1;
  nevery = 1;
  time_depend = 1;
  try {
    parse(narg, arg);
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
  seen_.assign(atom->nmax, unknown);
  carrier_.assign(atom->nmax, unknown);
  flight_place_.resize(atom->nmax);
  for (int i = 0; i < atom->nlocal; ++i) set_arrays(i);
}

void FixMillDetachTrack::parse(int narg, char** arg)
{
  millscale::Keywords()
      .word("mill", mill_id_)
      .add("lifters",
           [this](millscale::ArgumentList& list) {
             lifters_ = list.count("lifters", millscale::liner::most_sectors);
           })
      .positive("lifter_top_radius", lifter_top_radius_)
      .number("phase", phase_)
      .positive("gap", gap_)
      .positive("force_tolerance", force_tolerance_)
      .parse({narg, arg, 3});
  if (mill_id_.empty())
    throw std::invalid_argument("mill: the id of a fix mill/similarity is needed");
  liner_given_ = lifters_ > 0 || lifter_top_radius_ > 0.0 || phase_ != 0.0;
  if (lifters_ > 0 && lifter_top_radius_ == 0.0)
    throw std::invalid_argument("lifter_top_radius: needed [m] where lifters is > 0");
}

int FixMillDetachTrack::setmask()
{
  return END_OF_STEP;
}

void FixMillDetachTrack::init()
{
  try {
    mill_fix_ = mill_of(modify, mill_id_);
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
  analytic_walls_.clear();
  for (int f = 0; f < modify->nfix; ++f)
    if (auto* wall = dynamic_cast<FixWallMill*>(modify->fix[f])) analytic_walls_.push_back(wall);
  mill_.frame = mill_fix_->frame();
  mill_.radius = mill_fix_->scaled().mill.radius;
  try {
    take_liner();
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
}

/// Take the liner from the mill, or from the arguments if the mill states none.
void FixMillDetachTrack::take_liner()
{
  if (lifter_top_radius_ >= mill_.radius)
    throw std::invalid_argument("lifter_top_radius: must be below the scaled mill's radius " +
                                millscale::format(mill_.radius) + " m, got " +
                                millscale::format(lifter_top_radius_) + " m");
  if (liner_given_ || !mill_fix_->states_liner())
    StyleLiner(modify, *mill_fix_)
        .require_same_lifters({mill_.radius, lifter_top_radius_, 0.0, 0.0, lifters_, phase_});
  mill_.grooves = {std::max(lifters_, 1), phase_};
  inner_radius_ = lifter_top_radius_;
  if (!mill_fix_->states_liner()) return;
  const millscale::liner::Profile& profile = *mill_fix_->liner();
  mill_.grooves = profile.grooves();
  inner_radius_ = profile.is_drum() ? 0.0 : profile.clear_radius();
}

void FixMillDetachTrack::end_of_step()
{
  observe_all();
}

/// The present step, for the observation of all balls.
struct FixMillDetachTrack::Now {
  double mill_angle, time;
  millscale::Turn back;
  std::optional<detachment::TurnedGrooves> look;  ///< at the lifters that carry the balls
  detachment::Drive drive;
};

FixMillDetachTrack::Now FixMillDetachTrack::now() const
{
  const double angle = mill_fix_->mill_angle();
  return {
      angle,
      mill_fix_->mill_time(),
      millscale::Turn(-angle),
      looks_at_carriers() ? std::optional(detachment::TurnedGrooves(mill_, angle)) : std::nullopt,
      {mill_fix_->speed_now(), mill_fix_->gravity()}};
}

void FixMillDetachTrack::observe_all()
{
  const Now step = now();
  mark_contacts();
  for (int i = 0; i < atom->nlocal; ++i) {
    const double *x = atom->x[i], *v = atom->v[i];
    observe({{x[0], x[1], x[2]}, atom->radius[i], {v[0], v[1], v[2]}, i}, step);
  }
}

/// Advance the record of a ball whose contacts are marked.
void FixMillDetachTrack::observe(const millscale::kernels::Moment& ball, const Now& step)
{
  const int i = ball.ball;
  const bool changes = may_change(ball, step);
  if (!(changes || step.look) || !of_group(i)) return;
  const detachment::Observation now{(marks_[i] & on_groove) != 0,
                                    (marks_[i] & on_wall) != 0,
                                    (marks_[i] & in_contact) != 0,
                                    {ball.position[0], ball.position[1], ball.position[2]},
                                    {ball.velocity[0], ball.velocity[1], ball.velocity[2]},
                                    ball.radius,
                                    step.mill_angle,
                                    step.time};
  if (changes) {
    Record& record = record_in(row(i));
    count(detachment::observe(record, mill_, now, step.back, gap_), record);
    seen_[i] = marks_[i] + pending_unit * static_cast<signed char>(detachment::pending(record));
    flight_place_[i] = record.flight_place;
  }
  if (!step.look) return;
  double carrier = carrier_[i];
  detachment::follow_carrier(carrier, mill_, *step.look, step.drive, now, gap_);
  if (carrier == carrier_[i]) return;
  carrier_[i] = static_cast<float>(carrier);
  record_in(row(i)).carrier = carrier;
}

/// Return whether a ball is of the group. Reads nothing for the group of all balls.
bool FixMillDetachTrack::of_group(int i) const
{
  return igroup == all_balls || (atom->mask[i] & groupbit);
}

/// Mark the contacts of each ball.
void FixMillDetachTrack::mark_contacts()
{
  const int balls = atom->nlocal;
  marks_.resize(balls);
  // Every force on a ball except its weight is a contact force.
  const Vector& down = mill_.frame.down();
  const double g = mill_fix_->gravity(), gx = g * down[0], gy = g * down[1], gz = g * down[2],
               least = least_acceleration2();
  const double* mass = atom->rmass;
  const auto* force = reinterpret_cast<const double(*)[3]>(balls > 0 ? atom->f[0] : nullptr);
  for (int i = 0; i < balls; ++i) {
    const double m = mass[i], x = force[i][0] - m * gx, y = force[i][1] - m * gy,
                 z = force[i][2] - m * gz;
    marks_[i] = x * x + y * y + z * z > least * m * m ? in_contact : 0;
  }
  mark_walls(marks_);
  if (mill_fix_->meshes().fixes().empty()) return;
  for (int i = 0; i < balls; ++i) marks_[i] |= mesh_contacts(i);
}

/// Mark the contacts with analytic walls.
void FixMillDetachTrack::mark_walls(std::vector<signed char>& marks) const
{
  for (const FixWallMill* wall : analytic_walls_)
    wall->mark_contacts(marks, on_wall | in_contact, on_groove);
}

/// Return the square of the acceleration beyond which a ball counts as in contact [m^2/s^4].
double FixMillDetachTrack::least_acceleration2() const
{
  const double g = mill_fix_->gravity();
  return force_tolerance_ * force_tolerance_ * g * g;
}

bool FixMillDetachTrack::reads_analytic_walls_only() const
{
  return mill_fix_->meshes().fixes().empty();
}

const millscale::kernels::ContactWatch& FixMillDetachTrack::begin_pass()
{
  const auto balls = static_cast<std::size_t>(atom->nlocal);
  wall_marks_.assign(balls, 0);
  mark_walls(wall_marks_);
  marks_.resize(balls);
  if (moments_.size() < balls) moments_.resize(balls);
  if (never_seen_.size() < balls) never_seen_.resize(balls, unknown);
  watch_ = {wall_marks_.data(),    looks_at_carriers() ? never_seen_.data() : seen_.data(),
            marks_.data(),         in_contact,
            least_acceleration2(), moments_.data()};
  return watch_;
}

void FixMillDetachTrack::end_step(const millscale::kernels::Advanced& found)
{
  const Now step = now();
  constexpr int ahead = 6;  // records lie far apart in memory
  for (int k = 0; k < found.moments; ++k) {
    const millscale::kernels::Moment& ball = moments_[k];
    if (k + ahead < found.moments) prefetch(moments_[k + ahead].ball);
    observe(ball, step);
  }
}

/// Prefetch what an observation of the marked contacts needs of a ball.
void FixMillDetachTrack::prefetch(int i) const
{
  constexpr int line = 8;  // numbers
  const signed char seen = seen_[i];
  if (seen != unknown && seen % pending_unit == marks_[i]) {
    if (seen >= pending_unit) __builtin_prefetch(flight_place_.data() + i);
    return;
  }
  const double* const record = row(i);
  __builtin_prefetch(record, 1);
  const bool all = seen == unknown || (seen & ~marks_[i] & (on_groove | in_contact));
  for (int k = line; all && k < record_size; k += line) __builtin_prefetch(record + k, 1);
}

/// Return whether a ball's record can change at this step. Most records do not change at most
/// steps, and reading a record is slow because records are long.
bool FixMillDetachTrack::may_change(const millscale::kernels::Moment& ball, const Now& step) const
{
  const int i = ball.ball;
  if (seen_[i] == marks_[i]) return false;
  if (seen_[i] == unknown || seen_[i] % pending_unit != marks_[i]) return true;
  return detachment::may_confirm(static_cast<detachment::Pending>(seen_[i] / pending_unit), mill_,
                                 {ball.position[0], ball.position[1], ball.position[2]}, step.back,
                                 flight_place_[i], ball.radius, gap_);
}

void FixMillDetachTrack::count(const detachment::Confirmed& event, const Record& ball)
{
  if (event.liner_off) statistics_.liner_off.add(ball.liner_off.angle);
  if (!event.flight) return;
  statistics_.flight.add(ball.flight.angle);
  if (ball.outermost != 0.0) statistics_.outermost.add(ball.flight.angle);
}

/// Return whether the mill has passed a multiple of 1/25 of the lifters' pitch in this step. This
/// depends on the step alone, so a restart changes nothing.
bool FixMillDetachTrack::looks_at_carriers() const
{
  const double interval = 2.0 * millscale::pi / (25.0 * mill_.grooves.count());
  const double angle = mill_fix_->mill_angle();
  const double before = mill_fix_->angle_before_step();
  return std::floor(angle / interval) != std::floor(before / interval);
}

signed char FixMillDetachTrack::mesh_contacts(int i) const
{
  signed char marks = 0;
  for (FixMeshSurface* fix : mill_fix_->meshes().fixes()) {
    const FixContactHistoryMesh* contacts = fix->contactHistory();
    if (!contacts) continue;
    for (int j = 0; j < contacts->nneighs(i) && !(marks & on_groove); ++j) {
      const int id = contacts->get_partner_idTri(i, j);
      if (id < 0) continue;
      marks |= on_wall | in_contact;
      const int triangle = fix->triMesh()->map(id, 0);
      if (triangle >= 0 && is_groove(*fix->triMesh(), triangle, mill_, inner_radius_))
        marks |= on_groove;
    }
  }
  return marks;
}

detachment::State FixMillDetachTrack::state(int i) const
{
  if (seen_[i] == unknown) return static_cast<detachment::State>(record(i).state);
  return detachment::state((seen_[i] & on_wall) != 0, (seen_[i] & in_contact) != 0);
}

const Record& FixMillDetachTrack::record(int i) const
{
  return record_in(row(i));
}

double FixMillDetachTrack::mill_time() const
{
  return mill_fix_->mill_time();
}

FixMillDetachTrack::Statistics FixMillDetachTrack::statistics_of_all_ranks() const
{
  constexpr int size = sizeof(Statistics) / sizeof(double);
  std::vector<Statistics> of_rank(comm->nprocs);
  Statistics mine = statistics_, all;
  MPI_Allgather(&mine, size, MPI_DOUBLE, of_rank.data(), size, MPI_DOUBLE, world);
  for (const Statistics& part : of_rank) {
    all.liner_off.merge(part.liner_off);
    all.flight.merge(part.flight);
    all.outermost.merge(part.outermost);
  }
  return all;
}

void FixMillDetachTrack::set_arrays(int i)
{
  new (row(i)) Record{};
  forget(i);
}

/// A record has come from elsewhere.
void FixMillDetachTrack::forget(int i)
{
  seen_[i] = unknown;
  carrier_[i] = unknown;
}

void FixMillDetachTrack::grow_arrays(int nmax)
{
  FixPerBallRows::grow_arrays(nmax);
  seen_.resize(nmax, unknown);
  carrier_.resize(nmax, unknown);
  flight_place_.resize(nmax);
}

void FixMillDetachTrack::copy_arrays(int i, int j, int delflag)
{
  FixPerBallRows::copy_arrays(i, j, delflag);
  seen_[j] = seen_[i];
  carrier_[j] = carrier_[i];
  flight_place_[j] = flight_place_[i];
}

int FixMillDetachTrack::unpack_exchange(int i, double* buffer)
{
  forget(i);
  return FixPerBallRows::unpack_exchange(i, buffer);
}

void FixMillDetachTrack::unpack_restart(int i, int nth)
{
  forget(i);
  FixPerBallRows::unpack_restart(i, nth);
}

void FixMillDetachTrack::write_restart(FILE* file)
{
  const Statistics all = statistics_of_all_ranks();
  if (comm->me != 0) return;
  const int bytes = sizeof all;
  fwrite(&bytes, sizeof bytes, 1, file);
  fwrite(&all, 1, sizeof all, file);
}

void FixMillDetachTrack::restart(char* buffer)
{
  if (comm->me == 0) std::memcpy(static_cast<void*>(&statistics_), buffer, sizeof statistics_);
}
