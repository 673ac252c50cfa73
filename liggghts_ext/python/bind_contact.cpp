#include "core/contact/time_step.h"
#include "python/bindings.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace millscale::contact;

void millscale::python::bind_contact(nb::module_& m)
{
  nb::class_<Material>(m, "Material", "Elastic solid.")
      .def(nb::init<double, double, double>(), "youngs_modulus"_a, "poisson_ratio"_a, "density"_a)
      .def_ro("youngs_modulus", &Material::youngs_modulus, "[Pa]")
      .def_ro("poisson_ratio", &Material::poisson_ratio, "[-]")
      .def_ro("density", &Material::density, "[kg/m^3]")
      .def_prop_ro("shear_modulus", &shear_modulus, "E / (2 (1 + nu)) [Pa].");

  m.def("rayleigh_time", &rayleigh_time, "material"_a, "radius"_a,
        "Time a Rayleigh wave takes around a ball of a radius [m] [s].");
  m.def("bed_overlap", &bed_overlap, "material"_a, "gravity"_a, "depth"_a,
        "Mean overlap over ball radius [-] of a bed of a depth [m] under its own weight: "
        "1.06 (rho g d / E)^(2/3).");
  m.def("damping_ratio", &damping_ratio, "restitution"_a,
        "Damping over critical damping of the normal contact mode [-].");
  m.def(
      "hertz_overlap",
      [](const Material& material, double radius, double speed) {
        return hertz_overlap(ball_on_ball(material, radius, 1.0), speed);
      },
      "material"_a, "radius"_a, "speed"_a,
      "Largest overlap [m] of two equal balls of a radius [m] meeting at a relative speed [m/s] "
      "without damping; damping makes it smaller.");
  m.def(
      "hertz_collision_time",
      [](const Material& material, double radius, double speed) {
        return hertz_collision_time(ball_on_ball(material, radius, 1.0), speed);
      },
      "material"_a, "radius"_a, "speed"_a,
      "Duration [s] of an undamped impact of two equal balls of a radius [m] at a relative speed "
      "[m/s]: 2.94 overlap / speed.");
  m.def(
      "damping_time_step_limit",
      [](const Material& material, double radius, double restitution, double overlap,
         double coordination, bool bounded) {
        return damping_time_step_limit(ball_on_ball(material, radius, restitution), overlap,
                                       coordination, bounded);
      },
      "material"_a, "radius"_a, "restitution"_a, "overlap"_a, "coordination"_a = 1.0,
      "bounded"_a = false,
      "Largest linearly stable time step [s] of sticking contacts of equal balls of a radius [m] "
      "at "
      "an overlap [m], with a number of contacts on every ball; bounded: with the tangential "
      "damping of pair_style gran ... surface fast tangential_damping bounded.");
}
