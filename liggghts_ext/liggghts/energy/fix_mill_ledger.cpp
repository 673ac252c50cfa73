#include "liggghts/energy/fix_mill_ledger.h"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "modify.h"
#include "update.h"

#include "core/math/constants.h"
#include "liggghts/common/first_fix.h"
#include "liggghts/common/keywords.h"
#include "liggghts/energy/covered_contacts.h"
#include "liggghts/mill/mill_of.h"

using namespace LAMMPS_NS;
using namespace FixConst;
namespace contact = millscale::contact;
namespace energy = millscale::energy;
using millscale::Vector;

namespace {

constexpr double layout = 1.0;  // of restart files

}  // namespace

struct FixMillLedger::State {
  double layout, begun;
  Energies begin;
  Window window;
  energy::WorkSums work;
  std::array<double, energy::pairings> slip, impacts, impact_energy;
  std::array<energy::ImpactSpectrum, energy::pairings> spectrum;
};

FixMillLedger::FixMillLedger(LAMMPS* lmp, int narg, char** arg) : Fix(lmp, narg, arg)
{
  vector_flag = 1;
  size_vector = numbers;
  global_freq = 1;
  extvector = 0;
  restart_global = 1;
  nevery = 1;
  try {
    if (first_fix<FixMillLedger>(modify))
      throw std::invalid_argument(
          "a deck takes one fix mill/ledger, and this is the second; leave one out");
    if (igroup != 0)
      throw std::invalid_argument("group: the energy budget covers all balls; use `all`");
    parse(narg, arg);
    mill_fix_ = mill_of(modify, mill_id_);
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
}

void FixMillLedger::parse(int narg, char** arg)
{
  millscale::Keywords()
      .word("mill", mill_id_)
      .word("impacts", file_)
      .number("from", window_.from)
      .number("to", window_.to)
      .parse({narg, arg, 3});
  if (!file_.empty() && !(window_.from >= 0.0 && window_.to > window_.from))
    throw std::invalid_argument("impacts: mill angles 0 <= from < to are needed [rad], got from " +
                                millscale::format(window_.from) + " to " +
                                millscale::format(window_.to));
}

int FixMillLedger::setmask()
{
  return PRE_FORCE | END_OF_STEP | POST_RUN;
}

void FixMillLedger::init()
{
  try {
    mill_fix_ = mill_of(modify, mill_id_);
    require_recorded_contacts(force, modify, "energy budget");
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
  forces_carried_ = recent_restart && modify->n_fixes_style("mill/forces") > 0;
}

void FixMillLedger::setup_pre_force(int vflag)
{
  pre_force(vflag);
}

void FixMillLedger::pre_force(int)
{
  const auto balls = static_cast<std::size_t>(atom->nlocal);
  const double angle = mill_fix_->mill_angle();
  const bool inside = !file_.empty() && angle >= window_.from && angle <= window_.to;
  for (energy::ContactSums* sums :
       {static_cast<energy::ContactSums*>(&between_balls_), &on_wall_}) {
    sums->clear(balls);
    sums->in_window = inside && window_.written == 0.0;
  }
}

/// Return this rank's powers of the step's forces at the velocities of the full step plus `shift`
/// [s] times the accelerations.
energy::Works FixMillLedger::powers(double shift) const
{
  energy::Works sum;
  for (int i = 0; i < atom->nlocal; ++i) {
    const double by_mass = shift / atom->rmass[i];
    const double by_inertia =
        by_mass / (millscale::sphere_inertia * atom->radius[i] * atom->radius[i]);
    Vector v, spin;
    for (int d = 0; d < 3; ++d) {
      v[d] = atom->v[i][d] + by_mass * atom->f[i][d];
      spin[d] = atom->omega[i][d] + by_inertia * atom->torque[i][d];
    }
    for (int k = 0; k < contact::works; ++k) {
      sum.on_balls[energy::ball_ball][k] += contact::power(between_balls_.loads[i][k], v, spin);
      sum.on_balls[energy::ball_wall][k] += contact::power(on_wall_.loads[i][k], v, spin);
    }
  }
  for (int k = 0; k < contact::works; ++k) {
    sum.on_balls[energy::ball_wall][k] -= on_wall_.wall_power[k];
    sum.of_mill += on_wall_.wall_power[k];  // walls at rest do no work
  }
  return sum;
}

void FixMillLedger::setup(int)
{
  terms_step_ = -1;
  if (!forces_carried_) work_.wait_for(powers(0.25 * update->dt), update->dt);
  forces_carried_ = false;
  if (begun_ != 0.0) return;
  begin_ = energies_of_all_ranks();
  begun_ = 1.0;
}

void FixMillLedger::end_of_step()
{
  const double dt = update->dt;
  work_.step(powers(-0.25 * dt), powers(0.25 * dt), dt);
  if (file_.empty() || window_.written != 0.0) return;
  const double angle = mill_fix_->mill_angle();
  if (angle < window_.from) return;
  if (angle > window_.to) {
    write_impacts();
    window_.written = 1.0;
    return;
  }
  if (window_.last == 0.0) window_.first = angle;
  window_.last = angle;
}

/// A run that ends within the window writes the spectrum so far.
void FixMillLedger::post_run()
{
  if (!file_.empty() && window_.last > 0.0 && window_.written == 0.0) write_impacts();
}

FixMillLedger::Energies FixMillLedger::energies() const
{
  Energies e;
  for (int i = 0; i < atom->nlocal; ++i) {
    const double *v = atom->v[i], *w = atom->omega[i], mass = atom->rmass[i];
    const double rr = atom->radius[i] * atom->radius[i];
    e.translation += 0.5 * mass * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    e.rotation +=
        0.5 * millscale::sphere_inertia * mass * rr * (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    const Vector x{atom->x[i][0], atom->x[i][1], atom->x[i][2]};
    e.potential -= mass * mill_fix_->gravity() * millscale::dot(x, mill_fix_->down());
  }
  e.stored = {energy::Stored{between_balls_.normal_energy, between_balls_.tangential_energy},
              energy::Stored{on_wall_.normal_energy, on_wall_.tangential_energy}};
  return e;
}

FixMillLedger::Energies FixMillLedger::energies_of_all_ranks() const
{
  static_assert(sizeof(Energies) % sizeof(double) == 0);
  Energies mine = energies(), all;
  MPI_Allreduce(&mine, &all, sizeof(Energies) / sizeof(double), MPI_DOUBLE, MPI_SUM, world);
  return all;
}

/// Return the state with the sums over all ranks; the rest is the same on all ranks.
FixMillLedger::State FixMillLedger::state_of_all_ranks() const
{
  static_assert(sizeof(State) % sizeof(double) == 0);
  State mine{layout,
             begun_,
             begin_,
             window_,
             work_,
             {between_balls_.slip, on_wall_.slip},
             {between_balls_.impacts, on_wall_.impacts},
             {between_balls_.impact_energy, on_wall_.impact_energy},
             {between_balls_.spectrum, on_wall_.spectrum}};
  State all = mine;
  const int sums = (sizeof(State) - offsetof(State, work)) / sizeof(double);
  MPI_Allreduce(&mine.work, &all.work, sums, MPI_DOUBLE, MPI_SUM, world);
  return all;
}

/// Compute all terms of this step.
void FixMillLedger::compute_terms()
{
  const State all = state_of_all_ranks();
  const Energies now = begun_ != 0.0 ? energies_of_all_ranks() : begin_;
  terms_ = {all.work.done.of_mill, now.translation - begin_.translation,
            now.rotation - begin_.rotation, now.potential - begin_.potential};
  double residual = terms_[0] - terms_[1] - terms_[2] - terms_[3];
  double* out = &terms_[4];
  for (int p = 0; p < energy::pairings; ++p) {
    const energy::PairingTerms t =
        terms_of(all.work.done.on_balls[p], begin_.stored[p], now.stored[p], all.slip[p]);
    for (const double term :
         {t.elastic_normal, t.elastic_tangential, t.dissipated_normal, t.dissipated_tangential,
          t.dissipated_rolling, t.tangential_dashpot, t.tangential_slip, t.spring_error})
      *out++ = term;
    residual -= t.elastic_normal + t.elastic_tangential + t.dissipated_normal +
                t.dissipated_tangential + t.dissipated_rolling;
  }
  *out++ = residual;
  for (int p = 0; p < energy::pairings; ++p) {
    *out++ = all.impacts[p];
    *out++ = all.impact_energy[p];
  }
}

double FixMillLedger::compute_vector(int k)
{
  try {
    mill_fix_ = mill_of(modify, mill_id_);  // it may have been removed between two runs
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
  if (terms_step_ != update->ntimestep) compute_terms();
  terms_step_ = update->ntimestep;
  return terms_[k];
}

/// Write under another name, then rename: an existing file is complete.
void FixMillLedger::write_impacts()
{
  const State all = state_of_all_ranks();
  int done = 1;
  if (comm->me == 0) {
    const std::string part = file_ + ".part";
    done = put_impacts(part, all) && std::rename(part.c_str(), file_.c_str()) == 0;
  }
  MPI_Bcast(&done, 1, MPI_INT, 0, world);
  if (done) return;
  const std::string message =
      "impacts: cannot write '" + file_ + "'; check the folder and the disk space";
  error->fix_error(FLERR, this, message.c_str());
}

bool FixMillLedger::put_impacts(const std::string& name, const State& all) const
{
  FILE* out = std::fopen(name.c_str(), "w");
  if (!out) return false;
  std::fputs(
      "mill_angle_from_rad,mill_angle_to_rad,pairing,energy_low_J,energy_high_J,impacts,energy_J\n",
      out);
  const char* names[] = {"ball_ball", "ball_wall"};
  for (int p = 0; p < energy::pairings; ++p)
    for (int bin = 0; bin < energy::ImpactSpectrum::bins; ++bin)
      std::fprintf(out, "%.10g,%.10g,%s,%.10g,%.10g,%.10g,%.10g\n", window_.first, window_.last,
                   names[p], energy::ImpactSpectrum::edge(bin),
                   energy::ImpactSpectrum::edge(bin + 1), all.spectrum[p].count[bin],
                   all.spectrum[p].energy_sum[bin]);
  const bool complete = std::ferror(out) == 0;
  return std::fclose(out) == 0 && complete;
}

void FixMillLedger::write_restart(FILE* file)
{
  const State all = state_of_all_ranks();
  if (comm->me != 0) return;
  const int bytes = sizeof(State);
  fwrite(&bytes, sizeof bytes, 1, file);
  fwrite(&all, sizeof(State), 1, file);
}

void FixMillLedger::restart(char* buffer)
{
  State from;
  std::memcpy(&from, buffer, sizeof(State));
  if (from.layout != layout) {
    const std::string message = "the restart file holds layout " + millscale::format(from.layout) +
                                " of this fix, this version reads layout " +
                                millscale::format(layout) +
                                "; give the fix another id to begin a new budget";
    error->fix_error(FLERR, this, message.c_str());
  }
  begun_ = from.begun;
  begin_ = from.begin;
  const double to = window_.to, wanted_from = window_.from;
  window_ = from.window;
  window_.from = wanted_from;
  window_.to = to;
  if (comm->me != 0) return;  // the sums are of all ranks: rank 0 keeps them
  work_ = from.work;
  energy::ContactSums* sums[] = {&between_balls_, &on_wall_};
  for (int p = 0; p < energy::pairings; ++p) {
    sums[p]->slip = from.slip[p];
    sums[p]->impacts = from.impacts[p];
    sums[p]->impact_energy = from.impact_energy[p];
    sums[p]->spectrum = from.spectrum[p];
  }
}
