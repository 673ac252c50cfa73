#pragma once

#include <array>
#include <cmath>

namespace millscale::energy {

/// Impacts by energy on a logarithmic grid. The energy of an impact is that of the approach along
/// the normal where the contact begins, 1/2 m* v_n^2. After Kano, Saito, Powder Technology 98
/// (1998) 166-170, who take the mass of a ball and the whole relative speed. With the effective
/// mass here, a restitution e returns e^2 of the energy.
class ImpactSpectrum {
 public:
  static constexpr int per_decade = 8, decades = 14, lowest_decade = -11;
  static constexpr int bins =
      per_decade * decades;  ///< from 1e-11 J; the end bins include all beyond

  /// Return the lower edge of a bin [J]; edge(bins) is the upper edge of the last bin.
  static double edge(int bin)
  {
    return std::pow(10.0, lowest_decade + static_cast<double>(bin) / per_decade);
  }

  static int bin_of(double energy)
  {
    if (!(energy > edge(0))) return 0;
    if (!(energy < edge(bins))) return bins - 1;
    const int bin = static_cast<int>(per_decade * (std::log10(energy) - lowest_decade));
    return bin < bins ? bin : bins - 1;  // rounding at the last edge
  }

  /// share: 1/2 where another rank, or a periodic image, counts the same impact.
  void add(double energy, double share)
  {
    const int bin = bin_of(energy);
    count[bin] += share;
    energy_sum[bin] += share * energy;
  }

  std::array<double, bins> count{}, energy_sum{};  ///< [-], [J]
};

}  // namespace millscale::energy
