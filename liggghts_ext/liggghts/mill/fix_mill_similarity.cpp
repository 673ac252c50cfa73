#include "liggghts/mill/fix_mill_similarity.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <stdexcept>

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "fix_mesh_surface.h"
#include "force.h"
#include "group.h"
#include "modify.h"
#include "multi_vector_container.h"
#include "tri_mesh.h"
#include "update.h"

#include "core/liner/profile_file.h"
#include "liggghts/common/keywords.h"
#include "liggghts/common/one_per_ball.h"
#include "liggghts/mill/liner_arguments.h"

using namespace LAMMPS_NS;
using namespace FixConst;
using millscale::format;
using millscale::Vector;
namespace liner = millscale::liner;
namespace similarity = millscale::similarity;

namespace {

using NodeVelocities = MultiVectorContainer<double, 3, 3>;
// Of restart files: without and with changes of the speed.
constexpr double constant_speed_layout = 1.0, changes_layout = 2.0;
// The engine's steps are 64-bit integers; a mark that is never reached.
constexpr double never_reached = 9e18;

enum Published {
  mill_angle_rad = 1,
  speed_now_rad_s,
  gravity_m_s2,
  froude,
  radius_m,
  speed_rad_s,
  length_factor,
  mass_factor,
  time_factor,
  energy_ratio,
  centre_path_energy_ratio,
  detach_angle_rad,
  time_s,
  mesh_wobble,
  turned_s,
  next_mark_step
};
constexpr int published_size = next_mark_step;

liner::Profile profile_in(const std::string& file)
{
  std::ifstream in(file);
  if (!in) throw std::invalid_argument("profile: cannot open '" + file + "'");
  try {
    return liner::read_profile(in);
  } catch (const std::invalid_argument& problem) {
    throw std::invalid_argument("profile: file '" + file + "': " + problem.what());
  }
}

}  // namespace

struct FixMillSimilarity::Arguments {
  similarity::OperatingPoint physical{};
  similarity::ScalingRequest request;
  millscale::LinerArguments liner;
  std::string profile_file;
};

FixMillSimilarity::FixMillSimilarity(LAMMPS* lmp, int narg, char** arg)
    : Fix(lmp, narg, arg), meshes_(lmp)
{
  scalar_flag = vector_flag = 1;
  size_vector = published_size;
  global_freq = 1;
  extscalar = extvector = 0;
  restart_global = 1;
  time_depend = 1;

  rotation_.time_base = update->get_cur_time();
  rotation_.step_base = last_step_ = update->ntimestep;
  rotation_.dt = update->dt;
  try {
    parse(narg, arg);
  } catch (const std::invalid_argument& problem) {
    fail(problem.what());
  }
  rotation_.omega = scaled_.mill.omega;
  rotation_.schedule = schedule_;
  if (starts_at_creation_) rotation_.start = rotation_.time(update->ntimestep);
}

void FixMillSimilarity::fail(const std::string& message)
{
  error->fix_error(FLERR, this, message.c_str());
  throw std::logic_error(message);  // not reached: the engine ends the program
}

void FixMillSimilarity::parse(int narg, char** arg)
{
  using millscale::ArgumentList;
  Arguments a;
  millscale::Keywords keywords;
  keywords.number("radius", a.physical.radius)
      .number("gravity", a.physical.gravity)
      .number("omega", a.physical.omega)
      .number("ball_radius", a.physical.ball_radius)
      .number("scale", a.request.S)
      .add("scheme",
           [&a](ArgumentList& list) {
             a.request.scheme = similarity::scheme_from_name(list.word("scheme"));
           })
      .number("time_factor", a.request.time_factor)
      .add("policy",
           [&a](ArgumentList& list) {
             a.request.policy = similarity::policy_from_name(list.word("policy"));
           })
      .vector("axis", axis_)
      .vector("down", down_)
      .vector("origin", origin_)
      .add("start", [this](ArgumentList& list) { read_start(list.word("start")); })
      .add("mesh", [this](ArgumentList& list) { meshes_.add(list.word("mesh")); })
      .add("speed_change",
           [this](ArgumentList& list) {
             const double from = list.number("speed_change, from"),
                          over = list.number("speed_change, over");
             changes_.push_back({from, over, list.number("speed_change, ratio")});
           })
      .positive("mark", mark_)
      .choice("centrifuging", "allow", "refuse", a.request.allow_centrifuging)
      .word("profile", a.profile_file);
  a.liner.add_to(keywords);
  keywords.parse({narg, arg, 3});
  const similarity::OperatingPoint& mill = a.physical;
  if (mill.radius == 0.0 || mill.gravity == 0.0 || mill.omega == 0.0 || mill.ball_radius == 0.0)
    throw std::invalid_argument(
        "the physical mill needs radius, gravity, omega and ball_radius (m, m/s^2, rad/s, m)");
  normalise_directions();
  scaled_ = similarity::scale(mill, a.request);
  schedule_ = similarity::SpeedSchedule(changes_);
  make_liner(a);
  meshes_.check({{axis_, origin_}, scaled_.mill.radius, mill.radius, 1.0 / scaled_.base.length},
                [this](const std::string& message) { warn(message); });
}

/// The deck states the liner of the scaled mill.
void FixMillSimilarity::make_liner(const Arguments& a)
{
  const double radius = scaled_.mill.radius;
  states_liner_ = a.liner.given() || !a.profile_file.empty();
  if (a.profile_file.empty()) {
    widths_ = a.liner.widths(radius);
    liner_ = std::make_shared<const liner::Lifters>(*widths_);
    return;
  }
  if (a.liner.given())
    throw std::invalid_argument(
        std::string("profile: the liner is stated twice; give either a file or ") +
        millscale::LinerArguments::keywords);
  liner_ = std::make_shared<const liner::Profile>(profile_in(a.profile_file));
  // The law moves the radius of an offset liner by the ball's radius, but corners move otherwise.
  const bool is_offset = a.request.policy == similarity::Policy::offset_liner;
  const double tolerance = 1e-9 * radius + (is_offset ? a.physical.ball_radius : 0.0);
  if (std::abs(liner_->radius() - radius) > tolerance)
    throw std::invalid_argument("profile: the liner in '" + a.profile_file + "' has a radius of " +
                                format(liner_->radius()) + " m, the scaled mill of " +
                                format(radius) + " m; give the liner of the scaled mill");
}

/// when: a time in s, `now` or `never`.
void FixMillSimilarity::read_start(const std::string& when)
{
  starts_at_creation_ = when == "now";
  if (when == "never")
    rotation_.start = std::numeric_limits<double>::infinity();
  else if (!starts_at_creation_)
    rotation_.start = millscale::number(when, "start (a time in s, now, or never)");
}

void FixMillSimilarity::normalise_directions()
{
  using millscale::dot;
  for (Vector* direction : {&axis_, &down_}) {
    const double length = std::sqrt(dot(*direction, *direction));
    if (!(length > 0.0)) throw std::invalid_argument("axis and down must not be zero vectors");
    for (double& component : *direction) component /= length;
  }
  if (std::abs(dot(axis_, down_)) > 1e-12)
    throw std::invalid_argument("the mill's axis must be perpendicular to down, their cosine is " +
                                format(dot(axis_, down_)));
}

int FixMillSimilarity::setmask()
{
  return INITIAL_INTEGRATE | PRE_FORCE | POST_FORCE;  // PRE_FORCE for its set-up call
}

void FixMillSimilarity::post_create()
{
  nodes_angle_ = mill_angle();
  for (FixMeshSurface* mesh : meshes_.fixes()) {
    // A mesh taken from a restart file stands where it stood; one read from its file is unturned.
    if (!mesh->recent_restart && nodes_angle_ != 0.0)
      mesh->mesh()->rotate(nodes_angle_, axis_.data(), origin_.data());
    mesh->mesh()->registerMove(false, false, true);
  }
}

void FixMillSimilarity::pre_delete(bool unfixflag)
{
  if (!unfixflag) return;
  for (FixMeshSurface* mesh : meshes_.present()) {
    mesh->mesh()->unregisterMove(false, false, true);
    if (auto* v = mesh->mesh()->prop().getElementProperty<NodeVelocities>("v")) v->setAll(0.0);
  }
}

void FixMillSimilarity::init()
{
  try {
    require_one_per_ball(*this, modify, atom, group, world);
    meshes_.check_present();
  } catch (const std::invalid_argument& problem) {
    fail(problem.what());
  }
  rotation_.renumber(last_step_, update->ntimestep);
  rotation_.set_step_size(update->ntimestep, update->dt);
  last_step_ = update->ntimestep;
}

void FixMillSimilarity::setup_pre_force(int)
{
  // The engine has just stored the nodes as they stand for later rotations to start from.
  stored_angle_ = nodes_angle_;
  for (FixMeshSurface* mesh : meshes_.fixes()) {
    auto& properties = mesh->mesh()->prop();
    if (!properties.getElementProperty<NodeVelocities>("v"))
      properties.addElementProperty<NodeVelocities>("v", "comm_exchange_borders", "frame_invariant",
                                                    "restart_no");
  }
  set_wall_velocity();
}

void FixMillSimilarity::setup(int vflag)
{
  post_force(vflag);
}

void FixMillSimilarity::initial_integrate(int)
{
  last_step_ = update->ntimestep;
  const double angle = mill_angle();
  if (angle == nodes_angle_) return;
  for (FixMeshSurface* mesh : meshes_.fixes())
    mesh->mesh()->rotate(angle - stored_angle_, angle - nodes_angle_, axis_.data(), origin_.data());
  nodes_angle_ = angle;
  set_wall_velocity();
}

void FixMillSimilarity::set_wall_velocity()
{
  const double speed = speed_now();
  const Vector omega{speed * axis_[0], speed * axis_[1], speed * axis_[2]};
  for (FixMeshSurface* fix : meshes_.fixes()) {
    TriMesh& mesh = *fix->triMesh();
    double*** velocity = mesh.prop().getElementProperty<NodeVelocities>("v")->begin();
    for (int i = 0; i < mesh.size(); ++i)
      for (int node = 0; node < 3; ++node) {
        Vector p;
        mesh.node(i, node, p.data());
        for (int d = 0; d < 3; ++d) p[d] -= origin_[d];
        const Vector v = millscale::cross(omega, p);
        std::copy(v.begin(), v.end(), velocity[i][node]);
      }
  }
}

void FixMillSimilarity::post_force(int)
{
  const double g = gravity();
  const Vector acceleration{g * down_[0], g * down_[1], g * down_[2]};
  for (int i = 0; i < atom->nlocal; ++i)
    if (atom->mask[i] & groupbit)
      for (int d = 0; d < 3; ++d) atom->f[i][d] += atom->rmass[i] * acceleration[d];
}

double FixMillSimilarity::mill_angle() const
{
  return rotation_.angle(update->ntimestep);
}

double FixMillSimilarity::mill_time() const
{
  return rotation_.time(update->ntimestep);
}

double FixMillSimilarity::speed_now() const
{
  return rotation_.speed(update->ntimestep);
}

double FixMillSimilarity::angle_before_step() const
{
  return rotation_.angle(update->ntimestep - 1);
}

/// Return the first step after this one at which the mill angle is nearest to a multiple of `mark`.
double FixMillSimilarity::next_mark() const
{
  if (mark_ == 0.0 || std::isinf(rotation_.start)) return never_reached;
  const auto now = static_cast<double>(update->ntimestep);
  double multiple = std::floor(mill_angle() / mark_);
  while (!(rotation_.step_at(multiple * mark_) > now)) multiple += 1.0;
  return rotation_.step_at(multiple * mark_);
}

double FixMillSimilarity::compute_scalar()
{
  return mill_angle();
}

double FixMillSimilarity::compute_vector(int index)
{
  switch (index + 1) {
    case mill_angle_rad:
      return mill_angle();
    case speed_now_rad_s:
      return speed_now();
    case gravity_m_s2:
      return gravity();
    case froude:
      return scaled_.froude;
    case radius_m:
      return scaled_.mill.radius;
    case speed_rad_s:
      return scaled_.mill.omega;
    case length_factor:
      return scaled_.base.length;
    case mass_factor:
      return scaled_.base.mass;
    case time_factor:
      return scaled_.base.time;
    case energy_ratio:
      return scaled_.predicted_energy_ratio;
    case centre_path_energy_ratio:
      return scaled_.centre_path_energy_ratio;
    case time_s:
      return mill_time();
    case mesh_wobble:
      return meshes_.wobble_now();
    case turned_s:
      return schedule_.phase(mill_angle()) / scaled_.mill.omega;
    case next_mark_step:
      return next_mark();
    case detach_angle_rad:
      return scaled_.froude > 1.0 ? 0.0 : similarity::detach_angle(scaled_.froude);
  }
  return 0.0;
}

/// Write the rotation, and the changes of the speed if there are any.
void FixMillSimilarity::write_restart(FILE* file)
{
  if (comm->me != 0) return;
  std::vector<double> state{changes_.empty() ? constant_speed_layout : changes_layout,
                            rotation_.omega,
                            rotation_.start,
                            rotation_.angle_before,
                            rotation_.time_base,
                            static_cast<double>(rotation_.step_base),
                            rotation_.dt,
                            static_cast<double>(update->ntimestep)};
  if (!changes_.empty()) state.push_back(static_cast<double>(changes_.size()));
  for (const auto& change : changes_)
    state.insert(state.end(), {change.from, change.over, change.ratio});
  const int bytes = static_cast<int>(state.size() * sizeof(double));
  fwrite(&bytes, sizeof bytes, 1, file);
  fwrite(state.data(), 1, bytes, file);
}

void FixMillSimilarity::restart(char* buffer)
{
  double state[8];
  std::memcpy(state, buffer, sizeof state);
  if (state[0] != constant_speed_layout && state[0] != changes_layout)
    fail("the restart file holds layout " + format(state[0]) +
         " of this fix, this version reads layouts " + format(constant_speed_layout) + " and " +
         format(changes_layout) + "; run from the start, or use the version that wrote the file");
  std::vector<similarity::SpeedChange> changes;
  if (state[0] == changes_layout) {
    const char* next = buffer + sizeof state;
    double count = 0.0;
    std::memcpy(&count, next, sizeof count);
    changes.resize(static_cast<std::size_t>(count));
    std::memcpy(changes.data(), next + sizeof count, changes.size() * sizeof changes[0]);
  }
  similarity::Rotation before;
  before.omega = state[1];
  before.start = state[2];
  before.angle_before = state[3];
  before.time_base = state[4];
  before.step_base = static_cast<std::int64_t>(state[5]);
  before.dt = state[6];
  before.schedule = similarity::SpeedSchedule(changes).after(before.angle_before);
  last_step_ = static_cast<bigint>(state[7]);
  continue_rotation(before, changes == changes_);
}

void FixMillSimilarity::continue_rotation(const similarity::Rotation& before, bool same_changes)
{
  const similarity::Rotation asked = rotation_;
  rotation_ = before;
  rotation_.renumber(last_step_, update->ntimestep);
  last_step_ = update->ntimestep;
  if (!rotation_.turning(last_step_)) {
    if (!starts_at_creation_)
      rotation_.start = asked.start;
    else if (std::isinf(rotation_.start))
      rotation_.start = rotation_.time(last_step_);
  } else if (!starts_at_creation_ && asked.start != rotation_.start) {
    fail("start: the restart file's mill turns since " + format(rotation_.start) +
         " s, the deck says " + format(asked.start) + " s; give the same start, or 'now' to go on");
  }
  if (asked.omega != rotation_.omega || !same_changes)
    rotation_.set_speed(last_step_, asked.omega, schedule_);
}

void FixMillSimilarity::warn(const std::string& message) const
{
  const std::string text = std::string("Fix ") + style + " (id " + id + "): " + message;
  if (comm->me == 0) error->warning(FLERR, text.c_str());
}
