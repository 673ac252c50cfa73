#include "liggghts/common/contact_laws.h"

#include "atom.h"
#include "fix_property_global.h"
#include "lammps.h"
#include "modify.h"

#include "core/contact/hertz_mindlin.h"

namespace contact = millscale::contact;

namespace LAMMPS_NS {

namespace {

/// Return a property of pairs of types, (types, types), or zeros if not `wanted`.
std::vector<double> of_pairs(LAMMPS* engine, const char* asker, const char* name, bool wanted)
{
  const int types = engine->atom->ntypes;
  std::vector<double> values(types * types, 0.0);
  if (!wanted) return values;
  auto* fix = static_cast<FixPropertyGlobal*>(engine->modify->find_fix_property(
      name, "property/global", "peratomtypepair", types, types, asker));
  for (int a = 0; a < types; ++a)
    for (int b = 0; b < types; ++b) values[a * types + b] = fix->compute_array(a, b);
  return values;
}

}  // namespace

std::vector<contact::ContactLaw<double>> contact_laws(LAMMPS* engine, const char* asker,
                                                      bool sliding, bool rolling)
{
  const int types = engine->atom->ntypes;
  const auto of_types = [&](const char* name) {
    return static_cast<FixPropertyGlobal*>(
        engine->modify->find_fix_property(name, "property/global", "peratomtype", types, 0, asker));
  };
  FixPropertyGlobal *modulus = of_types("youngsModulus"), *poisson = of_types("poissonsRatio");
  const auto material = [&](int t) {
    return contact::Material{modulus->compute_vector(t), poisson->compute_vector(t), 1.0};
  };
  const auto restitution = of_pairs(engine, asker, "coefficientRestitution", true);
  const auto slide = of_pairs(engine, asker, "coefficientFriction", sliding);
  const auto roll = of_pairs(engine, asker, "coefficientRollingFriction", rolling);
  std::vector<contact::ContactLaw<double>> laws;
  for (int a = 0; a < types; ++a)
    for (int b = 0; b < types; ++b) {
      const int ab = a * types + b;
      laws.push_back(
          contact::contact_law({contact::effective_youngs_modulus(material(a), material(b)),
                                contact::effective_shear_modulus(material(a), material(b)),
                                contact::damping_factor(restitution[ab]), slide[ab], roll[ab]}));
    }
  return laws;
}

}  // namespace LAMMPS_NS
