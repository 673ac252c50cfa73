#pragma once

#include <cstddef>
#include <vector>

namespace millscale::kernels {

/// A particle's position and force in rows of whole cache lines. The engine keeps each quantity in
/// an array of its own, so that a contact would touch fourteen cache lines.
struct alignas(32) PositionRow {
  double x, y, z, radius;  ///< [m]
};
struct alignas(64) VelocityRow {
  double velocity[3], mass;       ///< [m/s], [kg]
  double spin[3], damping_share;  ///< [rad/s], `contact::damping_share` [-]
};
/// Zero between steps.
struct alignas(64) ForceRow {
  double force[4];            ///< [N]; the fourth number is padding
  double torque[3], damping;  ///< [N m]; sum of the contacts' tangential coefficients [kg/s]
};

/// The same rows in single precision, for the mixed kernel.
struct alignas(32) SingleVelocityRow {
  float velocity[3], mass, spin[3], damping_share;
};
struct alignas(32) SingleForceRow {
  float force[3], damping, torque[3], padding;
};

/// Copy a velocity row to single precision.
inline void to_single(const VelocityRow& from, SingleVelocityRow& to)
{
  for (int d = 0; d < 3; ++d) to.velocity[d] = static_cast<float>(from.velocity[d]);
  for (int d = 0; d < 3; ++d) to.spin[d] = static_cast<float>(from.spin[d]);
  to.mass = static_cast<float>(from.mass);
  to.damping_share = static_cast<float>(from.damping_share);
}

/// Rows of all particles, local and ghost. Force rows exist in one of the precisions, velocity rows
/// in one or both.
struct Rows {
  PositionRow* position;
  VelocityRow* velocity;
  ForceRow* force;
  SingleVelocityRow* single_velocity;
  SingleForceRow* single_force;
};

/// Owns the rows of a rank.
class RowStore {
 public:
  /// Make zeroed rows for `count` particles. Ghosts' force rows accumulate and are never read, so
  /// they are cleared before a ghost's row becomes that of a local particle. `double_velocities`
  /// makes the velocity rows of double precision also where the others are `single`.
  Rows resize(std::size_t count, bool single = false, bool double_velocities = false)
  {
    position_.resize(count);
    velocity_.resize(single && !double_velocities ? 0 : count);
    force_.assign(single ? 0 : count, ForceRow{});
    single_velocity_.resize(single ? count : 0);
    single_force_.assign(single ? count : 0, SingleForceRow{});
    return rows();
  }

  std::size_t bytes() const
  {
    return position_.capacity() * sizeof(PositionRow) + velocity_.capacity() * sizeof(VelocityRow) +
           force_.capacity() * sizeof(ForceRow) +
           single_velocity_.capacity() * sizeof(SingleVelocityRow) +
           single_force_.capacity() * sizeof(SingleForceRow);
  }

  Rows rows()
  {
    return {position_.data(), velocity_.data(), force_.data(), single_velocity_.data(),
            single_force_.data()};
  }

 private:
  std::vector<PositionRow> position_;
  std::vector<VelocityRow> velocity_;
  std::vector<ForceRow> force_;
  std::vector<SingleVelocityRow> single_velocity_;
  std::vector<SingleForceRow> single_force_;
};

}  // namespace millscale::kernels
