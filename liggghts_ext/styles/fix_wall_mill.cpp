#include "fix_wall_mill.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "argument_list.h"
#include "atom.h"
#include "error.h"
#include "fix_mill_similarity.h"
#include "fix_property_global.h"
#include "modify.h"
#include "update.h"

using namespace LAMMPS_NS;
using namespace FixConst;
namespace contact = millscale::contact;
namespace liner = millscale::liner;
using millscale::Vector;

namespace {

constexpr int slots = 4;      // groove, two sides, top
constexpr int slot_size = 4;  // key, tangential displacement
constexpr int memory_size = slots * slot_size;

/// Names a surface of the liner, so that a touch finds its memory again; 0 is no touch.
double key_of(const liner::Touch& touch)
{
  return 1.0 + static_cast<int>(touch.face) + 4.0 * touch.sector;
}

bool is_groove(double key)
{
  return std::fmod(key - 1.0, 4.0) == static_cast<int>(liner::Face::groove);
}

Vector memory_of(double key, const double* row)
{
  for (int s = 0; s < slots; ++s, row += slot_size)
    if (row[0] == key) return {row[1], row[2], row[3]};
  return {};
}

}  // namespace

FixWallMill::FixWallMill(LAMMPS* lmp, int narg, char** arg)
    : FixPerBallRows(lmp, narg, arg, memory_size)
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
  millscale::ArgumentList list(narg, arg, 3);
  while (!list.done()) {
    const std::string key = list.word("a keyword");
    if (key == "mill")
      mill_id_ = list.word(key);
    else if (key == "type")
      wall_type_ = list.count(key);
    else if (key == "lifters")
      widths_.lifters = list.count(key);
    else if (key == "lifter_top_radius")
      widths_.lifter_top_radius = list.number(key);
    else if (key == "lifter_top_width")
      widths_.lifter_top_width = list.number(key);
    else if (key == "groove_width")
      widths_.groove_width = list.number(key);
    else if (key == "phase")
      widths_.phase = list.number(key);
    else if (key == "rolling_friction")
      rolling_ = list.choice(key, "cdt", "off");
    else
      throw std::invalid_argument("unknown keyword '" + key +
                                  "'; accepted are mill, type, lifters, lifter_top_radius, "
                                  "lifter_top_width, groove_width, phase, rolling_friction");
  }
  if (wall_type_ < 1 || wall_type_ > atom->ntypes)
    throw std::invalid_argument("type: the wall's atom type must be 1 to " +
                                std::to_string(atom->ntypes) + ", got " +
                                std::to_string(wall_type_));
}

void FixWallMill::make_liner()
{
  mill_fix_ = dynamic_cast<FixMillSimilarity*>(modify->find_fix_id(mill_id_.c_str()));
  if (!mill_fix_)
    throw std::invalid_argument("mill: '" + mill_id_ + "' is not the id of a fix mill/similarity");
  widths_.radius = mill_fix_->scaled().mill.radius;
  liner_ = std::make_unique<liner::Liner>(widths_);
}

int FixWallMill::setmask()
{
  return POST_FORCE;
}

void FixWallMill::init()
{
  try {
    make_liner();
    check_balls_fit();
    read_materials();
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
}

void FixWallMill::check_balls_fit()
{
  double largest = 0.0;
  for (int i = 0; i < atom->nlocal; ++i) largest = std::max(largest, atom->radius[i]);
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, world);
  const double widest = 0.5 * (liner_->lifters() > 0 ? liner_->groove_width() : liner_->radius());
  if (largest >= widest)
    throw std::invalid_argument("balls of radius " + millscale::format(largest) +
                                " m do not fit: the groove of the liner takes less than " +
                                millscale::format(widest) + " m");
}

void FixWallMill::read_materials()
{
  const int types = atom->ntypes;
  const auto of_type = [&](const char* name) {
    return static_cast<FixPropertyGlobal*>(
        modify->find_fix_property(name, "property/global", "peratomtype", types, 0, style));
  };
  const auto of_pair = [&](const char* name) {
    auto* fix = static_cast<FixPropertyGlobal*>(
        modify->find_fix_property(name, "property/global", "peratomtypepair", types, types, style));
    return [fix, this](int type) { return fix->compute_array(type, wall_type_ - 1); };
  };
  FixPropertyGlobal *modulus = of_type("youngsModulus"), *poisson = of_type("poissonsRatio");
  const auto restitution = of_pair("coefficientRestitution"),
             sliding = of_pair("coefficientFriction");
  std::vector<double> rolling(types, 0.0);
  if (rolling_) {
    const auto value = of_pair("coefficientRollingFriction");
    for (int t = 0; t < types; ++t) rolling[t] = value(t);
  }
  const auto material = [&](int t) {
    return contact::Material{modulus->compute_vector(t), poisson->compute_vector(t), 1.0};
  };
  of_type_.clear();
  for (int t = 0; t < types; ++t)
    of_type_.push_back({contact::effective_youngs_modulus(material(t), material(wall_type_ - 1)),
                        contact::effective_shear_modulus(material(t), material(wall_type_ - 1)),
                        contact::damping_factor(restitution(t)),
                        {sliding(t), rolling[t]}});
}

void FixWallMill::setup(int)
{
  evaluate(0.0);
}

void FixWallMill::post_force(int)
{
  evaluate(update->dt);
}

FixWallMill::MillNow FixWallMill::mill_now() const
{
  MillNow mill{};
  mill.axis = mill_fix_->axis();
  mill.down = mill_fix_->down();
  mill.origin = mill_fix_->origin();
  mill.across = millscale::cross(mill.axis, mill.down);
  mill.cosine = std::cos(mill_fix_->mill_angle());
  mill.sine = std::sin(mill_fix_->mill_angle());
  for (int d = 0; d < 3; ++d) mill.omega[d] = mill_fix_->speed_now() * mill.axis[d];
  return mill;
}

void FixWallMill::evaluate(double dt)
{
  const MillNow mill = mill_now();
  std::fill(std::begin(on_wall_), std::end(on_wall_), 0.0);
  for (int i = 0; i < atom->nlocal; ++i)
    if (atom->mask[i] & groupbit) evaluate_ball(i, mill, dt);
}

void FixWallMill::evaluate_ball(int i, const MillNow& mill, double dt)
{
  Vector arm;
  for (int d = 0; d < 3; ++d) arm[d] = atom->x[i][d] - mill.origin[d];
  const double below = millscale::dot(arm, mill.down), ahead = millscale::dot(arm, mill.across);
  const double radius = atom->radius[i];
  const double reach =
      (widths_.lifters > 0 ? liner_->lifter_top_radius() : liner_->radius()) - radius;
  double* memory = row(i);
  if (reach > 0.0 && below * below + ahead * ahead < reach * reach) {
    for (int s = 0; s < slots; ++s) memory[s * slot_size] = 0.0;
    return;
  }
  // Into the frame of the mill at rest: x = -ahead, z = -below, turned back by the mill's angle.
  const liner::Point at_rest{-(ahead * mill.cosine - below * mill.sine),
                             -(below * mill.cosine + ahead * mill.sine)};
  const liner::Touches found = liner::touches(*liner_, at_rest, radius);

  double next[memory_size] = {};
  const BallOnWall& law = of_type_[atom->type[i] - 1];
  const contact::Pair pair{radius, atom->rmass[i], law.youngs_modulus, law.shear_modulus,
                           law.damping};
  for (int t = 0; t < found.count; ++t) {
    const liner::Touch& touch = found.touch[t];
    const double n_ahead = -touch.normal.x * mill.cosine - touch.normal.z * mill.sine;
    const double n_below = touch.normal.x * mill.sine - touch.normal.z * mill.cosine;
    contact::WallTouch wall{radius, touch.overlap, {}, {}, {}};
    Vector lever;
    for (int d = 0; d < 3; ++d) {
      wall.normal[d] = n_ahead * mill.across[d] + n_below * mill.down[d];
      wall.spin[d] = atom->omega[i][d];
      lever[d] = arm[d] - (radius - touch.overlap) * wall.normal[d];
    }
    const Vector wall_velocity = millscale::cross(mill.omega, lever);
    for (int d = 0; d < 3; ++d) wall.velocity[d] = atom->v[i][d] - wall_velocity[d];

    Vector displacement = memory_of(key_of(touch), memory);
    const contact::ForceAndTorque on_ball =
        contact::wall_force(pair, law.friction, wall, dt, displacement);
    const Vector moment = millscale::cross(lever, on_ball.force);
    for (int d = 0; d < 3; ++d) {
      atom->f[i][d] += on_ball.force[d];
      atom->torque[i][d] += on_ball.torque[d];
      on_wall_[d] -= on_ball.force[d];
      on_wall_[3 + d] -= moment[d];
      next[t * slot_size + 1 + d] = displacement[d];
    }
    next[t * slot_size] = key_of(touch);
  }
  std::copy(next, next + memory_size, memory);
}

void FixWallMill::contacts(int i, bool& wall, bool& on_liner) const
{
  for (int s = 0; s < slots; ++s) {
    const double key = row(i)[s * slot_size];
    if (key == 0.0) continue;
    wall = true;
    on_liner = on_liner || is_groove(key);
  }
}

double FixWallMill::compute_vector(int k)
{
  double all = 0.0;
  MPI_Allreduce(&on_wall_[k], &all, 1, MPI_DOUBLE, MPI_SUM, world);
  return all;
}
