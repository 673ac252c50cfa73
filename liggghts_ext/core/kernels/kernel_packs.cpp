// Evaluates four contacts at a time in double precision. Compiled for x86-64-v3 and v4, see
// find_contacts.h.
#include "core/kernels/find_contacts.h"

namespace millscale::kernels::MILLSCALE_LEVEL {
namespace {

using Vectors = Vector3<Pack>;
struct Columns {
  Vectors xyz;
  Pack fourth;
};

/// Transpose four rows: x, y, z and fourth numbers of all.
template <class Row>
inline Columns columns(const Row& row)
{
  const Pack a = row(0), b = row(1), c = row(2), d = row(3);
  const Pack low_ab = shuffled<0, 4, 2, 6>(a, b), low_cd = shuffled<0, 4, 2, 6>(c, d);
  const Pack high_ab = shuffled<1, 5, 3, 7>(a, b), high_cd = shuffled<1, 5, 3, 7>(c, d);
  return {{shuffled<0, 1, 4, 5>(low_ab, low_cd), shuffled<0, 1, 4, 5>(high_ab, high_cd),
           shuffled<2, 3, 6, 7>(low_ab, low_cd)},
          shuffled<2, 3, 6, 7>(high_ab, high_cd)};
}

using Law = contact::ContactLaw<Pack>;

struct FourRows {
  Pack of[width];
};

inline FourRows rows(const Vectors& v, Pack fourth)
{
  const Pack low_xy = shuffled<0, 4, 2, 6>(v.x, v.y), low_z = shuffled<0, 4, 2, 6>(v.z, fourth);
  const Pack high_xy = shuffled<1, 5, 3, 7>(v.x, v.y), high_z = shuffled<1, 5, 3, 7>(v.z, fourth);
  return {{shuffled<0, 1, 4, 5>(low_xy, low_z), shuffled<0, 1, 4, 5>(high_xy, high_z),
           shuffled<2, 3, 6, 7>(low_xy, low_z), shuffled<2, 3, 6, 7>(high_xy, high_z)}};
}

inline void add(double* sum, Pack part)
{
  put(sum, four(sum) + part);
}

inline void subtract(double* sum, Pack part)
{
  put(sum, four(sum) - part);
}

/// Evaluate `count` <= width contacts; the lanes beyond `count` repeat one of them.
[[gnu::flatten, gnu::noinline]] void evaluate_pack(const Task& task, const int* entry, int count,
                                                   const Law& law)
{
  const Rows& rows_of = *task.rows;
  int i[width], j[width];
  for (int lane = 0; lane < width; ++lane) i[lane] = task.pairs.own[entry[lane]];
  for (int lane = 0; lane < width; ++lane) j[lane] = task.pairs.other[entry[lane]];
  const auto position = [&](int i) { return four(&rows_of.position[i].x); };
  const auto velocity = [&](int i) { return four(rows_of.velocity[i].velocity); };
  const auto spin = [&](int i) { return four(rows_of.velocity[i].spin); };
  const auto history = [&](int lane) {
    return task.pairs.displacement + 3 * static_cast<std::size_t>(entry[lane]);
  };

  // The fourth column holds one scalar of each contact.
  const Columns separation = columns([&](int lane) {
    return with_fourth(position(i[lane]) - position(j[lane]), position(j[lane]));
  });
  const Columns speed = columns([&](int lane) {
    return with_fourth(velocity(i[lane]) - velocity(j[lane]), velocity(i[lane]));
  });
  const Columns spin_i =
      columns([&](int lane) { return with_fourth(spin(i[lane]), velocity(j[lane])); });
  const Columns spin_j =
      columns([&](int lane) { return spin(j[lane]) + with_fourth(Pack(0.0), spin(i[lane])); });
  const Columns displacement =
      columns([&](int lane) { return with_fourth(four(history(lane)), position(i[lane])); });
  contact::BallPair<Pack> pair;
  pair.separation = separation.xyz;
  pair.r2 = dot(pair.separation, pair.separation);
  pair.radius_i = displacement.fourth;
  pair.radius_j = separation.fourth;
  pair.mass_i = speed.fourth;
  pair.mass_j = spin_i.fourth;
  pair.velocity = speed.xyz;
  pair.spin_i = spin_i.xyz;
  pair.spin_j = spin_j.xyz;
  pair.displacement = displacement.xyz;
  pair.damping_share = spin_j.fourth;

  const auto result = contact::contact_force(contact::contact_of(pair), law, task.terms,
                                             task.step.dt, task.step.advance);

  const FourRows kept = rows(result.displacement, Pack(0.0));
  const FourRows force = rows(result.force, Pack(0.0));
  const FourRows torque_i = rows(result.torque_i, result.damping);
  const FourRows torque_j = rows(result.torque_j, result.damping);
  for (int lane = 0; lane < count; ++lane) {
    store_three(history(lane), kept.of[lane]);
    ForceRow &on_i = rows_of.force[i[lane]], &on_j = rows_of.force[j[lane]];
    add(on_i.force, force.of[lane]);
    add(on_i.torque, torque_i.of[lane]);
    subtract(on_j.force, force.of[lane]);
    add(on_j.torque, torque_j.of[lane]);
  }
}

/// Copy positions and velocities of all particles into rows.
void fill_rows(const Task& task)
{
  const neighbor::Particles& particles = task.particles;
  const Rows rows = *task.rows;
  for_each_particle(particles.total(), [&](int i, const auto& vector) {
    put(&rows.position[i].x, with_fourth(vector(particles.position[i]), Pack(particles.radius[i])));
    put(rows.velocity[i].velocity,
        with_fourth(vector(particles.velocity[i]), Pack(particles.mass[i])));
    put(rows.velocity[i].spin,
        with_fourth(vector(particles.spin[i]), Pack(damping_share(task, i))));
  });
}

/// Add the force rows of the local particles to their sums, and clear the rows.
void add_forces(const Task& task)
{
  ForceRow* const row = task.rows->force;
  for (int i = 0; i < task.particles.nlocal; ++i) {
    for (int d = 0; d < 3; ++d) task.sums.force[i][d] += row[i].force[d];
    for (int d = 0; d < 3; ++d) task.sums.torque[i][d] += row[i].torque[d];
    if (task.terms.limited_damping && task.step.advance) task.sums.damping[i] = row[i].damping;
    put(row[i].force, Pack(0.0));
    put(row[i].torque, Pack(0.0));
  }
}

}  // namespace

void evaluate_rows(const Task& task)
{
  evaluate_list<Pack, width>(
      task,
      [&](int entry) { prefetch_contact(task, entry, task.rows->velocity, task.rows->force); },
      [&](const int* entry, int count, const Law& law) { evaluate_pack(task, entry, count, law); });
}

void evaluate(const Task& task)
{
  fill_rows(task);
  evaluate_rows(task);
  add_forces(task);
}

}  // namespace millscale::kernels::MILLSCALE_LEVEL
