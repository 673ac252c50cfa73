#include "liggghts/run/fix_mill_guard.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <stdexcept>

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fix_property_global.h"
#include "force.h"
#include "modify.h"
#include "neigh_list.h"
#include "pair.h"
#include "update.h"

#include "core/contact/time_step.h"
#include "core/kernels/advance.h"
#include "core/math/constants.h"
#include "liggghts/common/end_run.h"
#include "liggghts/common/first_fix.h"
#include "liggghts/common/keywords.h"
#include "liggghts/mill/mill_of.h"
#include "liggghts/pair/fix_ball_rows.h"
#include "liggghts/pair/pair_gran_fast.h"
#include "liggghts/wall/fix_wall_mill.h"
#include "liggghts/wall/style_liner.h"

using namespace LAMMPS_NS;
using namespace FixConst;
namespace charge = millscale::charge;
namespace contact = millscale::contact;
namespace liner = millscale::liner;
using millscale::Vector;

namespace {

// Checking walls and overlaps takes a third of a step (docs/results/performance.md), so 0.3 % at
// every 100th step, in which the paper's mill turns by 0.02 rad. A faulty run has such overlaps at
// all times. A single shorter impact may be missed.
constexpr int default_every = 100;
// Velocities are checked more often, since faults spread by them; a check takes 1 % of a step. A
// step with the engine's mesh wall is several times as long, and the mesh wall aborts without a
// message at a position that is not finite.
constexpr int speeds_every = 5, speeds_every_with_mesh = 1;
// Hertz's law holds for overlaps that are small against the radius. At half the radius two balls
// are practically merged. The paper's balls at 10 m/s: 0.13.
constexpr double default_overlap = 0.5;
constexpr int fixed_boundary = 1;  // of domain->boundary: f

Vector vector_of(const double* x)
{
  return {x[0], x[1], x[2]};
}

}  // namespace

FixMillGuard::FixMillGuard(LAMMPS* lmp, int narg, char** arg)
    : Fix(lmp, narg, arg), every_(default_every), overlap_limit_(default_overlap)
{
  nevery = 1;  // end_of_step selects the steps itself
  try {
    parse(narg, arg);
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
}

void FixMillGuard::parse(int narg, char** arg)
{
  millscale::Keywords keywords;
  keywords.word("mill", mill_id_)
      .count("every", every_)
      .positive("overlap", overlap_limit_)
      .positive("speed", speed_);
  liner_arguments_.add_to(keywords);
  keywords.parse({narg, arg, 3});
  if (mill_id_.empty())
    throw std::invalid_argument("mill: the id of a fix mill/similarity is needed");
  if (every_ < 1) throw std::invalid_argument("every: expected a number of steps >= 1, got 0");
}

int FixMillGuard::setmask()
{
  return PRE_EXCHANGE | END_OF_STEP;
}

void FixMillGuard::init()
{
  try {
    mill_fix_ = mill_of(modify, mill_id_);
    millscale::similarity::OperatingPoint mill = mill_fix_->scaled().mill;
    mill.omega = mill_fix_->largest_speed();
    speeds_every_ = mill_fix_->meshes().fixes().empty() ? speeds_every : speeds_every_with_mesh;
    frame_ = mill_fix_->frame();
    speed_limit_ = speed_ > 0.0 ? speed_ : charge::plausible_speed(mill);
    wall_ = std::make_unique<charge::WallGuard>(
        *StyleLiner(modify, *mill_fix_).of(liner_arguments_), mill.ball_radius, overlap_limit_);
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
}

/// Check before the engine sorts balls into cells, which needs finite positions, and deletes balls
/// outside the box.
void FixMillGuard::setup_pre_exchange()
{
  pre_exchange();
}

void FixMillGuard::setup(int)
{
  if (force->pair && !force->pair->list)
    error->fix_error(FLERR, this, "needs the neighbour list of pair_style gran, or no pair style");
  turn_ = millscale::Turn(mill_fix_->mill_angle());
  check_forces();
  check_wall();
  check_overlaps();
}

void FixMillGuard::pre_exchange()
{
  check_speeds();
  check_box();
}

/// A force that is not finite makes the velocity not finite in the same step, and the position in
/// the next.
void FixMillGuard::end_of_step()
{
  if (checks_speeds_now()) check_speeds();
  if (update->ntimestep % every_ != 0) return;
  turn_ = millscale::Turn(mill_fix_->mill_angle());
  check_box();
  check_wall();
  check_overlaps();
}

void FixMillGuard::check_speeds() const
{
  if (atom->nlocal == 0) return;
  const auto count = static_cast<std::size_t>(atom->nlocal);
  const auto first = charge::first_beyond(atom->v[0], count, speed_limit_);
  for (std::size_t i = first; i < count; ++i)
    check_speed(suspect(static_cast<int>(i)), static_cast<int>(i));
}

void FixMillGuard::check_speed(const charge::Suspect& ball, int i) const
{
  const double speed = std::sqrt(millscale::dot(ball.velocity, ball.velocity));
  if (speed <= speed_limit_ || !(atom->mask[i] & groupbit)) return;
  if (!std::isfinite(speed)) stop(ball, i, "has no finite velocity");
  stop(ball, i,
       "is faster than the limit of " + millscale::format(speed_limit_) + " m/s" +
           (speed_ > 0.0 ? "" : ", twice what this mill can give a ball"));
}

/// A guard of some balls reads the velocities of all.
bool FixMillGuard::needs_arrays() const
{
  constexpr int all_balls = 0;  // the engine's first group
  return update->ntimestep % every_ == 0 || (igroup != all_balls && checks_speeds_now());
}

bool FixMillGuard::reads_overlap_now()
{
  return update->ntimestep % every_ == 0;
}

bool FixMillGuard::checks_speeds_now() const
{
  return update->ntimestep % speeds_every_ == 0;
}

void FixMillGuard::end_step(const millscale::kernels::Advanced& found)
{
  if (!found.fast || !checks_speeds_now()) return;
  const auto& fast = found.first_fast;
  check_speed({atom->tag[fast.ball], fast.position, fast.velocity, fast.force}, fast.ball);
}

/// Check the forces of the set-up, which move the balls in the first step.
void FixMillGuard::check_forces() const
{
  for (int i = 0; i < atom->nlocal; ++i)
    if ((atom->mask[i] & groupbit) && !charge::finite(vector_of(atom->f[i])))
      stop(i, "has no finite force");
}

/// Check for balls that the engine would delete: beyond a side of the box that is neither periodic
/// nor shrink-wrapped.
void FixMillGuard::check_box() const
{
  constexpr double largest = std::numeric_limits<double>::max();
  double low[3], high[3];
  for (int d = 0; d < 3; ++d) {
    const auto closed = [&](int side) {
      return !domain->periodicity[d] && domain->boundary[d][side] == fixed_boundary;
    };
    low[d] = closed(0) ? domain->boxlo[d] : -largest;
    high[d] = closed(1) ? domain->boxhi[d] : largest;
  }
  const auto inside = [&](const double* x, int d) { return x[d] >= low[d] && x[d] < high[d]; };
  for (int i = 0; i < atom->nlocal; ++i) {
    const double* x = atom->x[i];
    if (inside(x, 0) & inside(x, 1) & inside(x, 2)) continue;
    if (!(atom->mask[i] & groupbit)) continue;
    for (int d = 0; d < 3; ++d)
      if (!inside(x, d))
        stop(i, std::isfinite(x[d]) ? std::string("is outside the box in ") + "xyz"[d]
                                    : "has no finite position");
  }
}

void FixMillGuard::check_wall() const
{
  for (int i = 0; i < atom->nlocal; ++i) {
    const Vector arm = frame_.arm(atom->x[i]);
    const double along = millscale::dot(arm, frame_.axis());
    if (wall_->clear(millscale::dot(arm, arm) - along * along, atom->radius[i])) continue;
    if (!(atom->mask[i] & groupbit)) continue;
    if (const auto fault = wall_->fault(at_rest(vector_of(atom->x[i])), atom->radius[i]))
      stop(i, *fault);
  }
}

void FixMillGuard::check_overlaps() const
{
  if (!force->pair) return;  // a single ball
  const auto* rows = first_fix<FixBallRows>(modify);
  const auto noted = rows && rows->pair ? rows->pair->largest_overlap() : std::nullopt;
  if (noted && *noted < overlap_limit_ * smallest_radius()) return;
  const NeighList* list = force->pair->list;
  for (int n = 0; n < list->inum; ++n) {
    const int i = list->ilist[n];
    check_pairs_of(i, list->firstneigh[i], list->numneigh[i]);
  }
}

/// Return the smallest radius among this rank's balls and ghosts [m].
double FixMillGuard::smallest_radius() const
{
  const int all = atom->nlocal + atom->nghost;
  return all > 0 ? *std::min_element(atom->radius, atom->radius + all) : 0.0;
}

void FixMillGuard::check_pairs_of(int i, const int* others, int count) const
{
  const double *x = atom->x[i], radius = atom->radius[i];
  for (int n = 0; n < count; ++n) {
    const int j = others[n] & NEIGHMASK;
    const double dx = atom->x[j][0] - x[0], dy = atom->x[j][1] - x[1], dz = atom->x[j][2] - x[2];
    const double smaller = std::fmin(radius, atom->radius[j]);
    const double least = radius + atom->radius[j] - overlap_limit_ * smaller;
    const double square = dx * dx + dy * dy + dz * dz;
    if (square >= least * least || !(atom->mask[i] & groupbit)) continue;
    const double overlap = radius + atom->radius[j] - std::sqrt(square);
    stop(i, "overlaps ball " + std::to_string(atom->tag[j]) + " by " +
                millscale::format(overlap / smaller) + " of the smaller radius, the limit is " +
                millscale::format(overlap_limit_));
  }
}

liner::Point FixMillGuard::at_rest(const Vector& x) const
{
  return liner::section(frame_.point(x.data()).in_turning_frame(turn_));
}

/// Return the circumstances without a collective: the other ranks do not know of the fault.
charge::Circumstances FixMillGuard::circumstances_of(const charge::Suspect& ball, int i) const
{
  charge::Circumstances found;
  const Vector& x = ball.position;
  const auto* analytic = first_fix<FixWallMill>(modify);
  const bool meshes = modify->n_fixes_style("wall/gran") > 0;
  const bool turned = !mill_fix_->meshes().fixes().empty();
  found.walls = analytic || meshes;
  found.compared = analytic || turned || !meshes;
  found.wobble = mill_fix_->meshes().wobble();
  found.past_open_end = turned ? mill_fix_->meshes().past_end(x)
                               : analytic && !analytic->has_ends() && past_end_of_box(x);
  found.hole = turned && !found.past_open_end && wall_->near(at_rest(x)) &&
               !mill_fix_->meshes().in_direction(x);
  const auto property = [&](const char* name) -> std::optional<double> {
    auto* fix = dynamic_cast<FixPropertyGlobal*>(modify->find_fix_property(
        name, "property/global", "peratomtype", atom->ntypes, 0, style, false));
    if (!fix) return std::nullopt;
    return fix->compute_vector(atom->type[i] - 1);
  };
  const auto modulus = property("youngsModulus"), ratio = property("poissonsRatio");
  if (!modulus || !ratio) return found;
  const double radius = atom->radius[i];
  const contact::Material material{*modulus, *ratio,
                                   atom->rmass[i] / millscale::ball_volume(radius)};
  found.step = update->dt / contact::rayleigh_time(material, radius);
  found.bed_overlap =
      contact::bed_overlap(material, mill_fix_->gravity(), mill_fix_->scaled().mill.radius);
  return found;
}

bool FixMillGuard::past_end_of_box(const Vector& x) const
{
  for (int d = 0; d < 3; ++d)
    if (std::abs(mill_fix_->axis()[d]) > 0.5 &&
        (x[d] < domain->boxlo[d] || x[d] >= domain->boxhi[d]))
      return true;
  return false;
}

charge::Suspect FixMillGuard::suspect(int i) const
{
  return {atom->tag[i], vector_of(atom->x[i]), vector_of(atom->v[i]), vector_of(atom->f[i])};
}

void FixMillGuard::stop(int i, const std::string& fault) const
{
  stop(suspect(i), i, fault);
}

void FixMillGuard::stop(const charge::Suspect& ball, int i, const std::string& fault) const
{
  millscale::EndRun(lmp).because(charge::report(ball, fault, static_cast<long>(update->ntimestep),
                                                wall_->where(at_rest(ball.position)),
                                                charge::causes(circumstances_of(ball, i))));
}
