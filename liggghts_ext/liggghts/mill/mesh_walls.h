#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pointers.h"

#include "core/mesh/triangle.h"

namespace LAMMPS_NS {

class FixMeshSurface;

/// The engine's wall meshes that turn with the mill, and their checks against the mill.
class MeshWalls : protected Pointers {
 public:
  /// The mill that the meshes must fit.
  struct Mill {
    millscale::mesh::Axis axis;
    double radius;           ///< scaled [m]
    double physical_radius;  ///< [m]
    double S;                ///< physical / scaled
  };
  using Warn = std::function<void(const std::string&)>;

  explicit MeshWalls(class LAMMPS* lmp) : Pointers(lmp) {}

  /// Add the fix mesh/surface with this id. Throws std::invalid_argument if there is none, or if
  /// another fix moves it.
  void add(const std::string& id);

  /// Check ridges, centre and radius of the meshes against the mill. Throws std::invalid_argument.
  void check(const Mill& mill, const Warn& warn);

  /// Check that all fixes exist. Throws std::invalid_argument if one was removed or defined again.
  void check_present() const;

  /// Return the fixes that exist and move.
  std::vector<FixMeshSurface*> present() const;
  const std::vector<FixMeshSurface*>& fixes() const { return fixes_; }

  /// Distance of the meshes' centre from the axis over the mill's radius at the check [-].
  double wobble() const { return wobble_; }
  /// Return the same distance at this step.
  double wobble_now() const;
  /// Return whether a point is beyond the ends of the meshes along the axis.
  bool past_end(const millscale::Vector& point) const;
  /// Return whether a mesh on this rank has a triangle in the direction of a point from the axis.
  bool in_direction(const millscale::Vector& point) const;

 private:
  void check_curvature(FixMeshSurface&, const std::string& id) const;
  void check_centre(const Warn& warn);
  void check_radius(const Warn& warn);
  millscale::Vector centre() const;

  Mill mill_{};
  std::vector<FixMeshSurface*> fixes_;
  std::vector<std::string> ids_;
  double wobble_ = 0.0, low_ = 0.0, high_ = 0.0;  ///< low, high: along the axis [m]
};

}  // namespace LAMMPS_NS
