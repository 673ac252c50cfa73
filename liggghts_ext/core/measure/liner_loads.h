#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/math/constants.h"

namespace millscale::charge {

/// What the balls do to a part of the liner, summed over contacts and steps.
enum LinerLoad {
  normal_impulse,      ///< of the force into the liner [N s]
  tangential_impulse,  ///< of the force along the profile, > 0 in the direction of rotation [N s]
  torque_impulse,      ///< of the torque on the mill about its axis [N m s]
  slip_work,           ///< Coulomb's force times the distance slid [J]
  normal_dissipation,  ///< by the normal damping force [J]
  impacts,             ///< contacts that begin [-]
  impact_energy,       ///< of their approach along the normal [J]
  finnie_energy,       ///< of `finnie_energy_of` [J]
  liner_loads
};
using LinerLoads = std::array<double, liner_loads>;

/// Return the energy of an impact times Finnie's function of its angle [J], 1/2 m v^2 f(alpha). I.
/// Finnie, Wear 3 (1960) 87-103, for K = 2: f = sin 2 alpha - 3 sin^2 alpha up to tan alpha = 1/3,
/// and cos^2 alpha / 3 beyond. into, along: speeds along the normal and the surface [m/s].
inline double finnie_energy_of(double mass, double into, double along)
{
  return 0.5 * mass *
         (3.0 * into < along ? into * (2.0 * along - 3.0 * into) : along * along / 3.0);
}

/// Sums of loads by arc length of the profile of one sector, and by one of two more variables: the
/// place of the sector in space, or the sector. By class of balls too.
///
/// All sectors pass from one interval of places to the next at the same mill angle. So the loads of
/// an interval are summed by sector first, and `advance` adds them to both sums.
class LinerLoadSums {
 public:
  struct Size {
    int classes, sectors, bins;
    int steps;  ///< intervals of the mill angle in a pitch

    int places() const { return sectors * steps; }
  };

  explicit LinerLoadSums(const Size& size)
      : size_(size),
        present_(count(size.sectors)),
        by_sector_(count(size.sectors)),
        by_place_(count(size.places())),
        time_(static_cast<std::size_t>(size.places()))
  {
  }

  const Size& size() const { return size_; }

  /// Begin a step at this mill angle [rad], which stands for dt [s].
  void begin_step(double mill_angle, double dt)
  {
    const double turned = std::floor(mill_angle / (2.0 * pi) * size_.places());
    if (turned != turned_) {
      advance();
      turned_ = turned;
    }
    present_time_ += dt;
  }

  /// Add the loads of a contact.
  void add(int ball_class, int sector, int bin, const LinerLoads& loads)
  {
    LinerLoads& sum = present_[at(ball_class, size_.sectors, sector, bin)];
    for (std::size_t k = 0; k < liner_loads; ++k) sum[k] += loads[k];
  }

  /// Add the loads of the present interval of the mill angle to the sums.
  void advance()
  {
    if (present_time_ == 0.0) return;
    const auto places = static_cast<long>(size_.places());
    for (int sector = 0; sector < size_.sectors; ++sector) {
      const long moved = static_cast<long>(turned_) + static_cast<long>(sector) * size_.steps;
      const int place = static_cast<int>(((moved % places) + places) % places);
      time_[static_cast<std::size_t>(place)] += present_time_;
      for (int c = 0; c < size_.classes; ++c)
        for (int bin = 0; bin < size_.bins; ++bin) {
          LinerLoads& loads = present_[at(c, size_.sectors, sector, bin)];
          add_to(by_sector_[at(c, size_.sectors, sector, bin)], loads);
          add_to(by_place_[at(c, size_.places(), place, bin)], loads);
          loads = {};
        }
    }
    present_time_ = 0.0;
  }

  /// Return the loads of a sector, or of a place: interval `place` of the turn, of the angle from
  /// the place of sector 0 at mill angle 0, in the direction of rotation. Both after `advance`.
  const LinerLoads& of_sector(int ball_class, int sector, int bin) const
  {
    return by_sector_[at(ball_class, size_.sectors, sector, bin)];
  }
  const LinerLoads& of_place(int ball_class, int place, int bin) const
  {
    return by_place_[at(ball_class, size_.places(), place, bin)];
  }
  /// Return the time of all sectors in a place [s].
  double time(int place) const { return time_[static_cast<std::size_t>(place)]; }

  /// Return the sum of a load of each sector and bin.
  LinerLoads total() const
  {
    LinerLoads sum{};
    for (const auto* loads : {&by_sector_, &present_})
      for (const LinerLoads& each : *loads) add_to(sum, each);
    return sum;
  }

  /// Sums that several ranks have each a part of: loads by sector and by place. After `advance`.
  std::vector<double> parts() const
  {
    std::vector<double> numbers;
    numbers.reserve(part_count());
    for (const auto* loads : {&by_sector_, &by_place_})
      for (const LinerLoads& each : *loads) numbers.insert(numbers.end(), each.begin(), each.end());
    return numbers;
  }
  std::size_t part_count() const { return liner_loads * (by_sector_.size() + by_place_.size()); }
  void set_parts(const double* numbers)
  {
    for (auto* loads : {&by_sector_, &by_place_})
      for (LinerLoads& each : *loads) {
        std::copy_n(numbers, each.size(), each.begin());
        numbers += each.size();
      }
  }
  /// Times of the places [s], the same on all ranks.
  std::vector<double>& times() { return time_; }
  const std::vector<double>& times() const { return time_; }

 private:
  std::size_t count(int rows) const
  {
    return static_cast<std::size_t>(size_.classes) * static_cast<std::size_t>(rows) *
           static_cast<std::size_t>(size_.bins);
  }
  std::size_t at(int ball_class, int rows, int row, int bin) const
  {
    return (static_cast<std::size_t>(ball_class) * static_cast<std::size_t>(rows) +
            static_cast<std::size_t>(row)) *
               static_cast<std::size_t>(size_.bins) +
           static_cast<std::size_t>(bin);
  }
  static void add_to(LinerLoads& sum, const LinerLoads& loads)
  {
    for (std::size_t k = 0; k < loads.size(); ++k) sum[k] += loads[k];
  }

  Size size_;
  std::vector<LinerLoads> present_, by_sector_, by_place_;
  std::vector<double> time_;   ///< [s]
  double turned_ = 0.0;        ///< intervals that the mill has turned by
  double present_time_ = 0.0;  ///< of the present interval [s]
};

}  // namespace millscale::charge
