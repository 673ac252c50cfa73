#pragma once

#include <cmath>
#include <vector>

#include "core/energy/impact_spectrum.h"

namespace millscale::energy {

/// Which bodies touch, by the atom types of the balls from 1; `wall` for liner and ends.
struct ImpactClass {
  static constexpr int wall = 0;
  int first, second;  ///< second >= first, or `wall`
};

/// The classes of contacts of balls of some types: each type with itself and those above it, then
/// each type with the wall.
class ImpactClasses {
 public:
  explicit ImpactClasses(int types) : types_(types) {}

  int count() const { return types_ * (types_ + 1) / 2 + types_; }

  int of_balls(int a, int b) const
  {
    const int low = a < b ? a : b, high = a < b ? b : a;
    return (low - 1) * types_ - (low - 1) * (low - 2) / 2 + high - low;
  }
  int on_wall(int type) const { return types_ * (types_ + 1) / 2 + type - 1; }

  ImpactClass at(int index) const
  {
    for (int a = 1; a <= types_; ++a) {
      if (index == on_wall(a)) return {a, ImpactClass::wall};
      for (int b = a; b <= types_; ++b)
        if (index == of_balls(a, b)) return {a, b};
    }
    return {0, 0};
  }

 private:
  int types_;
};

/// Contacts of one class that ended, by the energy they dissipated and by the energy of their
/// approach.
struct ImpactSpectra {
  ImpactSpectrum dissipated, available;

  /// share: 1/2 where another rank, or a periodic image, counts the same contact.
  void add(double energy_dissipated, double energy_available, double share)
  {
    dissipated.add(energy_dissipated, share);
    available.add(energy_available, share);
  }
};

/// Sums over the contacts of one pairing of a rank since the begin of the measurement.
struct ImpactTotals {
  double contacts = 0.0;    ///< that ended [-]
  double available = 0.0;   ///< of these [J]
  double dissipated = 0.0;  ///< of these [J]
  double work = 0.0;        ///< against the loads of all contacts, ended or not [J]

  void add(double energy_dissipated, double energy_available, double share)
  {
    contacts += share;
    available += share * energy_available;
    dissipated += share * energy_dissipated;
  }
};

}  // namespace millscale::energy
