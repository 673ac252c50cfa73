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
#include "core/contact/damping_limit.h"
#include "core/liner/groove_box.h"
#include "core/liner/nearest.h"
#include "liggghts/common/contact_laws.h"
#include "liggghts/common/first_fix.h"
#include "liggghts/common/keywords.h"
#include "liggghts/common/one_per_ball.h"
#include "liggghts/energy/fix_mill_ledger.h"
#include "liggghts/mill/fix_mill_similarity.h"
#include "liggghts/mill/mill_of.h"
#include "liggghts/pair/fix_contact_damping.h"
#include "liggghts/wall/style_liner.h"

using namespace LAMMPS_NS;
using namespace FixConst;
namespace contact = millscale::contact;
namespace liner = millscale::liner;
using millscale::format;
using millscale::Vector;

namespace {

constexpr int slots = liner::Contacts::most + 2;  // liner, two ends
constexpr int slot_size = 4;                      // key, tangential displacement
constexpr int history_size = slots * slot_size;

constexpr std::size_t ahead = 4;  // prefetch distance in balls

/// Key of a surface, which identifies the history of a contact; 0 is no contact. A lifter's faces,
/// edges and top are one surface. A ball has one contact with this surface, which moves around the
/// edges.
double key_of(const liner::Contact& contact)
{
  return 1.0 + contact.surface;
}
constexpr double lower_end = -1.0, upper_end = -2.0;

bool is_groove(const liner::Profile& profile, double key)
{
  return key > 0.0 && profile.is_groove(static_cast<int>(key) - 1);
}

/// Bits of the surfaces in contact with a ball.
constexpr signed char on_groove = 1, on_wall = 2;

Vector displacement_of(double key, const double* row)
{
  for (int s = 0; s < slots; ++s, row += slot_size)
    if (row[0] == key) return {row[1], row[2], row[3]};
  return {};
}

bool holds(double key, const double* row)
{
  for (int s = 0; s < slots; ++s, row += slot_size)
    if (row[0] == key) return true;
  return false;
}

}  // namespace

FixWallMill::FixWallMill(LAMMPS* lmp, int narg, char** arg)
    : FixPerBallRows(lmp, narg, arg, history_size)
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
      .choice("rolling_friction", "cdt", "off", terms_.rolling)
      .choice("tangential_damping", "bounded", "on", terms_.limited_damping)
      .parse({narg, arg, 3});
  if (wall_type_ < 1 || wall_type_ > atom->ntypes)
    throw std::invalid_argument("type: the wall's atom type must be 1 to " +
                                std::to_string(atom->ntypes) + ", got " +
                                std::to_string(wall_type_));
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
    read_materials();
    ledger_ = first_fix<FixMillLedger>(modify);
    // Created by the pair style, whose init runs before.
    damping_ = terms_.limited_damping ? first_fix<FixContactDamping>(modify) : nullptr;
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
}

void FixWallMill::read_materials()
{
  const auto laws = contact_laws(lmp, style, true, terms_.rolling);
  law_of_type_.clear();
  for (int type = 0; type < atom->ntypes; ++type)
    law_of_type_.push_back(laws[type * atom->ntypes + wall_type_ - 1]);
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
  const auto vectors = [](double** rows) { return BallVectors{rows ? rows[0] : nullptr, 3}; };
  const bool limited = damping_ && atom->nlocal > 0;
  const WallInput input{vectors(atom->x), vectors(atom->v), vectors(atom->omega),
                        limited ? BallNumbers(&damping_->of_ball(0), 1) : BallNumbers()};
  const std::vector<WallForce>& forces = evaluate(input, dt);
  const std::size_t count = forces.size();
  for (std::size_t k = 0; k < count; ++k) {
    if (k + ahead < count) {
      __builtin_prefetch(atom->f[forces[k + ahead].ball], 1);
      __builtin_prefetch(atom->torque[forces[k + ahead].ball], 1);
    }
    const WallForce& on_ball = forces[k];
    const int i = on_ball.ball;
    for (int d = 0; d < 3; ++d) atom->f[i][d] += on_ball.force[d];
    for (int d = 0; d < 3; ++d) atom->torque[i][d] += on_ball.torque[d];
    if (limited) damping_->of_ball(i) += on_ball.damping;
  }
}

FixWallMill::MillNow FixWallMill::mill_now() const
{
  const Vector& axis = mill_fix_->axis();
  const double speed = mill_fix_->speed_now();
  return {mill_fix_->frame(),
          millscale::Turn(mill_fix_->mill_angle()),
          {speed * axis[0], speed * axis[1], speed * axis[2]}};
}

const std::vector<WallForce>& FixWallMill::evaluate(const WallInput& input, double dt)
{
  const MillNow mill = mill_now();
  std::fill(std::begin(on_wall_), std::end(on_wall_), 0.0);
  torque_on_turning_ = {};
  forces_.clear();
  find_near(input, mill);
  const std::size_t count = near_.size();
  for (std::size_t k = 0; k < count; ++k) {
    if (k + ahead < count) fetch_ahead(input, near_[k + ahead]);
    look_at(input, near_[k], mill, dt);
  }
  return forces_;
}

/// Prefetch the scattered data of a ball while other balls are evaluated.
void FixWallMill::fetch_ahead(const WallInput& input, const Near& near) const
{
  const int i = near.ball;
  __builtin_prefetch(input.position[i]);
  if (near.clear > 0.0) return;
  __builtin_prefetch(input.velocity[i]);
  __builtin_prefetch(input.spin[i]);
  for (int k = 0; k < history_size; k += 8) __builtin_prefetch(row(i) + k, 1);
}

/// List the balls that may touch the wall or did; most balls of a mill do neither. Between two
/// neighbour lists no ball moves by more than half the skin, if the engine checks displacements. So
/// balls farther from liner and ends are checked only at the next list.
void FixWallMill::find_near(const WallInput& input, const MillNow& mill)
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
  for (int i = 0; i < atom->nlocal; ++i) {
    const double radius = atom->radius[i], reach = std::max(0.0, clear - radius);
    const Vector arm = mill.frame.arm(input.position[i]);
    const double along = millscale::dot(arm, mill.frame.axis());
    const bool clear_of_liner = millscale::dot(arm, arm) - along * along < reach * reach;
    const bool clear_of_ends = along - radius > low && along + radius < high;
    if (clear_of_liner && clear_of_ends && touching_[i] == 0) continue;
    if (atom->mask[i] & groupbit) near_.push_back({i, {}, {}, 0.0, 0.0});
  }
}

void FixWallMill::count_touching()
{
  touching_.assign(atom->nlocal, 0);
  for (int i = 0; i < atom->nlocal; ++i)
    for (int s = 0; s < slots && row(i)[s * slot_size] != 0.0; ++s)
      touching_[i] |= is_groove(*liner_, row(i)[s * slot_size]) ? on_groove : on_wall;
}

/// Contacts of a ball with liner and ends, at most `slots`.
struct FixWallMill::Contacts {
  int count = 0;
  Contact contact[slots];

  void add(const Contact& c) { contact[count++] = c; }
};

/// In the turning frame the liner is at rest. A ball cannot touch the liner until it has moved by
/// the distance of its last check.
void FixWallMill::look_at(const WallInput& input, Near& near, const MillNow& mill, double dt)
{
  const int i = near.ball;
  const Vector arm = mill.frame.arm(input.position[i]);
  const millscale::MillPoint p = mill.frame.components(arm).in_turning_frame(mill.turn);
  const liner::Point centre = liner::section(p), way = centre - near.seen;
  const double along = p.along, rise = along - near.along;
  if (way.x * way.x + way.z * way.z + rise * rise < near.clear * near.clear) return;

  const double radius = atom->radius[i];
  near.seen = centre;
  near.along = along;
  Contacts found;
  touch_liner(mill, near, radius, found);
  near.clear = near.last.clear;
  if (ends_) touch_ends(mill, near, radius, found);
  if (found.count > 0) near.clear = 0.0;
  if (found.count > 0 || touching_[i] != 0) press_all(input, i, mill, arm, found, dt);
}

void FixWallMill::touch_liner(const MillNow& mill, Near& near, double radius, Contacts& found) const
{
  const liner::Contacts contacts = finder_->contacts(near.seen, radius, near.last);
  for (int c = 0; c < contacts.count; ++c) {
    const liner::Contact& touch = contacts.contact[c];
    Contact contact{touch.overlap, {}, key_of(touch), true};
    const millscale::MillPoint normal{-touch.normal.x, -touch.normal.z, 0.0};
    contact.normal = mill.frame.vector(normal.in_space(mill.turn));
    found.add(contact);
  }
}

void FixWallMill::touch_ends(const MillNow& mill, Near& near, double radius, Contacts& found) const
{
  const auto touch = [&](double overlap, double direction, double key) {
    near.clear = std::min(near.clear, -overlap);
    if (!(overlap > 0.0)) return;
    Contact contact{overlap, {}, key, ends_turn_};
    for (int d = 0; d < 3; ++d) contact.normal[d] = direction * mill.frame.axis()[d];
    found.add(contact);
  };
  touch(ends_->lower_overlap(near.along, radius), 1.0, lower_end);
  touch(ends_->upper_overlap(near.along, radius), -1.0, upper_end);
}

/// Evaluate a ball's contacts with the histories in the ball's row, and store the new histories.
void FixWallMill::press_all(const WallInput& input, int i, const MillNow& mill, const Vector& arm,
                            Contacts& found, double dt)
{
  double* history = row(i);
  double next[history_size] = {};
  const double share = terms_.limited_damping ? damping_share(input, i, found, dt) : 0.0;
  touching_[i] = 0;
  for (int c = 0; c < found.count; ++c) {
    const double key = found.contact[c].key;
    Vector displacement = displacement_of(key, history);
    if (ledger_) found.contact[c].continued = holds(key, history);
    press(input, i, mill, arm, found.contact[c], dt, displacement, share);
    next[c * slot_size] = key;
    touching_[i] |= is_groove(*liner_, key) ? on_groove : on_wall;
    std::copy(displacement.begin(), displacement.end(), next + c * slot_size + 1);
  }
  std::copy(next, next + history_size, history);
}

const contact::ContactLaw<double>& FixWallMill::law_of(int i) const
{
  return law_of_type_[atom->type[i] - 1];
}

/// Return the ball's contribution to the divisor of the tangential damping of its contacts with the
/// wall. The sum is over all contacts of the ball. The pair style has just stored the sum over
/// contacts with balls; this adds the contacts with the wall.
double FixWallMill::damping_share(const WallInput& input, int i, const Contacts& found,
                                  double dt) const
{
  const contact::ContactLaw<double>& law = law_of(i);
  double damping = damping_ ? input.damping[i] : 0.0;
  for (int c = 0; c < found.count; ++c) {
    const double a = contact::contact_radius(atom->radius[i], found.contact[c].overlap);
    damping += law.tangential_damping * contact::damping_scale(a, atom->rmass[i]);
  }
  return contact::damping_share(damping, atom->rmass[i], dt);
}

void FixWallMill::press(const WallInput& input, int i, const MillNow& mill, const Vector& arm,
                        const Contact& contact, double dt, Vector& displacement,
                        double damping_share)
{
  const double radius = atom->radius[i];
  contact::BallOnWall touch{contact.normal, contact.overlap, radius, atom->rmass[i], {}, {},
                            displacement,   damping_share};
  Vector lever;
  for (int d = 0; d < 3; ++d) lever[d] = arm[d] - (radius - contact.overlap) * contact.normal[d];
  const Vector wall_velocity = contact.turns ? millscale::cross(mill.omega, lever) : Vector{};
  for (int d = 0; d < 3; ++d) {
    touch.velocity[d] = input.velocity[i][d] - wall_velocity[d];
    touch.spin[d] = input.spin[i][d];
  }
  const auto on_wall = contact::contact_of(touch);
  const auto result = contact::contact_force(on_wall, law_of(i), terms_, dt, dt > 0.0);
  displacement = millscale::to_array(result.displacement);
  const Vector force = millscale::to_array(result.force);
  const Vector torque = millscale::to_array(result.torque_i);
  // Total change of the ball's angular momentum about the mill's origin, its own spin included.
  Vector moment = millscale::cross(arm, force);
  for (int d = 0; d < 3; ++d) moment[d] += torque[d];
  for (int d = 0; d < 3; ++d) {
    on_wall_[d] -= force[d];
    on_wall_[3 + d] -= moment[d];
    if (contact.turns) torque_on_turning_[d] -= moment[d];
  }
  const double damping = damping_ && dt > 0.0 ? result.damping : 0.0;
  forces_.push_back(
      {i, {force[0], force[1], force[2]}, {torque[0], torque[1], torque[2]}, damping});
  if (!ledger_) return;
  const contact::EvaluatedContact evaluated(on_wall, result);
  millscale::energy::ContactSums& sums = ledger_->on_wall();
  sums.store(evaluated, 1.0, dt > 0.0);
  const Vector spin = contact.turns ? mill.omega : Vector{};
  sums.add_wall(i, evaluated, spin, millscale::cross(spin, arm));
  if (!contact.continued && dt > 0.0) sums.begin_contact(evaluated.approach_energy(), 1.0);
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
  const MillNow mill = mill_now();
  int outside = 0, first = MAXTAGINT;
  Vector place{};
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!(atom->mask[i] & groupbit)) continue;
    const millscale::MillPoint p = mill.frame.point(atom->x[i]).in_turning_frame(mill.turn);
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
