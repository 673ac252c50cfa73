#pragma once

#include "core/contact/written_out.h"
#include "core/energy/contact_sums.h"
#include "core/kernels/kernel.h"
#include "core/neighbor/cloud.h"

namespace kernel_test {

using namespace millscale::kernels;
using namespace millscale::neighbor;
namespace contact = millscale::contact;
using millscale::energy::ContactWork, millscale::energy::EndedContact,
    millscale::energy::WorkRecord;

inline constexpr double dt = 1e-5;

/// Materials of two types, each pair of types unlike the others.
inline const std::vector<contact::EffectiveMaterial> materials{{3.3e7, 7.0e6, 0.59, 0.5, 0.010},
                                                               {2.1e7, 9.0e6, 0.46, 0.3, 0.020},
                                                               {2.1e7, 9.0e6, 0.46, 0.3, 0.020},
                                                               {1.2e8, 4.0e7, 0.22, 0.7, 0.005}};

/// Return whether an implementation of `kernels` is a mixed one.
inline bool is_mixed(const Implementation& kernel)
{
  return kernel.evaluate == kernel.evaluate_mixed;
}

/// A cloud, its list and the results of a step.
struct Evaluation {
  Cloud cloud;
  PairList list;
  std::vector<std::array<double, 3>> force, torque;
  std::vector<double> damping;  ///< of each ball, one step earlier
  contact::ContactTerms terms;
  std::vector<contact::ContactLaw<double>> laws;  ///< of the pairs of types
  bool advance = true, reset_on_separation = true;
  double* largest_overlap = nullptr;
  WorkRecord* record = nullptr;

  explicit Evaluation(const Cloud& c, double gap = 0.005) : cloud(c)
  {
    for (const auto& m : materials) laws.push_back(contact::contact_law(m));
    build_within(list, cloud, gap, best_implementation().list_partners);
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    for (int i = 0; i < list.nlocal(); ++i)
      for (int entry = list.first[i]; entry < list.first[i] + list.partners[i]; ++entry) {
        list.touching[entry] = entry % 7 != 0;  // the others may be contacts that begin
        for (int d = 0; d < 3; ++d) list.displacement[3 * entry + d] = 3e-5 * normal(random);
      }
    std::uniform_real_distribution<double> share(0.0, 2e4);
    for (const double mass : cloud.mass) damping.push_back(mass * share(random));
    clear();
  }

  void clear()
  {
    force.assign(cloud.all(), {});
    torque.assign(cloud.all(), {});
  }

  int only_type() const
  {
    const auto& type = cloud.type;
    const bool one = std::all_of(type.begin(), type.end(), [&](int t) { return t == type[0]; });
    return one && !type.empty() ? type[0] : 0;
  }

  Task task(const Rows& rows)
  {
    return {cloud.view(),
            &rows,
            {list.entries, list.own.data(), list.other.data(), list.touching.data(),
             list.displacement.data()},
            {laws.data(), 2, only_type()},
            terms,
            {dt, advance, reset_on_separation},
            {reinterpret_cast<double(*)[3]>(force.data()),
             reinterpret_cast<double(*)[3]>(torque.data()), damping.data()},
            largest_overlap,
            record};
  }

  /// Evaluate. With `sums`, evaluate with the energy budget.
  void with(const Implementation& kernel, millscale::energy::PairSums* sums = nullptr)
  {
    RowStore store;
    const Rows rows = store.resize(cloud.all(), is_mixed(kernel) && !sums);
    const Task task = this->task(rows);
    if (!sums) return kernel.evaluate(task);
    sums->clear(cloud.nlocal());
    sums->begin_list(list.touching.data(), list.entries);
    evaluate_with_budget(task, *sums);
  }

  /// Evaluate rows, which are filled here. The engine's arrays are not there.
  void with_rows(const Implementation& kernel)
  {
    const bool single = is_mixed(kernel);
    RowStore store;
    const Rows rows = store.resize(cloud.all(), single, true);
    for (int i = 0; i < cloud.all(); ++i) {
      const auto &x = cloud.position[i], &v = cloud.velocity[i], &w = cloud.spin[i];
      const double share = terms.limited_damping ? damping_share(i) : 0.0;
      rows.position[i] = {x[0], x[1], x[2], cloud.radius[i]};
      rows.velocity[i] = {{v[0], v[1], v[2]}, cloud.mass[i], {w[0], w[1], w[2]}, share};
      if (single) to_single(rows.velocity[i], rows.single_velocity[i]);
    }
    Task task = this->task(rows);
    task.particles = {nullptr, nullptr,           nullptr,        nullptr,
                      nullptr, cloud.type.data(), cloud.nlocal(), cloud.ghosts};
    task.sums = {};
    kernel.evaluate_rows(task);
    for (int i = 0; i < cloud.nlocal(); ++i)
      single ? add(rows.single_force[i], i) : add(rows.force[i], i);
  }

  template <class Row>
  void add(const Row& row, int i)
  {
    for (int d = 0; d < 3; ++d) {
      force[i][d] += row.force[d];
      torque[i][d] += row.torque[d];
    }
    if (terms.limited_damping && advance) damping[i] = row.damping;
  }

  double separation_squared(int i, int j) const
  {
    double r2 = 0.0;
    for (int d = 0; d < 3; ++d) {
      const double separation = cloud.position[i][d] - cloud.position[j][d];
      r2 += separation * separation;
    }
    return r2;
  }

  /// Evaluate one pair after the other, by the written-out law.
  void naively()
  {
    std::vector<double> sums(cloud.all(), 0.0);
    for (int i = 0; i < cloud.nlocal(); ++i)
      for (int entry = list.first[i]; entry < list.first[i] + list.partners[i]; ++entry)
        naive_pair(i, list.other[entry], entry, sums);
    if (terms.limited_damping && advance)
      std::copy_n(sums.begin(), cloud.nlocal(), damping.begin());
  }

  double damping_share(int i) const { return dt * damping[i] / cloud.mass[i]; }

  void naive_pair(int i, int j, int entry, std::vector<double>& sums)
  {
    using written_out::sum;
    double* history = &list.displacement[3 * entry];
    const double radii = cloud.radius[i] + cloud.radius[j], r2 = separation_squared(i, j);
    if (!(r2 < radii * radii)) {
      if (!reset_on_separation) return;
      list.touching[entry] = 0;
      return;
    }
    if (!list.touching[entry]) std::fill_n(history, 3, 0.0);
    using millscale::vector3;
    const auto got = written_out::pair_force(
        {vector3(sum(cloud.position[i], -1.0, cloud.position[j])),
         r2,
         cloud.radius[i],
         cloud.radius[j],
         cloud.mass[i],
         cloud.mass[j],
         vector3(sum(cloud.velocity[i], -1.0, cloud.velocity[j])),
         vector3(cloud.spin[i]),
         vector3(cloud.spin[j]),
         {history[0], history[1], history[2]},
         damping_share(i) + damping_share(j)},
        materials[(cloud.type[i] - 1) * 2 + cloud.type[j] - 1], terms, dt, advance);
    list.touching[entry] = 1;
    std::copy_n(got.displacement.begin(), 3, history);
    sums[i] += got.damping;
    sums[j] += got.damping;
    force[i] = sum(force[i], 1.0, got.force);
    torque[i] = sum(torque[i], 1.0, got.torque_i);
    if (j >= cloud.nlocal()) return;
    force[j] = sum(force[j], -1.0, got.force);
    torque[j] = sum(torque[j], 1.0, got.torque_j);
  }
};

inline double largest(const std::vector<std::array<double, 3>>& field)
{
  double size = 0.0;
  for (const auto& row : field)
    for (const double value : row) size = std::fmax(size, std::abs(value));
  return size;
}

}  // namespace kernel_test
