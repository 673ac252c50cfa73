#pragma once

// Finds the contacts of the pair list in double precision.
#ifdef __AVX512F__
#include "core/kernels/pack_v4.h"
#else
#include "core/kernels/pack_v3.h"
#endif

namespace millscale::kernels::MILLSCALE_LEVEL {
namespace {

constexpr int width = Doubles::lanes;  ///< entries examined together

constexpr int part = 128;  ///< entries of the list
constexpr int room = part + 2 * 2 * Singles::lanes + width;

/// Where the contacts of a step differ from those of the step before. Both follow the list, so that
/// number n of this step is mostly number n plus a constant of the step before.
class Splices {
 public:
  int before = 0;  ///< contacts of the step before among the entries found so far

  /// A contact begins, number n of this step; one ends that was before number n.
  void begin(int n) { at(n).begins = true; }
  void end(int n) { ++at(n).skipped; }

  /// Return whether the next `count` contacts, from number n on, all were contacts of the step
  /// before, one after the other.
  bool none(int n, int count) const { return next_ == all_ || splice_[next_].n >= n + count; }

  /// Use up the next `count` contacts of the step before; return the number of the first.
  int use(int count)
  {
    const int first = used_;
    used_ += count;
    return first;
  }

  static constexpr int no_contact = -1;

  /// Return the number that contact n had in the step before, or `no_contact`.
  int use_for(int n)
  {
    const bool here = next_ < all_ && splice_[next_].n == n;
    if (!here) return used_++;
    const Splice& splice = splice_[next_++];
    used_ += splice.skipped;
    return splice.begins ? no_contact : used_++;
  }

  void drop_used()
  {
    for (int k = next_; k < all_; ++k) splice_[k - next_] = splice_[k];
    all_ -= next_;
    next_ = 0;
  }

 private:
  struct Splice {
    int n, skipped;
    bool begins;
  };

  Splice& at(int n)
  {
    if (all_ == 0 || splice_[all_ - 1].n != n) splice_[all_++] = {n, 0, false};
    return splice_[all_ - 1];
  }

  int used_ = 0;            ///< contacts of the step before
  int next_ = 0, all_ = 0;  ///< splices
  Splice splice_[room + 1];
};

/// Contacts of a part of the list, in columns.
struct Found {
  alignas(64) double x[room], y[room], z[room];  ///< of the separation [m]
  alignas(64) double minus_radii[room];          ///< minus the sum of the radii [m]
  alignas(64) unsigned displacement[room];       ///< index of its first component
  alignas(64) Ball i[room], j[room];
  int count = 0;
  int evaluated = 0;  ///< contacts of the step before the first one here
  Splices splices;    ///< if the work is recorded

  /// Drop the first contacts.
  void drop(int dropped)
  {
    count -= dropped;
    evaluated += dropped;
    splices.drop_used();
    for (int k = 0; k < count; k += width) {
      for (double* column : {x, y, z, minus_radii})
        __builtin_memcpy(column + k, column + k + dropped, width * sizeof(double));
      for (unsigned* column : {displacement, i, j})
        __builtin_memcpy(column + k, column + k + dropped, width * sizeof(unsigned));
    }
  }

  /// Repeat the first contact up to a whole pack.
  void fill_up(int lanes)
  {
    for (int k = count; k < lanes; ++k) {
      for (double* column : {x, y, z, minus_radii}) column[k] = column[0];
      for (unsigned* column : {displacement, i, j}) column[k] = column[0];
    }
  }
};

/// Return the square of the sum of the radii less the squared separation [m^2].
inline Doubles excess(const Vector3<Doubles>& separation, Doubles radii)
{
  return radii * radii - separation.x * separation.x - separation.y * separation.y -
         separation.z * separation.z;
}

/// Return what the work of a contact of the list needs of its balls, in double precision.
inline contact::BallPair<double> pair_of(const Task& task, std::size_t entry)
{
  const int i = task.pairs.own[entry], j = task.pairs.other[entry];
  const PositionRow &at = task.rows->position[i], &from = task.rows->position[j];
  contact::BallPair<double> pair{};
  pair.separation = {at.x - from.x, at.y - from.y, at.z - from.z};
  pair.r2 = dot(pair.separation, pair.separation);
  pair.radius_i = at.radius;
  pair.radius_j = from.radius;
  const neighbor::Particles& balls = task.particles;
  const bool in_arrays = task.sums.force;  // else in the rows, which are in double precision then
  const auto motion = [&](int ball, Vector3<double>& velocity, Vector3<double>& spin,
                          double& mass) {
    const VelocityRow* const row = in_arrays ? nullptr : task.rows->velocity + ball;
    velocity = vector3(in_arrays ? balls.velocity[ball] : row->velocity);
    spin = vector3(in_arrays ? balls.spin[ball] : row->spin);
    mass = in_arrays ? balls.mass[ball] : row->mass;
  };
  Vector3<double> of_j;
  motion(i, pair.velocity, pair.spin_i, pair.mass_i);
  motion(j, of_j, pair.spin_j, pair.mass_j);
  pair.velocity = pair.velocity - of_j;
  return pair;
}

/// Record the end of a contact, number k of the step before.
inline void end_contact(const Task& task, std::size_t entry, int k)
{
  const int j = task.pairs.other[entry];
  task.record->end(static_cast<int>(entry), k, task.pairs.own[entry], j,
                   j < task.particles.nlocal ? 1.0 : 0.5, pair_of(task, entry));
}

/// Set which of the pairs from `entry` on are in contact, and clear the history of contacts that
/// begin. That of pairs not in contact is never read.
[[gnu::flatten, gnu::noinline]] inline void change_contacts(const Task& task, int entry,
                                                            unsigned before, unsigned now,
                                                            Found& found)
{
  const unsigned kept = task.step.reset_on_separation ? now : now | before;
  for (int lane = 0; lane < width; ++lane) {
    const std::size_t pair = static_cast<std::size_t>(entry) + lane;
    task.pairs.touching[pair] = kept >> lane & 1;
    const bool begins = (now & ~before) >> lane & 1, ends = (before & ~now) >> lane & 1;
    if (begins)
      for (int d = 0; d < 3; ++d) task.pairs.displacement[3 * pair + d] = 0.0;
    if (!task.record || begins == ends) continue;
    const auto earlier = [lane](unsigned of) {
      return __builtin_popcount(of & ((1u << lane) - 1));
    };
    const int number = found.evaluated + found.count + earlier(now);
    if (begins) {
      task.record->begin(static_cast<int>(pair), pair_of(task, pair));
      found.splices.begin(number);
    } else {
      end_contact(task, pair, found.splices.before + earlier(before));
      found.splices.end(number);
    }
  }
}

/// Find the contacts among the entries from `entry` on, of which `count` belong to the list.
template <bool recorded>
inline void find(const Task& task, int entry, int count, Found& found)
{
  constexpr int ahead = neighbor::spare_entries - width;
  const PositionRow* const position = task.rows->position;
  const int *const i = task.pairs.own + entry, *const j = task.pairs.other + entry;
  for (int k = 0; k < width; ++k) __builtin_prefetch(position + j[ahead + k]);
  const Columns<Doubles> pair = differences(position, i, j);
  unsigned now = positive(excess(pair.xyz, pair.fourth));
  if (count < width) now &= (1u << count) - 1;
  const unsigned before = nonzero(ints(task.pairs.touching + entry));
  if (__builtin_expect(before != now, false)) change_contacts(task, entry, before, now, found);
  const int at = found.count;
  store_chosen(found.x + at, now, pair.xyz.x);
  store_chosen(found.y + at, now, pair.xyz.y);
  store_chosen(found.z + at, now, pair.xyz.z);
  store_chosen(found.minus_radii + at, now, pair.fourth);
  store_chosen(found.displacement + at, now, ints_from(3 * entry, 3));
  if constexpr (recorded) found.splices.before += __builtin_popcount(before);
  store_chosen(found.i + at, now, balls(ints(i)));
  store_chosen(found.j + at, now, balls(ints(j)));
  found.count = at + __builtin_popcount(now);
}

/// Find the contacts of a part of the list.
template <bool recorded>
[[gnu::flatten, gnu::noinline]] void find_part(const Task& task, int begin, Found& found)
{
  const int end = begin + part < task.pairs.entries ? begin + part : task.pairs.entries;
  for (int entry = begin; entry < end; entry += width)
    find<recorded>(task, entry, task.pairs.entries - entry, found);
}

/// Raise the largest overlap, radii less distance of the centres [m], rounded as by a search among
/// all balls (core/measure/overlap_search.h).
[[gnu::flatten, gnu::noinline]] void raise_overlap(Found& found, double& largest)
{
  if (found.count == 0) return;
  found.fill_up((found.count + width - 1) / width * width);
  Doubles most(largest);
  for (int k = 0; k < found.count; k += width) {
    const auto square = [&](const double* column) {
      const auto part = from_doubles<Doubles>(column + k);
      return Doubles(part * part);  // rounded before it is added
    };
    const Doubles distance = sqrt(square(found.x) + square(found.y) + square(found.z));
    const Doubles overlap = Doubles(0.0) - from_doubles<Doubles>(found.minus_radii + k) - distance;
    most = choose(overlap > most, overlap, most);
  }
  for (int lane = 0; lane < width; ++lane)
    if (most.values[lane] > largest) largest = most.values[lane];
}

/// Find all contacts of the list. evaluate(found, first, count) evaluates `count` of them, at most
/// `lanes`; prefetch(found, first) prefetches as many.
template <int lanes, bool recorded, class Prefetch, class Evaluate>
inline void for_each_pack(const Task& task, const Prefetch& prefetch, const Evaluate& evaluate)
{
  Found found;
  for (int begin = 0; begin < task.pairs.entries; begin += part) {
    find_part<recorded>(task, begin, found);
    if (task.largest_overlap) raise_overlap(found, *task.largest_overlap);
    int k = 0;
    for (; k + 2 * lanes <= found.count; k += lanes) {
      prefetch(found, k + lanes);
      evaluate(found, k, lanes);
    }
    if (k > 0) found.drop(k);
  }
  while (found.count > 0) {
    found.fill_up(lanes);
    const int count = found.count < lanes ? found.count : lanes;
    evaluate(found, 0, count);
    found.drop(count);
  }
}

}  // namespace
}  // namespace millscale::kernels::MILLSCALE_LEVEL
