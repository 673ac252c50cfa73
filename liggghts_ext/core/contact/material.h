#pragma once

#include "core/math/checks.h"

namespace millscale::contact {

/// An elastic solid: Young's modulus [Pa], Poisson ratio [-], density [kg/m^3].
struct Material {
  double youngs_modulus, poisson_ratio, density;
};

/// Check a material. Throws std::invalid_argument with value and range unless E > 0, 0 <= nu <=
/// 0.5, rho > 0.
inline void check(const Material& m)
{
  require_positive("Young's modulus", "Pa", m.youngs_modulus);
  if (!(m.poisson_ratio >= 0.0 && m.poisson_ratio <= 0.5))
    reject("Poisson ratio", "must be >= 0 and <= 0.5", m.poisson_ratio);
  require_positive("density", "kg/m^3", m.density);
}

/// Return the shear modulus of an isotropic solid, E / (2 (1 + nu)) [Pa].
inline double shear_modulus(const Material& m)
{
  return m.youngs_modulus / (2.0 * (1.0 + m.poisson_ratio));
}

/// Return the effective modulus of two solids in normal contact [Pa]:
/// 1/E* = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2. Hertz; Powder Technology 335 (2018) 91-102, Table 3.
inline double effective_youngs_modulus(const Material& a, const Material& b)
{
  return 1.0 / ((1.0 - a.poisson_ratio * a.poisson_ratio) / a.youngs_modulus +
                (1.0 - b.poisson_ratio * b.poisson_ratio) / b.youngs_modulus);
}

/// Return the effective modulus of two solids in tangential contact without slip [Pa]:
/// 1/G* = (2 - nu_1)/G_1 + (2 - nu_2)/G_2. Mindlin; Powder Technology 335 (2018) 91-102, Table 3.
inline double effective_shear_modulus(const Material& a, const Material& b)
{
  return 1.0 /
         ((2.0 - a.poisson_ratio) / shear_modulus(a) + (2.0 - b.poisson_ratio) / shear_modulus(b));
}

}  // namespace millscale::contact
