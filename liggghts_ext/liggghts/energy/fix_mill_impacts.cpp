#include "liggghts/energy/fix_mill_impacts.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "modify.h"
#include "update.h"

#include "core/math/constants.h"
#include "core/math/format.h"
#include "liggghts/common/first_fix.h"
#include "liggghts/common/keywords.h"
#include "liggghts/energy/covered_contacts.h"
#include "liggghts/mill/mill_of.h"

using namespace LAMMPS_NS;
using namespace FixConst;
namespace contact = millscale::contact;
namespace energy = millscale::energy;
namespace kernels = millscale::kernels;

namespace {

constexpr double layout = 2.0;  // of restart files
constexpr int first_slot = 16;  // numbers: two cache lines
constexpr int slot_size = energy::WallContactWork::numbers;
static_assert(sizeof(energy::WallContactWork) == slot_size * sizeof(double));

double dot(const double* a, const double* b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

}  // namespace

FixMillImpacts::FixMillImpacts(LAMMPS* lmp, int narg, char** arg)
    : FixPerBallRows(lmp, narg, arg, first_slot, (wall_slots - 1) * slot_size),
      classes_(atom->ntypes),
      spectra_(classes_.count()),
      kept_(atom->nmax)
{
  vector_flag = 1;
  size_vector = published;
  global_freq = 1;
  extvector = 0;
  restart_global = 1;
  nevery = 1;
  try {
    if (first_fix<FixMillImpacts>(modify))
      throw std::invalid_argument(
          "a deck takes one fix mill/impacts, and this is the second; leave one out");
    if (igroup != 0) throw std::invalid_argument("group: the spectra cover all balls; use `all`");
    parse(narg, arg);
    mill_fix_ = mill_of(modify, mill_id_);
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
}

void FixMillImpacts::parse(int narg, char** arg)
{
  millscale::Keywords()
      .word("mill", mill_id_)
      .word("file", file_)
      .number("from", from_)
      .number("to", to_)
      .parse({narg, arg, 3});
  if (file_.empty()) throw std::invalid_argument("file: the name of the file to write is needed");
  if (!(from_ >= 0.0 && to_ > from_))
    throw std::invalid_argument("from, to: mill angles 0 <= from < to are needed [rad], got " +
                                millscale::format(from_) + " and " + millscale::format(to_));
}

int FixMillImpacts::setmask()
{
  return END_OF_STEP | POST_RUN;
}

void FixMillImpacts::init()
{
  try {
    mill_fix_ = mill_of(modify, mill_id_);
    require_recorded_contacts(force, modify, "impacts");
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
  forces_carried_ = recent_restart && modify->n_fixes_style("mill/forces") > 0;
}

void FixMillImpacts::setup(int)
{
  published_step_ = -1;
  if (!forces_carried_) {
    const Pairings first_kick = half_kick();
    for (int p = 0; p < energy::pairings; ++p) sums_.end_terms[p] += first_kick[p] - last_kick_[p];
  }
  last_kick_ = {};
  if (window_.begun == 0.0) begin();
  if (window_.open == 0.0 && window_.written == 0.0 && mill_fix_->mill_angle() >= from_)
    open_window();
}

energy::WorkRecord* FixMillImpacts::begin_balls(millscale::neighbor::PairList& list,
                                                const kernels::Laws& laws, bool moves)
{
  list_ = &list;
  laws_ = laws;
  if (static_cast<int>(ended_.size()) < list.entries) ended_.resize(list.entries);
  record_ = {list.work.columns(), list.next_work.columns(), list.available.data(), ended_.data(),
             moves ? 0.5 * update->dt : 0.0};
  return &record_;
}

void FixMillImpacts::end_balls()
{
  // After a restart the loads at set-up are those of the file, of the same contacts.
  const bool carried = record_.half_step == 0.0 && forces_carried_;
  if (!carried || record_.count > 0 || record_.begun > 0) std::swap(list_->work, list_->next_work);
  sums_.totals[energy::ball_ball].work += record_.total();
  for (int k = 0; k < record_.count; ++k) {
    const energy::EndedContact& contact = ended_[k];
    end_contact(energy::ball_ball, classes_.of_balls(atom->type[contact.i], atom->type[contact.j]),
                contact.dissipated, contact.available, contact.j < atom->nlocal ? 1.0 : 0.5);
  }
}

void FixMillImpacts::end_contact(energy::Pairing pairing, int impact_class, double dissipated,
                                 double available, double share)
{
  sums_.totals[pairing].add(dissipated, available, share);
  if (window_.open != 0.0) spectra_[impact_class].add(dissipated, available, share);
}

energy::WallContactWork* FixMillImpacts::wall_slot(int i, int slot) const
{
  return reinterpret_cast<energy::WallContactWork*>(slot == 0 ? row(i)
                                                              : rest(i) + (slot - 1) * slot_size);
}

void FixMillImpacts::record_wall(int i, const OnWall& on)
{
  const bool keeps = on.dt == 0.0 && forces_carried_;
  const double half_step = 0.5 * on.dt;
  energy::ImpactTotals& totals = sums_.totals[energy::ball_wall];
  const auto power = [&](const energy::WallContactWork& work) {
    return dot(work.force, on.velocity) + dot(work.torque, on.spin) - work.wall_power;
  };
  const auto update_work = [&](energy::WallContactWork& work, int k, bool continues) {
    double done = -half_step * power(work);
    for (int d = 0; d < 3; ++d) {
      work.force[d] = on.batch.loads[d][k];
      work.torque[d] = on.batch.torque[d][k];
    }
    work.wall_power = on.batch.wall_power[k];
    done -= half_step * power(work);
    if (!continues) work.available = on.dt > 0.0 ? on.batch.approach[k] : 0.0;
    work.stored = on.batch.stored[k];
    work.dissipated += done;
    work.open = 1.0;
    totals.work += done;
  };
  const bool only_one = on.slots_before == 1 && on.end - on.begin == 1;
  if (only_one && !keeps && on.slot_before[on.begin] == 0 && on.batch.overlap[on.begin] > 0.0 &&
      wall_slot(i, 0)->open != 0.0)
    return update_work(*wall_slot(i, 0), on.begin,
                       true);  // as most are; what follows gives the same
  energy::WallContactWork before[wall_slots];
  int were = 0;
  while (were < on.slots_before && wall_slot(i, were)->open != 0.0) {
    before[were] = *wall_slot(i, were);
    ++were;
  }
  int count = 0;
  for (int k = on.begin; k < on.end; ++k) {
    if (!(on.batch.overlap[k] > 0.0)) continue;
    energy::WallContactWork& work = *wall_slot(i, count++);
    work = {};
    const int slot = on.slot_before[k];
    const bool continues = slot != begins && slot < were;
    if (continues) {
      work = before[slot];
      before[slot].open = 0.0;
    }
    if (!keeps) update_work(work, k, continues);
  }
  for (int s = 0; s < were; ++s) {
    if (s >= count) wall_slot(i, s)->open = 0.0;
    if (before[s].open == 0.0) continue;
    const double last = half_step * power(before[s]);
    totals.work -= last;
    end_contact(energy::ball_wall, classes_.on_wall(atom->type[i]), before[s].dissipated - last,
                before[s].available, 1.0);
  }
}

/// Return what this rank counts of the contact of an entry.
double FixMillImpacts::share_of(int entry) const
{
  return list_->other[entry] < atom->nlocal ? 1.0 : 0.5;
}

/// Call visit(entry, number) for each contact of balls.
template <class Visit>
void FixMillImpacts::for_each_open(const Visit& visit) const
{
  if (list_) millscale::neighbor::for_each_contact(*list_, visit);
}

/// Return what the tangential spring of the contact of an entry stores [J].
double FixMillImpacts::stored(int entry) const
{
  const int i = list_->own[entry], j = list_->other[entry];
  const auto& law = laws_.of_types[(atom->type[i] - 1) * laws_.types + atom->type[j] - 1];
  const double* displacement = &list_->displacement[3 * static_cast<std::size_t>(entry)];
  return contact::tangential_energy(law, atom->radius[i], atom->radius[j],
                                    millscale::vector3(atom->x[i]) - millscale::vector3(atom->x[j]),
                                    millscale::vector3(displacement));
}

/// Return what lasts of this rank's contacts.
FixMillImpacts::Open FixMillImpacts::open_contacts() const
{
  Open open;
  const auto add = [&](energy::Pairing p, double dissipated, double stored, double share) {
    open.contacts[p] += share;
    open.dissipated[p] += share * (dissipated - stored);
    open.stored[p] += share * stored;
  };
  for_each_open([&](int entry, int number) {
    add(energy::ball_ball, list_->work.get(number).dissipated, stored(entry), share_of(entry));
  });
  for (int i = 0; i < atom->nlocal; ++i)
    for (int s = 0; s < wall_slots && wall_slot(i, s)->open != 0.0; ++s)
      add(energy::ball_wall, wall_slot(i, s)->dissipated, wall_slot(i, s)->stored, 1.0);
  return open;
}

/// Return dt/4 times the power of the loads at the velocities that half a step gains [J]. The sums
/// multiply the loads by the velocity between two steps, half a step beyond both ends of a run. The
/// energy dissipated between the ends is more by this at the first, and less by this at the last.
FixMillImpacts::Pairings FixMillImpacts::half_kick() const
{
  const double dt = update->dt;
  const auto power = [&](int i, const double* force, const double* torque) {
    const double by_mass = 0.5 * dt / atom->rmass[i];
    const double by_inertia =
        by_mass / (millscale::sphere_inertia * atom->radius[i] * atom->radius[i]);
    return by_mass * dot(force, atom->f[i]) + by_inertia * dot(torque, atom->torque[i]);
  };
  Pairings sum{};
  for_each_open([&](int entry, int number) {
    const int i = list_->own[entry], j = list_->other[entry];
    const energy::ContactWork work = list_->work.get(number);
    const auto separation = millscale::vector3(atom->x[i]) - millscale::vector3(atom->x[j]);
    const auto add = [&](int ball, const energy::LoadOnBall& load) {
      sum[energy::ball_ball] += power(ball, millscale::to_array(load.force).data(),
                                      millscale::to_array(load.torque).data());
    };
    add(i, energy::load_on_i(work, separation, atom->radius[i], atom->radius[j]));
    if (j >= atom->nlocal) return;
    const auto back = -1.0 * separation;
    add(j, energy::load_on_i(energy::seen_from_j(work), back, atom->radius[j], atom->radius[i]));
  });
  for (int i = 0; i < atom->nlocal; ++i)
    for (int s = 0; s < wall_slots && wall_slot(i, s)->open != 0.0; ++s)
      sum[energy::ball_wall] += power(i, wall_slot(i, s)->force, wall_slot(i, s)->torque);
  for (double& energy : sum) energy *= 0.25 * dt;
  return sum;
}

/// Begin the measurement. What the contacts store at its begin will come back, or be dissipated.
void FixMillImpacts::begin()
{
  window_.begun = 1.0;
  for_each_open([&](int entry, int number) {
    const double energy = list_->work.columns().dissipated[number] = stored(entry);
    sums_.totals[energy::ball_ball].work += share_of(entry) * energy;
  });
  for (int i = 0; i < atom->nlocal; ++i)
    for (int s = 0; s < wall_slots && wall_slot(i, s)->open != 0.0; ++s) {
      wall_slot(i, s)->dissipated = wall_slot(i, s)->stored;
      sums_.totals[energy::ball_wall].work += wall_slot(i, s)->stored;
    }
}

void FixMillImpacts::open_window()
{
  window_.open = 1.0;
  window_.first_angle = window_.last_angle = mill_fix_->mill_angle();
  window_.first_time = window_.last_time = mill_fix_->mill_time();
  sums_.at_begin = open_contacts();
  for (int p = 0; p < energy::pairings; ++p) sums_.work_at_begin[p] = sums_.totals[p].work;
}

/// The window opens and ends with what the contacts store, by the engine's positions.
bool FixMillImpacts::needs_arrays() const
{
  if (window_.written != 0.0) return false;
  return mill_fix_->mill_angle() >= (window_.open == 0.0 ? from_ : to_);
}

void FixMillImpacts::end_of_step()
{
  if (window_.written != 0.0) return;
  const double angle = mill_fix_->mill_angle();
  if (window_.open == 0.0) {
    if (angle >= from_) open_window();
    return;
  }
  window_.last_angle = angle;
  window_.last_time = mill_fix_->mill_time();
  if (angle < to_) return;
  write();
  window_.open = 0.0;
  window_.written = 1.0;
}

/// A run that ends within the window writes the spectra so far.
void FixMillImpacts::post_run()
{
  last_kick_ = half_kick();
  if (window_.open != 0.0 && window_.last_angle > window_.first_angle) write();
}

template <class Numbers>
void FixMillImpacts::sum_over_ranks(Numbers& numbers, int count) const
{
  static_assert(sizeof(Numbers) % sizeof(double) == 0);
  MPI_Allreduce(MPI_IN_PLACE, &numbers, count * static_cast<int>(sizeof(Numbers) / sizeof(double)),
                MPI_DOUBLE, MPI_SUM, world);
}

/// Write under another name, then rename: an existing file is complete.
void FixMillImpacts::write()
{
  Sums sums = sums_;
  Open open = open_contacts();
  std::vector<energy::ImpactSpectra> spectra = spectra_;
  sum_over_ranks(sums, 1);
  sum_over_ranks(open, 1);
  sum_over_ranks(spectra[0], classes_.count());
  int done = 1;
  if (comm->me == 0) {
    const std::string part = file_ + ".part";
    done = put_file(part, sums, open, spectra) && std::rename(part.c_str(), file_.c_str()) == 0;
  }
  MPI_Bcast(&done, 1, MPI_INT, 0, world);
  if (done) return;
  const std::string message =
      "file: cannot write '" + file_ + "'; check the folder and the disk space";
  error->fix_error(FLERR, this, message.c_str());
}

bool FixMillImpacts::put_file(const std::string& name, const Sums& sums, const Open& open,
                              const std::vector<energy::ImpactSpectra>& spectra) const
{
  FILE* out = std::fopen(name.c_str(), "w");
  if (!out) return false;
  std::fputs(
      "mill_angle_from_rad,mill_angle_to_rad,duration_s,pairing,type_1,type_2,quantity,"
      "energy_low_J,energy_high_J,contacts,energy_J\n",
      out);
  const char* pairings[] = {"ball_ball", "ball_wall"};
  const auto put = [&](int pairing, energy::ImpactClass of, const char* quantity, double low,
                       double high, double contacts, double joule) {
    std::fprintf(out, "%.10g,%.10g,%.10g,%s,%d,%d,%s,%.10g,%.10g,%.17g,%.17g\n",
                 window_.first_angle, window_.last_angle, window_.last_time - window_.first_time,
                 pairings[pairing], of.first, of.second, quantity, low, high, contacts, joule);
  };
  for (int p = 0; p < energy::pairings; ++p) {
    const energy::ImpactClass all{0, 0};
    put(p, all, "open_at_begin", 0.0, 0.0, sums.at_begin.contacts[p], sums.at_begin.dissipated[p]);
    put(p, all, "open_at_end", 0.0, 0.0, open.contacts[p], open.dissipated[p]);
    const double work = sums.totals[p].work - sums.work_at_begin[p];
    put(p, all, "all_contacts", 0.0, 0.0, 0.0, work - open.stored[p] + sums.at_begin.stored[p]);
  }
  for (int k = 0; k < classes_.count(); ++k) {
    const energy::ImpactClass of = classes_.at(k);
    const int pairing =
        of.second == energy::ImpactClass::wall ? energy::ball_wall : energy::ball_ball;
    const auto put_spectrum = [&](const char* quantity, const energy::ImpactSpectrum& spectrum) {
      for (int bin = 0; bin < energy::ImpactSpectrum::bins; ++bin)
        if (spectrum.count[bin] > 0.0)
          put(pairing, of, quantity, energy::ImpactSpectrum::edge(bin),
              energy::ImpactSpectrum::edge(bin + 1), spectrum.count[bin], spectrum.energy_sum[bin]);
    };
    put_spectrum("dissipated", spectra[k].dissipated);
    put_spectrum("available", spectra[k].available);
  }
  const bool complete = std::ferror(out) == 0;
  return std::fclose(out) == 0 && complete;
}

void FixMillImpacts::compute_published()
{
  Sums sums = sums_;
  Open open = open_contacts();
  Pairings kick = half_kick();
  sum_over_ranks(sums, 1);
  sum_over_ranks(open, 1);
  sum_over_ranks(kick, 1);
  double* out = published_.data();
  for (int p = 0; p < energy::pairings; ++p) {
    const energy::ImpactTotals& totals = sums.totals[p];
    const double ends = sums.end_terms[p] - kick[p];
    for (const double number : {totals.contacts, totals.available, totals.dissipated,
                                open.dissipated[p] + ends, totals.work - open.stored[p] + ends})
      *out++ = number;
  }
}

double FixMillImpacts::compute_vector(int k)
{
  if (published_step_ != update->ntimestep) compute_published();
  published_step_ = update->ntimestep;
  return published_[k];
}

/// Return the sums of this rank as numbers.
std::vector<double> FixMillImpacts::numbers_of_rank() const
{
  static_assert(sizeof(Sums) % sizeof(double) == 0);
  std::vector<double> numbers((sizeof(Sums) + spectra_.size() * sizeof(energy::ImpactSpectra)) /
                              sizeof(double));
  std::memcpy(numbers.data(), &sums_, sizeof(Sums));
  std::memcpy(numbers.data() + sizeof(Sums) / sizeof(double), spectra_.data(),
              spectra_.size() * sizeof(energy::ImpactSpectra));
  return numbers;
}

/// Add the sums of a rank to those of this rank.
void FixMillImpacts::add_numbers(const double* from)
{
  const auto add = [&](auto& sums, std::size_t count) {
    auto* to = reinterpret_cast<double*>(&sums);
    for (std::size_t k = 0; k < count * sizeof sums / sizeof(double); ++k) to[k] += *from++;
  };
  add(sums_, 1);
  add(spectra_[0], spectra_.size());
}

/// Write the sums of each rank: a continued run with as many ranks then rounds like an
/// uninterrupted one.
void FixMillImpacts::write_restart(FILE* file)
{
  const std::vector<double> mine = numbers_of_rank();
  const int size = static_cast<int>(mine.size());
  std::vector<double> all(comm->me == 0 ? mine.size() * comm->nprocs : 0);
  MPI_Gather(mine.data(), size, MPI_DOUBLE, all.data(), size, MPI_DOUBLE, 0, world);
  if (comm->me != 0) return;
  const double head[] = {layout, static_cast<double>(atom->ntypes),
                         static_cast<double>(comm->nprocs)};
  const int bytes = static_cast<int>(sizeof head + sizeof window_ + all.size() * sizeof(double));
  fwrite(&bytes, sizeof bytes, 1, file);
  fwrite(head, sizeof head, 1, file);
  fwrite(&window_, sizeof window_, 1, file);
  fwrite(all.data(), sizeof(double), all.size(), file);
}

void FixMillImpacts::restart(char* buffer)
{
  double head[3];
  std::memcpy(head, buffer, sizeof head);
  if (head[0] != layout || head[1] != atom->ntypes) {
    const std::string message =
        "the restart file holds layout " + millscale::format(head[0]) + " of this fix for " +
        millscale::format(head[1]) + " atom types, needed are layout " + millscale::format(layout) +
        " and " + std::to_string(atom->ntypes) + " types; give the fix another id to begin again";
    error->fix_error(FLERR, this, message.c_str());
  }
  std::memcpy(&window_, buffer + sizeof head, sizeof window_);
  const int ranks = static_cast<int>(head[2]);
  const std::size_t size = numbers_of_rank().size();
  std::vector<double> all(size * ranks);
  std::memcpy(all.data(), buffer + sizeof head + sizeof window_, all.size() * sizeof(double));
  for (int rank = 0; rank < ranks; ++rank)
    if (ranks == comm->nprocs ? rank == comm->me : comm->me == 0)
      add_numbers(all.data() + rank * size);
}

void FixMillImpacts::forget_kept()
{
  if (any_kept_)
    for (auto& works : kept_) works.clear();
  any_kept_ = false;
}

void FixMillImpacts::keep(int i, const energy::CarriedWork& work)
{
  kept_[i].push_back(work);
  any_kept_ = true;
}

energy::CarriedWork FixMillImpacts::kept(int i, int k) const
{
  return k < static_cast<int>(kept_[i].size()) ? kept_[i][k] : energy::CarriedWork{};
}

double FixMillImpacts::memory_usage()
{
  return FixPerBallRows::memory_usage() +
         static_cast<double>(ended_.capacity() * sizeof(energy::EndedContact) +
                             kept_.capacity() * sizeof(kept_[0]));
}

void FixMillImpacts::grow_arrays(int nmax)
{
  FixPerBallRows::grow_arrays(nmax);
  kept_.resize(nmax);
}

void FixMillImpacts::copy_arrays(int i, int j, int deletes)
{
  FixPerBallRows::copy_arrays(i, j, deletes);
  kept_[j] = kept_[i];
}

void FixMillImpacts::set_arrays(int i)
{
  FixPerBallRows::set_arrays(i);
  kept_[i].clear();
}

int FixMillImpacts::pack_exchange(int i, double* buffer)
{
  double* to = buffer + FixPerBallRows::pack_exchange(i, buffer);
  *to++ = static_cast<double>(kept_[i].size());
  for (const energy::CarriedWork& work : kept_[i]) {
    std::memcpy(to, &work, sizeof work);
    to += energy::CarriedWork::numbers;
  }
  return static_cast<int>(to - buffer);
}

int FixMillImpacts::unpack_exchange(int i, double* buffer)
{
  const double* from = buffer + FixPerBallRows::unpack_exchange(i, buffer);
  kept_[i].resize(static_cast<std::size_t>(*from++));
  any_kept_ |= !kept_[i].empty();
  for (energy::CarriedWork& work : kept_[i]) {
    std::memcpy(&work, from, sizeof work);
    from += energy::CarriedWork::numbers;
  }
  return static_cast<int>(from - buffer);
}

int FixMillImpacts::size_restart(int i)
{
  return FixPerBallRows::size_restart(i) + 1 +
         energy::CarriedWork::numbers * static_cast<int>(kept_[i].size());
}

int FixMillImpacts::maxsize_restart()
{
  int most = FixPerBallRows::maxsize_restart() + 1;
  for (int i = 0; i < atom->nlocal; ++i) most = std::max(most, size_restart(i));
  return most;
}

int FixMillImpacts::pack_restart(int i, double* buffer)
{
  buffer[0] = size_restart(i);
  return 1 + FixMillImpacts::pack_exchange(i, buffer + 1);
}

void FixMillImpacts::unpack_restart(int i, int nth)
{
  double* extra = atom->extra[i];
  for (int skipped = 0; skipped < nth; ++skipped) extra += static_cast<int>(*extra);
  FixMillImpacts::unpack_exchange(i, extra + 1);
}
