#include "liggghts/loop/mill_loop.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <iterator>
#include <limits>

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "fix_nve_sphere.h"
#include "force.h"
#include "lammps.h"
#include "modify.h"
#include "neighbor.h"
#include "output.h"
#include "pair.h"
#include "signal_handling.h"
#include "timer.h"
#include "update.h"

#include "core/contact/damping_limit.h"
#include "liggghts/common/ends_steps.h"
#include "liggghts/common/first_fix.h"
#include "liggghts/measure/fix_mill_detach_track.h"
#include "liggghts/mill/fix_mill_similarity.h"
#include "liggghts/pair/fix_adaptive_skin.h"
#include "liggghts/pair/fix_ball_rows.h"
#include "liggghts/pair/fix_contact_damping.h"
#include "liggghts/pair/fix_pair_contact_history.h"
#include "liggghts/pair/pair_gran_fast.h"
#include "liggghts/run/fix_mill_guard.h"
#include "liggghts/run/fix_mill_restart.h"
#include "liggghts/wall/fix_wall_mill.h"

using namespace LAMMPS_NS;
using namespace FixConst;
namespace kernels = millscale::kernels;
using millscale::Vector;

namespace {

constexpr int all_balls = 0;     // the engine's first group
constexpr double inertia = 0.4;  // of a sphere over m r^2, as fix nve/sphere has it

constexpr int in_every_step = PRE_INITIAL_INTEGRATE | INITIAL_INTEGRATE | POST_INTEGRATE |
                              PRE_EXCHANGE | PRE_NEIGHBOR | PRE_FORCE | POST_FORCE |
                              PRE_FINAL_INTEGRATE | FINAL_INTEGRATE | ITERATE_IMPLICITLY;

// Bits that ranks agree on.
constexpr int moved = 1, left_skin = 2, quit = 4, restart_asked = 8;

// Protected members of the engine, named through a derived class as the language allows.
struct Positions : Neighbor {
  static constexpr double** Neighbor::*at_list = &Positions::xhold;
};
struct AddedMass : FixNVESphere {
  static constexpr double FixNVESphere::*factor = &AddedMass::onePlusCAddRhoFluid_;
};

/// Return whether a fix that acts at the end of steps leaves the balls as they are.
bool only_reads(const Fix& fix)
{
  constexpr const char* readers[] = {"ave/atom", "ave/correlate", "ave/histo",     "ave/spatial",
                                     "ave/time", "print",         "mill/occupancy"};
  return std::any_of(std::begin(readers), std::end(readers),
                     [&](const char* style) { return std::strcmp(fix.style, style) == 0; });
}

}  // namespace

MillLoop::MillLoop(LAMMPS* lmp) : Verlet(lmp, 0, nullptr) {}

void MillLoop::replace_engine_loop(LAMMPS& engine)
{
  delete engine.update->integrate;
  engine.update->integrate = new MillLoop(&engine);
}

void MillLoop::init()
{
  // The pair style of this run names itself in its own `init`, which follows.
  if (auto* rows = first_fix<FixBallRows>(modify)) rows->pair = nullptr;
  Verlet::init();
}

void MillLoop::setup()
{
  choose_loop();
  Verlet::setup();
}

void MillLoop::setup_minimal(int flag)
{
  choose_loop();
  Verlet::setup_minimal(flag);
}

/// Choose the loop of the run to come and say which it is.
void MillLoop::choose_loop()
{
  reason_ = find_participants();
  if (reason_.empty()) reason_ = engine_settings();
  if (reason_.empty()) reason_ = time_integration();
  if (comm->me != 0) return;
  const std::string text = reason_.empty() ? "Time loop: millscale's, on rows"
                                           : "Time loop: the engine's, because " + reason_;
  for (FILE* file : {screen, logfile})
    if (file) std::fprintf(file, "%s\n", text.c_str());
}

/// Find the styles that take part in a step. Return what needs the engine's loop.
std::string MillLoop::find_participants()
{
  rows_ = first_fix<FixBallRows>(modify);
  pair_ = rows_ ? rows_->pair : nullptr;
  mill_ = nullptr;
  track_ = nullptr;
  integration_ = nullptr;
  walls_.clear();
  at_end_.clear();
  gravity_first_ = false;
  guards_.clear();
  if (!pair_) return "there is no pair_style gran ... surface fast";
  if (const std::string reason = pair_->needs_engine_loop(); !reason.empty()) return reason;
  for (int f = 0; f < modify->nfix; ++f) {
    const std::string reason = place_in_step(modify->fix[f], modify->fmask[f]);
    if (!reason.empty())
      return std::string("fix ") + modify->fix[f]->style + " (id " + modify->fix[f]->id + ") " +
             reason;
  }
  return {};
}

/// Find the place of a fix in the step. Return why it needs the engine's loop.
std::string MillLoop::place_in_step(Fix* fix, int mask)
{
  if (auto* track = dynamic_cast<FixMillDetachTrack*>(fix)) {
    if (track_) return "is the second of its kind";
    if (!track->reads_analytic_walls_only()) return "reads contacts with a mesh";
    track_ = track;
  }
  if (auto* guard = dynamic_cast<FixMillGuard*>(fix)) guards_.push_back(guard);
  if (mask & END_OF_STEP) {
    auto* known = dynamic_cast<EndsSteps*>(fix);
    at_end_.push_back({fix, known, known || only_reads(*fix)});
  }
  if (!(mask & in_every_step)) return {};
  if (auto* mill = dynamic_cast<FixMillSimilarity*>(fix)) {
    if (mill_) return "is the second of its kind";
    if (fix->igroup != all_balls) return "acts on a group of balls";
    if (!mill->meshes().fixes().empty()) return "turns a mesh";
    mill_ = mill;
    gravity_first_ = walls_.empty();
    return {};
  }
  if (auto* wall = dynamic_cast<FixWallMill*>(fix)) {
    if (mill_ && !gravity_first_) return "follows gravity, which follows another wall";
    walls_.push_back(wall);
    return {};
  }
  if (std::strcmp(fix->style, "nve/sphere") == 0) {
    if (integration_) return "is the second of its kind";
    if (fix->igroup != all_balls) return "acts on a group of balls";
    integration_ = fix;
    return {};
  }
  if (dynamic_cast<FixAdaptiveSkin*>(fix) || dynamic_cast<FixPairContactHistory*>(fix) ||
      dynamic_cast<FixMillGuard*>(fix) || dynamic_cast<FixMillRestart*>(fix))
    return {};
  return "acts within every step";
}

std::string MillLoop::time_integration() const
{
  const auto* sphere = dynamic_cast<FixNVESphere*>(integration_);
  if (!sphere) return "no fix nve/sphere moves all balls";
  if (sphere->*AddedMass::factor != 1.0) return "fix nve/sphere adds the mass of a fluid";
  return {};
}

/// Return the setting of the engine that our loop does not follow.
std::string MillLoop::engine_settings() const
{
  if (neighbor->every != 1 || neighbor->delay != 0 || !neighbor->dist_check || neighbor->build_once)
    return "neigh_modify does not check distances at every step";
  if (neighbor->includegroup != 0 || atom->firstgroup >= 0) return "a group of balls comes first";
  if (force->newton) return "newton is on";
  if (force->pair && !pair_compute_flag) return "run_style or kspace switches the pair style off";
  if (atom->molecular || force->kspace) return "there are bonds or long-range forces";
  if (domain->triclinic || domain->is_wedge || domain->dimension != 3 || domain->box_change)
    return "the box is no fixed, orthogonal box in three dimensions";
  if (atom->radvary_flag) return "radii vary";
  if (modify->timing) return "the engine times each fix";
  return {};
}

void MillLoop::run(int n)
{
  if (!reason_.empty()) return Verlet::run(n);
  on_rows_ = false;
  signals_ = 0;
  for (int step = 0; step < n; ++step) {
    ++update->ntimestep;
    ev_set(update->ntimestep);
    bool rebuild;
    if (on_rows_) {
      if (mill_) mill_->initial_integrate(vflag);  // it counts the steps
      rebuild = rebuild_due();
    } else {
      signals_ = agree(0);
      restart_due_ = output->restart_requested(update->ntimestep);
      modify->initial_integrate(vflag);
      if (modify->n_post_integrate) modify->post_integrate();
      rebuild = neighbor->decide();
    }
    const bool of_engine = needs_engine_step();
    if (on_rows_ && (rebuild || of_engine)) {
      write_arrays(0, atom->nlocal);
      on_rows_ = false;
    }
    send_or_rebuild(rebuild);
    if (!of_engine) {
      step_on_rows();
      continue;
    }
    step_of_engine();
    if ((signals_ & quit) && !SignalHandler::request_write_restart) break;
  }
}

/// Return whether the present step must be the engine's, from the forces on.
bool MillLoop::needs_engine_step() const
{
  const bigint now = update->ntimestep;
  if (restart_due_ || eflag || vflag || signals_ || pair_->checks_list_now()) return true;
  return std::any_of(at_end_.begin(), at_end_.end(), [&](const AtEnd& end) {
    return !end.only_reads && now % end.fix->nevery == 0;
  });
}

/// Return whether the engine's arrays are read at the end of the present step.
bool MillLoop::needs_arrays() const
{
  const bigint now = update->ntimestep;
  return now == output->next || std::any_of(at_end_.begin(), at_end_.end(), [&](const AtEnd& end) {
           return end.known ? end.known->needs_arrays() : now % end.fix->nevery == 0;
         });
}

/// Return the bits that any rank has set, signals included. A rank that breaks off alone would
/// leave the others waiting.
int MillLoop::agree(int bits) const
{
  if (SignalHandler::request_quit) bits |= quit;
  if (SignalHandler::request_write_restart) bits |= restart_asked;
  if (comm->nprocs > 1) MPI_Allreduce(MPI_IN_PLACE, &bits, 1, MPI_INT, MPI_BOR, world);
  if (bits & quit) SignalHandler::request_quit = true;
  if (bits & restart_asked) SignalHandler::request_write_restart = true;
  return bits;
}

/// Return whether a new list is due, as the engine's `decide` does.
bool MillLoop::rebuild_due()
{
  const int bits = agree((found_.moved ? moved : 0) | (found_.left_skin ? left_skin : 0));
  signals_ = bits & (quit | restart_asked);
  const bigint now = update->ntimestep;
  restart_due_ = output->restart_requested(now);
  if (restart_due_ || (bits & left_skin)) return true;
  for (int f = 0; f < modify->nfix; ++f)
    if (modify->fix[f]->force_reneighbor && modify->fix[f]->next_reneighbor == now) return true;
  ++neighbor->ago;
  if ((bits & moved) && neighbor->ago == std::max(neighbor->every, neighbor->delay))
    ++neighbor->ndanger;
  return bits & moved;
}

/// Bring the ghosts up to date, or sort the balls anew and build the lists.
void MillLoop::send_or_rebuild(bool rebuild)
{
  timer->stamp();
  if (!rebuild) {
    if (on_rows_)
      rows_->send_ghosts();
    else
      comm->forward_comm();
    timer->stamp(TIME_COMM);
    return;
  }
  if (modify->n_pre_exchange) modify->pre_exchange();
  domain->pbc();
  timer->stamp();
  comm->exchange();
  if (atom->sortfreq > 0 && update->ntimestep >= atom->nextsort) atom->sort();
  comm->borders();
  timer->stamp(TIME_COMM);
  if (modify->n_pre_neighbor) modify->pre_neighbor();
  neighbor->build();
  timer->stamp(TIME_NEIGHBOR);
}

/// From the forces to the end of the step, as the engine does it.
void MillLoop::step_of_engine()
{
  force_clear();
  if (modify->n_pre_force) modify->pre_force(vflag);
  timer->stamp();
  force->pair->compute(eflag, vflag);
  timer->stamp(TIME_PAIR);
  if (modify->n_post_force) modify->post_force(vflag);
  modify->final_integrate();
  if (modify->n_end_of_step) modify->end_of_step();
  write_output();
}

void MillLoop::write_output()
{
  if (update->ntimestep != output->next) return;
  timer->stamp();
  output->write(update->ntimestep);
  timer->stamp(TIME_OUTPUT);
}

/// From the forces to the places of the next step, on rows.
void MillLoop::step_on_rows()
{
  timer->stamp();
  if (!on_rows_ && neighbor->ago == 0) {
    pair_->build_list();
    timer->stamp(TIME_NEIGHBOR);
  }
  if (!on_rows_) read_arrays();
  on_rows_ = true;
  pair_->evaluate_rows();
  timer->stamp(TIME_PAIR);
  advance(evaluate_walls(), needs_arrays());
  end_step();
  write_output();
}

/// Let the fixes act that act at the end of this step.
void MillLoop::end_step()
{
  for (const AtEnd& end : at_end_)
    if (end.known && !end.known->needs_arrays())
      end.known->end_step(found_);
    else if (update->ntimestep % end.fix->nevery == 0)
      end.fix->end_of_step();
}

/// Copy the engine's balls and ghosts to the rows, with what lasts as long as the list.
void MillLoop::read_arrays()
{
  const kernels::Rows rows = rows_->store.rows();
  const int all = atom->nlocal + atom->nghost;
  const double* damping = pair_->limited_damping() ? pair_->damping()->up_to_date() : nullptr;
  for (int i = 0; i < all; ++i) {
    const double *x = atom->x[i], *v = atom->v[i], *spin = atom->omega[i], mass = atom->rmass[i];
    rows.position[i] = {x[0], x[1], x[2], atom->radius[i]};
    const double share =
        damping ? millscale::contact::damping_share(damping[i], mass, update->dt) : 0.0;
    rows.velocity[i] = {{v[0], v[1], v[2]}, mass, {spin[0], spin[1], spin[2]}, share};
    if (rows_->single) kernels::to_single(rows.velocity[i], rows.single_velocity[i]);
  }
  read_list();
  const double half = 0.5 * update->dt * force->ftm2v, half_spin = half / inertia;
  kick_.resize(atom->nlocal);
  for (int i = 0; i < atom->nlocal; ++i) {
    const double radius = atom->radius[i], mass = atom->rmass[i];
    kick_[i] = {half / mass, half_spin / (radius * radius * mass)};
  }
}

/// Read where the balls were when the list was built, and their skins.
void MillLoop::read_list()
{
  double** const at_list = neighbor->*Positions::at_list;
  const millscale::neighbor::AdaptiveSkin& skin = pair_->skin().skin();
  const double* skins = skin.data();
  start_.resize(atom->nlocal);
  for (int i = 0; i < atom->nlocal; ++i)
    start_[i] = {at_list[i][0], at_list[i][1], at_list[i][2], skins[i]};
}

/// Copy places and velocities of some balls to the engine's arrays, within a step.
void MillLoop::write_arrays(int begin, int end)
{
  const kernels::Rows rows = rows_->store.rows();
  for (int i = begin; i < end; ++i) {
    const kernels::PositionRow& at = rows.position[i];
    const kernels::VelocityRow& motion = rows.velocity[i];
    atom->x[i][0] = at.x;
    atom->x[i][1] = at.y;
    atom->x[i][2] = at.z;
    std::copy(motion.velocity, motion.velocity + 3, atom->v[i]);
    std::copy(motion.spin, motion.spin + 3, atom->omega[i]);
  }
}

/// Evaluate the contacts of the walls. Return the forces, in ascending order of the balls.
const std::vector<kernels::WallForce>& MillLoop::evaluate_walls()
{
  const kernels::Rows rows = rows_->store.rows();
  // Begin with the first number of the first ball; a rank may have none.
  const auto column = [](const auto* row, std::size_t offset) {
    return kernels::BallNumbers{reinterpret_cast<const double*>(row) + offset / sizeof(double),
                                sizeof *row / sizeof(double)};
  };
  const auto sums = [](const auto* row, auto number, std::size_t offset) {
    using Number = decltype(number);
    return kernels::BallSums(reinterpret_cast<const Number*>(row) + offset / sizeof(Number),
                             sizeof *row / sizeof(Number));
  };
  using kernels::ForceRow, kernels::PositionRow, kernels::SingleForceRow, kernels::VelocityRow;
  const kernels::WallInput balls{
      column(rows.position, 0),
      column(rows.position, offsetof(PositionRow, radius)),
      column(rows.velocity, 0),
      column(rows.velocity, offsetof(VelocityRow, mass)),
      column(rows.velocity, offsetof(VelocityRow, spin)),
      rows_->single ? sums(rows.single_force, float{}, offsetof(SingleForceRow, damping))
                    : sums(rows.force, double{}, offsetof(ForceRow, damping))};
  if (walls_.size() == 1) return walls_[0]->evaluate(balls, update->dt);
  wall_forces_.clear();
  for (FixWallMill* wall : walls_) {
    const auto& forces = wall->evaluate(balls, update->dt);
    wall_forces_.insert(wall_forces_.end(), forces.begin(), forces.end());
  }
  std::stable_sort(wall_forces_.begin(), wall_forces_.end(),
                   [](const auto& a, const auto& b) { return a.ball < b.ball; });
  return wall_forces_;
}

/// Copy the ghosts to the engine's arrays, within a step.
void MillLoop::copy_ghosts()
{
  write_arrays(atom->nlocal, atom->nlocal + atom->nghost);
  for (double** sums : {atom->f, atom->torque})
    if (atom->nghost > 0) std::fill_n(sums[atom->nlocal], 3 * atom->nghost, 0.0);
}

/// End this step and begin the next one. copy: the end of the step to the engine's arrays.
void MillLoop::advance(const std::vector<kernels::WallForce>& wall_forces, bool copy)
{
  const auto three = [](double** of_balls) {
    return reinterpret_cast<double(*)[3]>(of_balls ? of_balls[0] : nullptr);
  };
  const kernels::EndOfStep arrays{three(atom->x), three(atom->v), three(atom->omega),
                                  three(atom->f), three(atom->torque)};
  if (copy) copy_ghosts();
  const millscale::neighbor::AdaptiveSkin& skin = pair_->skin().skin();
  kernels::Advance pass{};
  pass.rows = rows_->store.rows();
  pass.single = rows_->single;
  pass.balls = atom->nlocal;
  pass.kick = kick_.data();
  pass.dt = update->dt;
  if (mill_)
    for (int d = 0; d < 3; ++d) pass.gravity[d] = mill_->gravity() * mill_->down()[d];
  pass.gravity_first = gravity_first_;
  pass.wall_begin = wall_forces.data();
  pass.wall_end = pass.wall_begin + wall_forces.size();
  pass.damping =
      pair_->limited_damping() && atom->nlocal > 0 ? &pair_->damping()->of_ball(0) : nullptr;
  pass.start = start_.data();
  pass.moved_limit2 = 0.25 * neighbor->skin * neighbor->skin;
  pass.own_skins = skin.by_speed();
  pass.origin = skin.origin();
  skin.turn_columns(pair_->skin().time_since_build(update->ntimestep + 1), pass.turn_columns);
  double limit = std::numeric_limits<double>::infinity();
  for (const FixMillGuard* guard : guards_)
    if (guard->checks_speeds_now()) limit = std::min(limit, guard->speed_limit());
  pass.checks_speed = std::isfinite(limit);
  pass.speed_limit2 = limit * limit;
  pass.watch = track_ ? &track_->begin_pass() : nullptr;
  pass.copy = copy ? &arrays : nullptr;
  found_ = pair_->kernel().advance(pass);
}
