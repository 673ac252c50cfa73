// Compiled for x86-64-v3 and v4, see find_contacts.h: forces of four contacts at a time, in double
// precision.
#include "core/kernels/find_contacts.h"

namespace millscale::pairs::MILLSCALE_LEVEL {
namespace {

using Vectors = Vector3<Pack>;
struct Columns {
  Vectors xyz;
  Pack fourth;
};

/// x of all four rows, y of all, z of all, the fourth of all.
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

/// Forces of `count` <= width contacts; the lanes beyond `count` repeat one of them.
[[gnu::flatten, gnu::noinline]] void evaluate_pack(const Task& task, const int* entry, int count,
                                                   const Law& law)
{
  const Rows& rows_of = *task.rows;
  int i[width], j[width];
  for (int lane = 0; lane < width; ++lane) i[lane] = task.own[entry[lane]];
  for (int lane = 0; lane < width; ++lane) j[lane] = task.other[entry[lane]];
  const auto place = [&](int ball) { return four(&rows_of.place[ball].x); };
  const auto velocity = [&](int ball) { return four(rows_of.motion[ball].velocity); };
  const auto spin = [&](int ball) { return four(rows_of.motion[ball].spin); };
  const auto memory = [&](int lane) {
    return task.displacement + 3 * static_cast<std::size_t>(entry[lane]);
  };

  // The fourth columns carry one number of each contact beside the vectors.
  const Columns apart = columns(
      [&](int lane) { return with_fourth(place(i[lane]) - place(j[lane]), place(j[lane])); });
  const Columns speed = columns([&](int lane) {
    return with_fourth(velocity(i[lane]) - velocity(j[lane]), velocity(i[lane]));
  });
  const Columns spin_i =
      columns([&](int lane) { return with_fourth(spin(i[lane]), velocity(j[lane])); });
  const Columns spin_j =
      columns([&](int lane) { return spin(j[lane]) + with_fourth(Pack(0.0), spin(i[lane])); });
  const Columns displacement =
      columns([&](int lane) { return with_fourth(four(memory(lane)), place(i[lane])); });
  contact::BallPair<Pack> pair;
  pair.separation = apart.xyz;
  pair.r2 = dot(pair.separation, pair.separation);
  pair.radius_i = displacement.fourth;
  pair.radius_j = apart.fourth;
  pair.mass_i = speed.fourth;
  pair.mass_j = spin_i.fourth;
  pair.velocity = speed.xyz;
  pair.spin_i = spin_i.xyz;
  pair.spin_j = spin_j.xyz;
  pair.displacement = displacement.xyz;
  pair.damping_share = spin_j.fourth;

  const auto result =
      contact::contact_force(contact::contact_of(pair), law, task.terms, task.dt, task.advance);

  const FourRows kept = rows(result.displacement, Pack(0.0));
  const FourRows force = rows(result.force, Pack(0.0));
  const FourRows torque_i = rows(result.torque_i, result.damping);
  const FourRows torque_j = rows(result.torque_j, result.damping);
  for (int lane = 0; lane < count; ++lane) {
    store_three(memory(lane), kept.of[lane]);
    Load &on_i = rows_of.load[i[lane]], &on_j = rows_of.load[j[lane]];
    add(on_i.force, force.of[lane]);
    add(on_i.torque, torque_i.of[lane]);
    subtract(on_j.force, force.of[lane]);
    add(on_j.torque, torque_j.of[lane]);
  }
}

/// Copies what the contacts need side by side.
void pack(const Task& task)
{
  const Balls& balls = task.balls;
  const Rows rows = *task.rows;
  for_each_ball(balls.all, [&](int i, const auto& vector) {
    put(&rows.place[i].x, with_fourth(vector(balls.position[i]), Pack(balls.radius[i])));
    put(rows.motion[i].velocity, with_fourth(vector(balls.velocity[i]), Pack(balls.mass[i])));
    put(rows.motion[i].spin, with_fourth(vector(balls.spin[i]), Pack(damping_share(task, i))));
  });
}

/// Adds the loads of the owned balls to their forces, and clears them for the next step.
void unload(const Task& task)
{
  Load* const load = task.rows->load;
  for (int i = 0; i < task.balls.owned; ++i) {
    for (int d = 0; d < 3; ++d) task.force[i][d] += load[i].force[d];
    for (int d = 0; d < 3; ++d) task.torque[i][d] += load[i].torque[d];
    if (task.terms.limited_damping && task.advance) task.damping[i] = load[i].damping;
    put(load[i].force, Pack(0.0));
    put(load[i].torque, Pack(0.0));
  }
}

}  // namespace

int* list_partners(const Candidates& candidates, Centre ball, int* out)
{
  for (int k = 0; k < candidates.count; k += width) {
    const Pack x = Pack(ball.x) - four(candidates.x + k), y = Pack(ball.y) - four(candidates.y + k);
    const Pack z = Pack(ball.z) - four(candidates.z + k);
    const Pack radii = Pack(ball.radius) + four(candidates.radius + k);
    const int near = bits(radii * radii > x * x + y * y + z * z);
    const Ints index = load<Ints>(candidates.index + k);
    const int left = candidates.count - k, own = left < width ? (1 << left) - 1 : 15;
    const int listed = near & own;
    store(out, __builtin_shuffle(index, chosen[listed].order));
    out += __builtin_popcount(listed);
  }
  return out;
}

void evaluate(const Task& task)
{
  pack(task);
  evaluate_list<Pack, width>(
      task, [&](int entry) { fetch_ahead(task, entry, task.rows->motion, task.rows->load); },
      [&](const int* entry, int count, const Law& law) { evaluate_pack(task, entry, count, law); });
  unload(task);
}

}  // namespace millscale::pairs::MILLSCALE_LEVEL
