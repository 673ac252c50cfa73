#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <tuple>
#include <vector>

#include "core/similarity/law.h"
#include "core/similarity/rotation.h"
#include "core/similarity/speed_schedule.h"
#include "python/bindings.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace millscale::similarity;
using millscale::format;

namespace {

std::string describe(const OperatingPoint& p)
{
  return "OperatingPoint(radius=" + format(p.radius) + ", ball_radius=" + format(p.ball_radius) +
         ", gravity=" + format(p.gravity) + ", omega=" + format(p.omega) + ")";
}

std::string describe(const BaseFactors& b)
{
  return "BaseFactors(length=" + format(b.length) + ", mass=" + format(b.mass) +
         ", time=" + format(b.time) + ")";
}

std::string describe(const ScaledMill& s)
{
  return "ScaledMill(mill=" + describe(s.mill) + ", base=" + describe(s.base) +
         ", froude=" + format(s.froude) +
         ", predicted_energy_ratio=" + format(s.predicted_energy_ratio) +
         ", centre_path_energy_ratio=" + format(s.centre_path_energy_ratio) +
         ", friction_ratio=" + format(s.friction_ratio) + ")";
}

ScaledMill scale_by_names(const OperatingPoint& physical, double S, const std::string& scheme_name,
                          const std::string& policy_name, double time_factor,
                          bool allow_centrifuging, double friction_exponent)
{
  return scale(physical, {S, scheme_from_name(scheme_name), policy_from_name(policy_name),
                          time_factor, allow_centrifuging, friction_exponent});
}

void bind_types(nb::module_& m)
{
  nb::class_<OperatingPoint>(m, "OperatingPoint", "A mill in operation.")
      .def(nb::init<double, double, double, double>(), "radius"_a, "ball_radius"_a, "gravity"_a,
           "omega"_a)
      .def_ro("radius", &OperatingPoint::radius, "Radius at the liner [m].")
      .def_ro("ball_radius", &OperatingPoint::ball_radius, "Ball radius [m].")
      .def_ro("gravity", &OperatingPoint::gravity, "Gravity [m/s^2].")
      .def_ro("omega", &OperatingPoint::omega, "Speed of rotation [rad/s].")
      .def("__repr__", [](const OperatingPoint& p) { return describe(p); });

  nb::class_<BaseFactors>(m, "BaseFactors",
                          "Factors physical -> scaled of length, mass (of one ball) and time [-].")
      .def(nb::init<double, double, double>(), "length"_a, "mass"_a, "time"_a)
      .def_ro("length", &BaseFactors::length, "Of the mill's dimensions [-].")
      .def_ro("mass", &BaseFactors::mass, "Of one ball's mass [-]: 1, balls are not scaled.")
      .def_ro("time", &BaseFactors::time, "Of the time a process takes [-].")
      .def("__repr__", [](const BaseFactors& b) { return describe(b); });

  nb::class_<ScaledMill>(m, "ScaledMill", "A scaled mill and the law that led to it.")
      .def_ro("mill", &ScaledMill::mill, "The scaled mill (OperatingPoint), ball radius unchanged.")
      .def_ro("base", &ScaledMill::base, "BaseFactors of the path the law is applied to.")
      .def_ro("froude", &ScaledMill::froude, "omega^2 R / g of the scaled mill [-].")
      .def_ro("predicted_energy_ratio", &ScaledMill::predicted_energy_ratio,
              "Energy change of a ball, scaled / physical, from S alone [-].")
      .def_ro("centre_path_energy_ratio", &ScaledMill::centre_path_energy_ratio,
              "The same from the factors of the path of the ball's centre [-].")
      .def_ro("friction_ratio", &ScaledMill::friction_ratio,
              "Sliding friction between balls, scaled / physical [-].")
      .def("__repr__", [](const ScaledMill& s) { return describe(s); });
}

void bind_schedule(nb::module_& m)
{
  using Change = std::tuple<double, double, double>;
  nb::class_<SpeedSchedule>(
      m, "SpeedSchedule",
      "Speed of a mill against its angle, over its constant speed omega. The phase is omega times\n"
      "the time since the start [rad].")
      .def(
          "__init__",
          [](SpeedSchedule* self, const std::vector<Change>& changes) {
            std::vector<SpeedChange> list;
            for (const auto& [from, over, ratio] : changes) list.push_back({from, over, ratio});
            new (self) SpeedSchedule(list);
          },
          "changes"_a,
          "changes: (from, over, ratio), ascending: mill angle at which a change begins, mill\n"
          "angle of the change [rad], speed afterwards over omega. A first change at angle 0\n"
          "starts from rest.")
      .def("angle", &SpeedSchedule::angle, "phase"_a, "Mill angle at a phase [rad].")
      .def("phase", &SpeedSchedule::phase, "angle"_a, "Phase at a mill angle [rad].")
      .def("speed", &SpeedSchedule::speed, "phase"_a, "Speed over omega at a phase.")
      .def_prop_ro("fastest", &SpeedSchedule::fastest, "Largest speed over omega.")
      .def_prop_ro("steady_from", &SpeedSchedule::steady_from,
                   "Mill angle from which on the speed is constant [rad].")
      .def_prop_ro("last_ratio", &SpeedSchedule::last_ratio, "Speed over omega at the end.");
  m.def("nearest_step", &Rotation::nearest_step, "steps"_a,
        "Whole number of steps nearest to a number of steps, as the engine rounds it.");
}

}  // namespace

void millscale::python::bind_similarity(nb::module_& m)
{
  bind_types(m);
  bind_schedule(m);
  m.def(
      "scale", &scale_by_names, "physical"_a, "S"_a, "scheme"_a = "constant-gravity",
      "policy"_a = "paper", "time_factor"_a = 0.0, "allow_centrifuging"_a = false,
      "friction_exponent"_a = 1.0,
      "The scaled mill that keeps the physical mill's Froude number, as ScaledMill.\n\n"
      "S: physical radius / scaled radius, >= 1.\n"
      "scheme: constant-gravity, constant-speed, or froude (with time_factor, scaled / physical).\n"
      "policy: paper, corrected, offset-liner or friction-matched; what is done about the ball\n"
      "radius, which stays.\n"
      "allow_centrifuging: accept a Froude number of 1 or more.\n"
      "friction_exponent: k of S^-k, policy friction-matched; > 0 and <= 2.");
  m.def(
      "factor",
      [](const BaseFactors& base, int length, int mass, int time) {
        return factor(base, {length, mass, time});
      },
      "base"_a, "length"_a, "mass"_a, "time"_a,
      "Factor of a quantity from its exponents in length, mass and time; force is (1, 1, -2).");
  m.def("froude_number", nb::overload_cast<double, double, double>(&froude_number), "radius"_a,
        "gravity"_a, "omega"_a, "omega^2 R / g [-]; radius [m], gravity [m/s^2], omega [rad/s].");
  m.def("detach_angle", &detach_angle, "froude"_a,
        "Angle from the vertical at which a point mass leaves the liner, arccos(Fr) [rad].");
  m.def("critical_speed", &critical_speed, "operating_point"_a,
        "Speed at which a ball on the liner centrifuges, sqrt(g / (R - a)) [rad/s].");
  m.def(
      "regime", [](double froude) { return std::string(name(regime(froude))); }, "froude"_a,
      "Motion of the charge by Froude number: 'slipping or cascading', 'cataracting' or "
      "'centrifuging'.");
}
