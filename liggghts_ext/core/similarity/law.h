#pragma once

#include <cmath>
#include <stdexcept>
#include <string>

#include "core/math/checks.h"
#include "core/math/format.h"
#include "core/similarity/dimension.h"
#include "core/similarity/operating_point.h"

namespace millscale::similarity {

/// How gravity and speed are scaled. `froude` takes the time factor from the caller.
enum class Scheme { constant_gravity, constant_speed, froude };

/// How the law treats the ball radius, which is not scaled.
///   paper         the law for point masses, as printed
///   corrected     the law for the path of the ball's centre, R - a, in the geometrically scaled
///                 mill
///   offset_liner  the liner is built so that the centre path, R - a, scales by S exactly
///   friction_matched  the paper's law, and the sliding friction between balls divided by S^k: the
///                 inertial number of the flowing layer grows as S and with it the effective
///                 friction of the charge, which this takes back
enum class Policy { paper, corrected, offset_liner, friction_matched };

inline Scheme scheme_from_name(const std::string& name)
{
  if (name == "constant-gravity") return Scheme::constant_gravity;
  if (name == "constant-speed") return Scheme::constant_speed;
  if (name == "froude") return Scheme::froude;
  throw std::invalid_argument("scheme: got '" + name +
                              "', accepted are constant-gravity, constant-speed, froude");
}

inline Policy policy_from_name(const std::string& name)
{
  if (name == "paper") return Policy::paper;
  if (name == "corrected") return Policy::corrected;
  if (name == "offset-liner") return Policy::offset_liner;
  if (name == "friction-matched") return Policy::friction_matched;
  throw std::invalid_argument("policy: got '" + name +
                              "', accepted are paper, corrected, offset-liner, friction-matched");
}

/// Settings of a scaled mill, beside the physical mill.
struct ScalingRequest {
  double S = 1.0;  ///< radius ratio physical / scaled, S >= 1 [-]
  Scheme scheme = Scheme::constant_gravity;
  Policy policy = Policy::paper;
  double time_factor = 0.0;         ///< scaled / physical time, scheme `froude` only [-]
  bool allow_centrifuging = false;  ///< accept Fr >= 1
  double friction_exponent = 1.0;   ///< k, policy `friction_matched` only [-]
};

/// Largest accepted k. Measured are 1.1 to 1.2. At k = 2 and S = 2.6 a seventh of the friction is
/// left, less than any charge that was measured asks for (docs/theory/similarity-law.md).
inline constexpr double largest_friction_exponent = 2.0;

/// A scaled mill and its similarity law.
struct ScaledMill {
  OperatingPoint mill;            ///< the scaled mill, its ball radius that of the physical one
  BaseFactors base;               ///< factors of the path the law is applied to (see Policy)
  double froude;                  ///< omega^2 R / g of the scaled mill
  double predicted_energy_ratio;  ///< Eq. 15: change of energy of one ball, scaled / physical, from
                                  ///< S alone
  double centre_path_energy_ratio;  ///< energy ratio from the factors of the centre path, R - a
  double friction_ratio;  ///< sliding friction between balls, scaled / physical (see Policy)
};

/// Return the base factors (length, mass, time) at a length factor. Source: Powder Technology 335
/// (2018) 91-102, Eqs. 10 and 11, generalised. An equal Froude number with a free time factor gives
/// omega' = omega / tau and g' = g length / tau^2.
inline BaseFactors base_factors(double length, Scheme scheme, double time_factor)
{
  switch (scheme) {
    case Scheme::constant_gravity:
      return {length, 1.0, std::sqrt(length)};
    case Scheme::constant_speed:
      return {length, 1.0, 1.0};
    case Scheme::froude:
      if (!(time_factor > 0.0 && std::isfinite(time_factor)))
        throw std::invalid_argument("time factor: scheme froude needs one > 0, got " +
                                    format(time_factor));
      return {length, 1.0, time_factor};
  }
  throw std::invalid_argument("scheme: unknown");
}

namespace detail {

inline void check(const OperatingPoint& physical, const ScalingRequest& request)
{
  require_positive("mill radius", "m", physical.radius);
  require_positive("ball radius", "m", physical.ball_radius);
  require_positive("gravity", "m/s^2", physical.gravity);
  require_positive("speed", "rad/s", physical.omega);
  if (!(request.S >= 1.0 && std::isfinite(request.S)))
    reject("S", "must be >= 1 (S = physical radius / scaled radius)", request.S);
  if (request.scheme != Scheme::froude && request.time_factor != 0.0)
    throw std::invalid_argument("time factor: only scheme froude takes one, got " +
                                format(request.time_factor));
  const double k = request.friction_exponent;
  if (!(k > 0.0 && k <= largest_friction_exponent))
    reject("friction exponent", "must be > 0 and <= " + format(largest_friction_exponent), k);
  if (request.policy != Policy::friction_matched && k != 1.0)
    throw std::invalid_argument("friction exponent: only policy friction-matched takes one, got " +
                                format(k));
  const double radius = physical.radius / request.S;
  if (!(radius > physical.ball_radius))
    throw std::invalid_argument("S: the scaled mill radius " + format(radius) +
                                " m must exceed the ball radius " + format(physical.ball_radius) +
                                " m, so S < " + format(physical.radius / physical.ball_radius) +
                                ", got S = " + format(request.S));
  const double fr = froude_number(physical);
  if (fr >= 1.0 && !request.allow_centrifuging)
    throw std::invalid_argument(
        "speed: Froude number omega^2 R / g = " + format(fr) +
        " is 1 or more, the mill centrifuges and no ball detaches. Was the speed meant in rpm? "
        "To run it all the same: `centrifuging allow` in a deck, allow_centrifuging = true in a "
        "campaign file");
}

}  // namespace detail

/// Return the scaled mill with the physical mill's Froude number (of R, or of R - a: see Policy).
/// Throws std::invalid_argument with the value and the accepted range: S < 1, R/S <= a, Fr >= 1
/// without permission, non-positive input. Source: Powder Technology 335 (2018) 91-102, Eqs. 5-15;
/// policies derived here. The friction ratio S^-k is empirical: measured for S up to 3.1 and
/// coefficients of 0.4 to 0.55 (docs/theory/similarity-law.md).
inline ScaledMill scale(const OperatingPoint& physical, const ScalingRequest& request)
{
  detail::check(physical, request);
  const double a = physical.ball_radius;
  const double geometric = 1.0 / request.S;
  const double radius = request.policy == Policy::offset_liner
                            ? (physical.radius - a) / request.S + a
                            : physical.radius / request.S;
  const double centre_path = (radius - a) / (physical.radius - a);
  const double length = request.policy == Policy::corrected ? centre_path : geometric;

  ScaledMill scaled{};
  scaled.base = base_factors(length, request.scheme, request.time_factor);
  scaled.mill = {radius, a, physical.gravity * factor(scaled.base, dimension::acceleration),
                 physical.omega * factor(scaled.base, dimension::angular_velocity)};
  scaled.froude = froude_number(scaled.mill);
  scaled.predicted_energy_ratio =
      factor(base_factors(geometric, request.scheme, request.time_factor), dimension::energy);
  // Energy per mass is gravity times height, and heights follow the centre path in every policy.
  scaled.centre_path_energy_ratio = factor(scaled.base, dimension::acceleration) * centre_path;
  scaled.friction_ratio = request.policy == Policy::friction_matched
                              ? std::pow(geometric, request.friction_exponent)
                              : 1.0;
  return scaled;
}

}  // namespace millscale::similarity
