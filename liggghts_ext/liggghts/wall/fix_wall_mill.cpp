#include "liggghts/wall/fix_wall_mill.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "atom.h"
#include "domain.h"
#include "error.h"
#include "group.h"
#include "modify.h"
#include "neighbor.h"
#include "update.h"

#include "core/contact/contact_energy.h"
#include "core/kernels/kernel.h"
#include "core/kernels/wall_contact.h"
#include "core/liner/groove_box.h"
#include "core/liner/nearest.h"
#include "liggghts/common/contact_laws.h"
#include "liggghts/common/first_fix.h"
#include "liggghts/common/keywords.h"
#include "liggghts/common/one_per_ball.h"
#include "liggghts/energy/fix_mill_impacts.h"
#include "liggghts/energy/fix_mill_ledger.h"
#include "liggghts/mill/fix_mill_similarity.h"
#include "liggghts/mill/mill_of.h"
#include "liggghts/pair/fix_contact_damping.h"
#include "liggghts/wall/fix_mill_liner_loads.h"
#include "liggghts/wall/style_liner.h"

using namespace LAMMPS_NS;
using namespace FixConst;
namespace contact = millscale::contact;
namespace kernels = millscale::kernels;
namespace liner = millscale::liner;
using millscale::format;
using millscale::Vector;

namespace {

constexpr int slots = liner::Contacts::most + 2;  // liner, two ends
constexpr int slot_size = 4;                      // key, tangential displacement

constexpr int none = -1;  // patch, or slot
static_assert(none == FixMillImpacts::begins && slots == FixMillImpacts::wall_slots);
constexpr int block = 64;         // entries of `Near` examined together
constexpr std::size_t ahead = 8;  // prefetch distance in forces

constexpr double lower_end = -1.0, upper_end = -2.0;  // keys; those of the liner are positive

/// Bits of the contacts of a ball.
constexpr signed char on_groove = 1, on_wall = 2, several = 4;

/// Return what a ball does to the liner in a step. axis: of the mill; torque: on the mill about the
/// axis [N m]; begins: the contact is new.
millscale::charge::LinerLoads loads_of(const contact::Contact<double>& on_wall,
                                       const contact::ContactForce<double>& result,
                                       const contact::EvaluatedContact& evaluated,
                                       const millscale::Vector3<double>& axis, double torque,
                                       double dt, bool begins)
{
  const double into = -dot(on_wall.velocity, on_wall.normal);
  const double damping_force = result.normal_force - result.elastic_force;
  millscale::charge::LinerLoads loads{
      result.normal_force * dt, -dot(result.force, cross(on_wall.normal, axis)) * dt, torque * dt,
      evaluated.slip_work(), damping_force * into * dt};
  const double energy = begins ? evaluated.approach_energy() : 0.0;
  if (!(energy > 0.0)) return loads;
  const double along2 = dot(on_wall.velocity, on_wall.velocity) - into * into;
  loads[millscale::charge::impacts] = 1.0;
  loads[millscale::charge::impact_energy] = energy;
  loads[millscale::charge::finnie_energy] =
      millscale::charge::finnie_energy_of(on_wall.mass, into, std::sqrt(std::max(0.0, along2)));
  return loads;
}

/// The groove's bit, or that of the other surfaces.
signed char mark_of(const liner::Profile& profile, double key)
{
  return key > 0.0 && profile.is_groove(static_cast<int>(key) - 1) ? on_groove : on_wall;
}

}  // namespace

FixWallMill::FixWallMill(LAMMPS* lmp, int narg, char** arg)
    : FixPerBallRows(lmp, narg, arg, slot_size, (slots - 1) * slot_size),
      kernels_(kernels::best_implementation().wall)
{
  vector_flag = 1;
  size_vector = 6;
  global_freq = 1;
  extvector = 1;
  try {
    parse(narg, arg);
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
}

void FixWallMill::parse(int narg, char** arg)
{
  millscale::Keywords keywords;
  keywords.word("mill", mill_id_).count("type", wall_type_);
  liner_arguments_.add_to(keywords);
  keywords
      .add("groove",
           [this](millscale::ArgumentList& list) {
             const bool polygon = list.choice("groove", "polygon", "arc");
             chord_error_ = polygon ? list.positive("groove polygon") : 0.0;
           })
      .add("ends",
           [this](millscale::ArgumentList& list) {
             const double low = list.number("ends, lower"), high = list.number("ends, upper");
             ends_ = liner::EndWalls{low, high};
             ends_->check();
           })
      .choice("end_motion", "mill", "rest", ends_turn_)
      .count("end_type", end_type_)
      .choice("rolling_friction", "cdt", "off", terms_.rolling)
      .choice("tangential_damping", "bounded", "on", terms_.limited_damping)
      .parse({narg, arg, 3});
  if (end_type_ == 0) end_type_ = wall_type_;
  const auto require_type = [this](const std::string& key, int type) {
    if (type < 1 || type > atom->ntypes)
      throw std::invalid_argument(key + ": the wall's atom type must be 1 to " +
                                  std::to_string(atom->ntypes) + ", got " + std::to_string(type));
  };
  require_type("type", wall_type_);
  require_type("end_type", end_type_);
}

liner::Widths FixWallMill::widths() const
{
  return liner_arguments_.widths(mill_of(modify, mill_id_)->scaled().mill.radius);
}

void FixWallMill::take_liner()
{
  mill_fix_ = mill_of(modify, mill_id_);
  liner_ = StyleLiner(modify, *mill_fix_).of_wall(liner_arguments_);
  if (chord_error_ > 0.0)
    liner_ = std::make_shared<const liner::Profile>(liner::wall_profile(*liner_, chord_error_));
}

int FixWallMill::setmask()
{
  return POST_FORCE;
}

void FixWallMill::init()
{
  try {
    require_one_per_ball(*this, modify, atom, group, world);
    take_liner();
    check_box();
    const double largest = largest_ball();
    check_balls_fit(largest);
    finder_ = std::make_unique<liner::ContactFinder>(
        *liner_, largest > 0.0 ? largest : mill_fix_->scaled().mill.ball_radius);
    make_patches();
    read_materials();
    ledger_ = first_fix<FixMillLedger>(modify);
    impacts_ = first_fix<FixMillImpacts>(modify);
    loads_ = nullptr;
    for (int i = 0; i < modify->nfix; ++i)
      if (auto* loads = dynamic_cast<FixMillLinerLoads*>(modify->fix[i]))
        if (loads->wall_id() == id) loads_ = loads;
    // Created by the pair style, whose init runs before.
    damping_ = terms_.limited_damping ? first_fix<FixContactDamping>(modify) : nullptr;
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
}

/// Number the patches of liner and ends. A lifter's faces, edges and top are one surface: a ball
/// has one contact with it, which moves around the edges.
void FixWallMill::make_patches()
{
  patches_ = finder_->patches();
  surfaces_.clear();
  for (std::size_t k = 0; k < patches_.size(); ++k) {
    const double key = 1.0 + finder_->surface_of(k);
    surfaces_.push_back({key, mark_of(finder_->profile(), key)});
  }
  if (!ends_) return;
  const double turns = ends_turn_ ? 1.0 : 0.0;
  patches_.push_back({0.0, 0.0, 0.0, 0.0, 1.0, -ends_->low, 0.0, turns});
  patches_.push_back({0.0, 0.0, 0.0, 0.0, -1.0, ends_->high, 0.0, turns});
  surfaces_.push_back({lower_end, on_wall});
  surfaces_.push_back({upper_end, on_wall});
}

void FixWallMill::read_materials()
{
  const auto laws = contact_laws(lmp, style, true, terms_.rolling);
  law_of_type_.clear();
  for (const int wall : {wall_type_, end_type_})
    for (int type = 0; type < atom->ntypes; ++type)
      law_of_type_.push_back(laws[type * atom->ntypes + wall - 1]);
  end_laws_ = end_type_ == wall_type_ ? 0 : atom->ntypes;
}

void FixWallMill::setup(int)
{
  try {
    check_balls_are_inside();
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
  add_forces(0.0);
}

void FixWallMill::post_force(int)
{
  add_forces(update->dt);
}

/// Evaluate the contacts of the engine's balls and add the forces to the engine's arrays.
void FixWallMill::add_forces(double dt)
{
  const auto vectors = [](double** rows) {
    return kernels::BallNumbers{rows ? rows[0] : nullptr, 3};
  };
  const bool limited = damping_ && atom->nlocal > 0;
  const auto& forces =
      evaluate({vectors(atom->x),
                {atom->radius, 1},
                vectors(atom->v),
                {atom->rmass, 1},
                vectors(atom->omega),
                limited ? kernels::BallSums(&damping_->of_ball(0), 1) : kernels::BallSums()},
               dt);
  const std::size_t count = forces.size();
  for (std::size_t k = 0; k < count; ++k) {
    if (k + ahead < count) {
      const int next = static_cast<int>(forces[k + ahead].ball);
      __builtin_prefetch(atom->f[next], 1);
      __builtin_prefetch(atom->torque[next], 1);
    }
    const kernels::WallForce& on_ball = forces[k];
    const int i = static_cast<int>(on_ball.ball);
    for (int d = 0; d < 3; ++d) atom->f[i][d] += on_ball.force[d];
    for (int d = 0; d < 3; ++d) atom->torque[i][d] += on_ball.torque[d];
    if (limited) damping_->of_ball(i) += on_ball.damping;
  }
}

/// The wall's directions turn with the mill: in them the liner is at rest.
kernels::WallFrame FixWallMill::frame_now() const
{
  const millscale::MillFrame& mill = mill_fix_->frame();
  const millscale::Turn turn(mill_fix_->mill_angle());
  // As liner::section has it, x and z point against the mill's own directions.
  const millscale::MillPoint x{-1.0, 0.0, 0.0}, z{0.0, -1.0, 0.0};
  const Vector& axis = mill.axis();
  const double speed = mill_fix_->speed_now();
  return {millscale::vector3(mill.origin()),
          millscale::vector3(mill.vector(x.in_space(turn))),
          millscale::vector3(mill.vector(z.in_space(turn))),
          millscale::vector3(axis),
          {speed * axis[0], speed * axis[1], speed * axis[2]}};
}

const std::vector<kernels::WallForce>& FixWallMill::evaluate(const kernels::WallInput& input,
                                                             double dt)
{
  task_.balls = input;
  task_.frame = frame_now();
  task_.patches = patches_.data();
  task_.laws = law_of_type_.data();
  task_.terms = terms_;
  task_.damping_of_balls = damping_ != nullptr;
  task_.dt = dt;
  std::fill(std::begin(on_wall_), std::end(on_wall_), 0.0);
  torque_on_turning_ = torque_on_ends_ = {};
  forces_.clear();
  find_near();
  batch_.count = 0;
  records_ = loads_ && loads_->begin_step(dt);
  const kernels::NearBalls near = near_.view();
  if (near.count > 0) fetch_ahead(0);
  for (int b = 0; b * block < near.count; ++b) {
    if ((b + 1) * block < near.count) fetch_ahead(b + 1);
    const std::uint64_t moved = kernels_->moved(task_, near, b * block);
    for (std::uint64_t left = moved | near_.tracks[b]; left != 0; left &= left - 1) {
      const int k = __builtin_ctzll(left);
      look_at(b * block + k, moved >> k & 1);
    }
  }
  evaluate_batch();
  return forces_;
}

/// Prefetch the scattered data of a block of balls while another block is evaluated.
void FixWallMill::fetch_ahead(int b) const
{
  const int begin = b * block, end = std::min(begin + block, near_.count);
  for (int k = begin; k < end; ++k) __builtin_prefetch(task_.balls.position[near_.ball[k]]);
  for (std::uint64_t left = near_.tracks[b]; left != 0; left &= left - 1) {
    const int i = near_.ball[begin + __builtin_ctzll(left)];
    __builtin_prefetch(task_.balls.velocity[i]);
    __builtin_prefetch(task_.balls.spin[i]);
    __builtin_prefetch(row(i), 1);
    if (impacts_) impacts_->prefetch_wall(i);
  }
}

/// List the balls that may touch the wall or did; most balls of a mill do neither. Between two
/// neighbour lists no ball moves by more than half the skin, if the engine checks displacements. So
/// balls farther from liner and ends are checked only at the next list.
void FixWallMill::find_near()
{
  const bool sorted_anew = neighbor->ago == 0 || static_cast<int>(touching_.size()) != atom->nlocal;
  const bool engine_watches =
      neighbor->dist_check && neighbor->every == 1 && neighbor->delay == 0 && neighbor->skin > 0.0;
  if (sorted_anew) count_touching();
  if (!sorted_anew && engine_watches) return;
  const double margin = engine_watches ? 0.5 * neighbor->skin : 0.0;
  const double low = ends_ ? ends_->low + margin : -INFINITY;
  const double high = ends_ ? ends_->high - margin : INFINITY;
  const double clear = liner_->clear_radius() - margin;
  near_.clear();
  task_.only_law = -1;
  for (int i = 0; i < atom->nlocal; ++i) {
    const double radius = *task_.balls.radius[i], reach = std::max(0.0, clear - radius);
    const auto arm = millscale::vector3(task_.balls.position[i]) - task_.frame.origin;
    const double along = dot(arm, task_.frame.axis);
    const bool clear_of_liner = dot(arm, arm) - along * along < reach * reach;
    const bool clear_of_ends = along - radius > low && along + radius < high;
    if (clear_of_liner && clear_of_ends && touching_[i] == 0) continue;
    if (atom->mask[i] & groupbit) near_.add(i);
  }
  near_.end();
  const auto same_type = [this](int i) { return atom->type[i] == atom->type[near_.ball[0]]; };
  const auto end = near_.ball.begin() + near_.count;
  if (near_.count > 0 && end_laws_ == 0 && std::all_of(near_.ball.begin(), end, same_type))
    task_.only_law = atom->type[near_.ball[0]] - 1;
}

void FixWallMill::Near::clear()
{
  count = 0;
  for (auto* numbers : {&ball, &sector, &patch, &second}) numbers->clear();
}

/// Add a ball that has not been searched.
void FixWallMill::Near::add(int i)
{
  ball.push_back(i);
  ++count;
}

void FixWallMill::Near::end()
{
  sector.assign(count, -1);
  patch.assign(count, none);
  second.assign(count, none);
  tracks.assign((count + block - 1) / block, 0);
  const int padded = (count + block - 1) / block * block;
  ball.resize(padded, count > 0 ? ball[0] : 0);
  for (auto* numbers : {&x, &z, &along, &clear2}) numbers->assign(padded, 0.0);
}

kernels::NearBalls FixWallMill::Near::view() const
{
  return {ball.data(), x.data(), z.data(), along.data(), clear2.data(), count};
}

/// Return the key and the displacement of a ball's contact.
double* FixWallMill::slot(int i, int contact) const
{
  return contact == 0 ? row(i) : rest(i) + (contact - 1) * slot_size;
}

void FixWallMill::count_touching()
{
  touching_.assign(atom->nlocal, 0);
  for (int i = 0; i < atom->nlocal; ++i) {
    for (int s = 0; s < slots && slot(i, s)[0] != 0.0; ++s)
      touching_[i] |= static_cast<signed char>(mark_of(finder_->profile(), slot(i, s)[0]) |
                                               (s > 0 ? several : 0));
  }
}

/// Add the contacts of a ball to the batch. If the ball has moved too far since its last search,
/// search it.
void FixWallMill::look_at(int entry, bool moved)
{
  const int i = near_.ball[entry];
  if (batch_.count + slots > kernels::WallBatch::most) evaluate_batch();
  if (!moved) {
    add_contact(i, near_.patch[entry]);
    if (near_.second[entry] != none) add_contact(i, near_.second[entry]);
    return;
  }
  const double radius = *task_.balls.radius[i];
  const auto arm = millscale::vector3(task_.balls.position[i]) - task_.frame.origin;
  const liner::Point centre{dot(arm, task_.frame.x), dot(arm, task_.frame.z)};
  const double along = dot(arm, task_.frame.axis);
  liner::Found found = finder_->find(centre, radius, near_.sector[entry]);
  int patch[slots] = {none}, count = found.count;
  std::copy(found.patch.begin(), found.patch.begin() + count, patch);
  double clear = found.clear;
  if (ends_) {
    const auto touch = [&](double overlap, int end) {
      if (overlap > 0.0)
        patch[count++] = static_cast<int>(patches_.size()) - 2 + end;
      else
        clear = std::min(clear, -overlap);
    };
    touch(ends_->lower_overlap(along, radius), 0);
    touch(ends_->upper_overlap(along, radius), 1);
  }
  if (count > 2) clear = 0.0;
  near_.x[entry] = centre.x;
  near_.z[entry] = centre.z;
  near_.along[entry] = along;
  near_.clear2[entry] = clear * clear;
  near_.patch[entry] = patch[0];
  near_.second[entry] = count == 2 ? patch[1] : none;
  const std::uint64_t bit = std::uint64_t{1} << entry % block;
  std::uint64_t& tracks = near_.tracks[entry / block];
  tracks = count > 0 ? tracks | bit : tracks & ~bit;
  for (int c = 0; c < count; ++c) add_contact(i, patch[c]);
  if (count == 0 && touching_[i] != 0) store_history(i, 0, 0);
}

void FixWallMill::add_contact(int i, int patch)
{
  const int k = batch_.count++;
  batch_.ball[k] = i;
  batch_.patch[k] = patch;
  const double key = surfaces_[patch].key;
  batch_.law[k] =
      task_.only_law >= 0 ? task_.only_law : atom->type[i] - 1 + (key < 0.0 ? end_laws_ : 0);
  int s = 0;
  const int before = touching_[i] & several ? slots : 1;
  while (s < before && slot(i, s)[0] != key) ++s;
  const double* displacement = s < before ? slot(i, s) + 1 : nullptr;
  for (int d = 0; d < 3; ++d) batch_.displacement[d][k] = displacement ? displacement[d] : 0.0;
  slot_before_[k] = displacement ? s : none;
}

/// Evaluate the contacts of the batch, store their histories and list their forces.
void FixWallMill::evaluate_batch()
{
  if (batch_.count == 0) return;
  (impacts_ ? kernels_->evaluate_recorded : kernels_->evaluate)(task_, batch_);
  const bool moves = task_.dt > 0.0;
  for (int k = 0; k < batch_.count;) {
    const int i = batch_.ball[k], begin = k;
    for (; k < batch_.count && batch_.ball[k] == i; ++k) {
      if (!(batch_.overlap[k] > 0.0)) continue;
      kernels::WallForce& on_ball = forces_.emplace_back();
      on_ball.ball = i;
      on_ball.damping = damping_ && moves ? batch_.damping[k] : 0.0;
      const double turns = patches_[batch_.patch[k]].turns;
      const double of_end = surfaces_[batch_.patch[k]].key < 0.0 ? 1.0 : 0.0;
      for (int d = 0; d < 3; ++d) {
        on_ball.force[d] = batch_.force[d][k];
        on_ball.torque[d] = batch_.torque[d][k];
        on_wall_[d] -= batch_.force[d][k];
        on_wall_[3 + d] -= batch_.moment[d][k];
        torque_on_turning_[d] -= turns * batch_.moment[d][k];
        torque_on_ends_[d] -= of_end * batch_.moment[d][k];
      }
      if (ledger_ || records_) add_to_sums(k);
    }
    store_history(i, begin, k);
  }
  batch_.count = 0;
}

/// Store the histories of a ball's contacts, begin to end in the batch.
void FixWallMill::store_history(int i, int begin, int end)
{
  const int before = touching_[i] & several ? slots : 1;
  if (impacts_)
    impacts_->record_wall(i, {batch_, begin, end, slot_before_, before, task_.balls.velocity[i],
                              task_.balls.spin[i], task_.dt});
  signed char contacts = 0;
  int count = 0;
  for (int k = begin; k < end; ++k) {
    if (!(batch_.overlap[k] > 0.0)) continue;
    const Surface& surface = surfaces_[batch_.patch[k]];
    contacts |= static_cast<signed char>(surface.mark | (count > 0 ? several : 0));
    double* history = slot(i, count++);
    *history++ = surface.key;
    for (int d = 0; d < 3; ++d) *history++ = batch_.stretch[d][k];
  }
  for (; count < before; ++count) std::fill_n(slot(i, count), slot_size, 0.0);
  touching_[i] = contacts;
}

/// Add contact k of the batch to the energy budget and to the loads of the liner. The kernels do
/// not evaluate the parts of a force, but the law gives the same bits here.
void FixWallMill::add_to_sums(int k)
{
  const int i = batch_.ball[k];
  const liner::Patch& patch = patches_[batch_.patch[k]];
  const auto vector = [](const double* v) { return millscale::vector3(v); };
  const auto of_batch = [k](const double(&columns)[3][kernels::WallBatch::most]) {
    return millscale::Vector3<double>{columns[0][k], columns[1][k], columns[2][k]};
  };
  const kernels::BallMotion<double> ball{*task_.balls.radius[i], *task_.balls.mass[i],
                                         vector(task_.balls.velocity[i]),
                                         vector(task_.balls.spin[i])};
  const auto touch =
      kernels::on_patch(task_.frame, patch, vector(task_.balls.position[i]), ball.radius);
  const bool moves = task_.dt > 0.0;
  const auto on_wall = kernels::contact_of(task_.frame, touch, patch.turns, ball,
                                           of_batch(batch_.displacement), batch_.damping_share[k]);
  const auto result =
      contact::contact_force(on_wall, law_of_type_[batch_.law[k]], terms_, task_.dt, moves);
  const contact::EvaluatedContact evaluated(on_wall, result);
  const bool begins = slot_before_[k] == none && moves;
  if (records_) {
    const millscale::Vector3<double> arm = touch.arm;
    const liner::Point centre{dot(arm, task_.frame.x), dot(arm, task_.frame.z)};
    const double torque = -dot(of_batch(batch_.moment), task_.frame.axis);
    loads_->add(atom->type[i], batch_.patch[k], centre,
                loads_of(on_wall, result, evaluated, task_.frame.axis, torque, task_.dt, begins));
  }
  if (!ledger_) return;
  millscale::energy::ContactSums& sums = ledger_->on_wall();
  sums.store(evaluated, 1.0, moves);
  const auto spin = patch.turns * task_.frame.spin;
  sums.add_wall(i, evaluated, millscale::to_array(spin),
                millscale::to_array(cross(spin, touch.arm)));
  if (begins) sums.begin_contact(evaluated.approach_energy(), 1.0);
}

void FixWallMill::mark_contacts(std::vector<signed char>& marks, signed char wall,
                                signed char groove) const
{
  // Through pointers: bytes may alias the vectors, which would be read anew for each ball.
  signed char* const to = marks.data();
  const signed char* const from = touching_.data();
  const std::size_t count = marks.size();
  for (std::size_t i = 0; i < count; ++i)
    to[i] |= (from[i] ? wall : 0) | (from[i] & on_groove ? groove : 0);
}

double FixWallMill::compute_vector(int k)
{
  double all = 0.0;
  MPI_Allreduce(&on_wall_[k], &all, 1, MPI_DOUBLE, MPI_SUM, world);
  return all;
}

/// Check that the liner and its ends lie in the box. Shrink-wrapped sides are not checked.
void FixWallMill::check_box() const
{
  const Vector &axis = mill_fix_->axis(), &origin = mill_fix_->origin();
  for (int d = 0; d < 3; ++d) {
    const bool crosses = std::abs(axis[d]) < 1e-9;
    if (!crosses && !ends_) continue;  // endless in this direction
    const double across = liner_->radius() * std::sqrt(std::max(0.0, 1.0 - axis[d] * axis[d]));
    const double one = ends_ ? axis[d] * ends_->low : 0.0,
                 other = ends_ ? axis[d] * ends_->high : 0.0;
    const double low = origin[d] - across + std::min(one, other);
    const double high = origin[d] + across + std::max(one, other);
    const double box_low = domain->boxlo[d], box_high = domain->boxhi[d];
    // A box of the mill's length may differ from it by rounding.
    const double rounding = 1e-12 * (box_high - box_low);
    const bool below = low < box_low - rounding && domain->boundary[d][0] < 2;
    const bool above = high > box_high + rounding && domain->boundary[d][1] < 2;
    if (below || above)
      throw std::invalid_argument(
          std::string(crosses ? "the liner" : "the ends of the mill") + " must lie in the box, " +
          format(box_low) + " to " + format(box_high) + " m in " + "xyz"[d] + ", got " +
          format(low) + " to " + format(high) +
          " m; enlarge the box (command region) or check the mill's radius, origin and ends");
  }
}

/// Radius of the largest ball of all ranks [m].
double FixWallMill::largest_ball() const
{
  double largest = 0.0;
  for (int i = 0; i < atom->nlocal; ++i)
    if (atom->mask[i] & groupbit) largest = std::max(largest, atom->radius[i]);
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, world);
  return largest;
}

/// Check that the largest ball fits into groove, drum and the length between the ends.
void FixWallMill::check_balls_fit(double largest) const
{
  const auto require = [largest](double widest, const std::string& where) {
    if (largest >= widest)
      throw std::invalid_argument("balls of radius " + format(largest) + " m do not fit: " + where +
                                  " takes less than " + format(widest) + " m");
  };
  require(0.5 * liner::narrowest_width(*liner_),
          liner_->sectors() > 1 ? "the groove of the liner" : "the drum");
  if (ends_ && 2.0 * largest > ends_->high - ends_->low)
    throw std::invalid_argument("balls of radius " + format(largest) +
                                " m do not fit between the ends, " +
                                format(ends_->high - ends_->low) + " m apart");
}

/// Check that no ball's centre lies in the wall or beyond an end: no force returns such a ball.
void FixWallMill::check_balls_are_inside() const
{
  const millscale::MillFrame& frame = mill_fix_->frame();
  const millscale::Turn turn(mill_fix_->mill_angle());
  int outside = 0, first = MAXTAGINT;
  Vector place{};
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!(atom->mask[i] & groupbit)) continue;
    const millscale::MillPoint p = frame.point(atom->x[i]).in_turning_frame(turn);
    if (liner::inside(*liner_, liner::section(p)) &&
        !(ends_ && (p.along < ends_->low || p.along > ends_->high)))
      continue;
    ++outside;
    if (atom->tag[i] >= first) continue;
    first = atom->tag[i];
    place = {atom->x[i][0], atom->x[i][1], atom->x[i][2]};
  }
  const int of_this_rank = first;
  MPI_Allreduce(MPI_IN_PLACE, &outside, 1, MPI_INT, MPI_SUM, world);
  if (outside == 0) return;
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, world);
  if (of_this_rank != first) place = {};
  MPI_Allreduce(MPI_IN_PLACE, place.data(), 3, MPI_DOUBLE, MPI_SUM, world);
  throw std::invalid_argument(
      "balls with their centre outside the liner: " + std::to_string(outside) + ", first ball " +
      std::to_string(first) + " at (" + format(place[0]) + ", " + format(place[1]) + ", " +
      format(place[2]) + ") m; check the liner, its phase and ends, and the mill's origin");
}
