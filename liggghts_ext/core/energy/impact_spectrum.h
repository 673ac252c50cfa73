#pragma once

#include <array>
#include <cmath>

namespace millscale::ledger {

/// Impacts by their energy on a logarithmic grid. An impact's energy is that of the approach along
/// the normal at first touch, 1/2 m* v_n^2: what the contact could take at most from a head-on
/// impact. After Kano, Saito, Powder Technology 98 (1998) 166-170, who take the mass of a ball and
/// the whole relative speed; here the effective mass, so that e^2 of it is given back.
class ImpactSpectrum {
 public:
  static constexpr int per_decade = 8, decades = 14, lowest_decade = -11;
  static constexpr int bins = per_decade * decades;  ///< from 1e-11 J; the ends take what is beyond

  /// Lower edge of a bin [J]; of the one after the last: upper edge of the last.
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

}  // namespace millscale::ledger
