#include "liggghts/mill/mesh_walls.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "comm.h"
#include "error.h"
#include "fix_mesh_surface.h"
#include "modify.h"
#include "tri_mesh.h"

#include "core/math/constants.h"
#include "core/mesh/curvature_range.h"
#include "core/mesh/triangle.h"
#include "core/mesh/wall_around.h"

using namespace LAMMPS_NS;
using millscale::degree;
using millscale::Vector;
namespace mesh = millscale::mesh;

namespace {

// The chords of a decagon lie 5 % inside their circle. The radius of a liner with curved or worn
// plates is not known better. A wrong diameter, unit or S is farther off.
constexpr double tolerance = 0.05;
// A CAD mesh that is irregular or has a door has this wobble; a wrong origin usually has more.
constexpr double usual_wobble = 1e-3;

double FixMeshSurface::*curvature_member();

/// The engine keeps the keyword's value private; naming it in an explicit instantiation is exempt
/// from access checks, as in driver/register_styles.cpp.
template <double FixMeshSurface::*Member>
struct PrivateMember {
  friend double FixMeshSurface::*curvature_member() { return Member; }
};
template struct PrivateMember<&FixMeshSurface::curvature_>;

/// Return the fold below which the engine takes an edge for smooth [rad].
double curvature_of(const FixMeshSurface& fix)
{
  const double cosine = fix.*curvature_member();
  return std::acos(cosine > 0.0 ? cosine : 1.0 - EPSILON_CURVATURE);  // not given: the engine's
}

/// Return this rank's triangles: all before the first run, then those in its subdomain.
std::vector<mesh::Triangle> triangles_of(FixMeshSurface& fix)
{
  std::vector<mesh::Triangle> triangles(fix.triMesh()->sizeLocal());
  for (int i = 0; i < fix.triMesh()->sizeLocal(); ++i)
    for (int node = 0; node < 3; ++node) fix.triMesh()->node(i, node, triangles[i][node].data());
  return triangles;
}

/// Format to three digits, the accuracy of a measurement on a mesh.
std::string about(double x)
{
  char words[32];
  std::snprintf(words, sizeof words, std::abs(x) < 999.5 ? "%.3g" : "%.0f",
                std::abs(x) < 1e-12 ? 0.0 : x);
  return words;
}

std::string about(const Vector& v)
{
  return about(v[0]) + " " + about(v[1]) + " " + about(v[2]);
}

}  // namespace

void MeshWalls::add(const std::string& id)
{
  auto* mesh = dynamic_cast<FixMeshSurface*>(modify->find_fix_id(id.c_str()));
  if (!mesh)
    throw std::invalid_argument("mesh '" + id +
                                "' is not the id of a fix mesh/surface defined before this fix");
  if (mesh->mesh()->isMoving() || mesh->surfaceVel())
    throw std::invalid_argument("mesh '" + id +
                                "' is moved already, by a fix move/mesh or a surface "
                                "velocity; remove that");
  fixes_.push_back(mesh);
  ids_.push_back(id);
}

std::vector<FixMeshSurface*> MeshWalls::present() const
{
  std::vector<FixMeshSurface*> found;
  for (std::size_t m = 0; m < fixes_.size(); ++m)
    if (modify->find_fix_id(ids_[m].c_str()) == fixes_[m] && fixes_[m]->mesh()->isMoving())
      found.push_back(fixes_[m]);
  return found;
}

void MeshWalls::check_present() const
{
  const std::vector<FixMeshSurface*> found = present();
  for (std::size_t m = 0; m < fixes_.size(); ++m)
    if (std::find(found.begin(), found.end(), fixes_[m]) == found.end())
      throw std::invalid_argument("mesh '" + ids_[m] +
                                  "' was removed or defined anew; define fix mill/similarity again "
                                  "after it, without `unfix` of the mesh alone");
}

void MeshWalls::check(const Mill& mill, const Warn& warn)
{
  mill_ = mill;
  if (fixes_.empty()) return;
  for (std::size_t m = 0; m < fixes_.size(); ++m) check_curvature(*fixes_[m], ids_[m]);
  check_centre(warn);
  check_radius(warn);
}

void MeshWalls::check_curvature(FixMeshSurface& fix, const std::string& id) const
{
  const mesh::CurvatureRange range = mesh::curvature_range(triangles_of(fix), mill_.axis);
  double high = range.high;
  MPI_Allreduce(MPI_IN_PLACE, &high, 1, MPI_DOUBLE, MPI_MIN, world);
  const double curvature = curvature_of(fix);
  if (!(curvature >= high)) return;
  double low = range.low < high ? range.low : 0.0;
  MPI_Allreduce(MPI_IN_PLACE, &low, 1, MPI_DOUBLE, MPI_MAX, world);
  const double advised = low > 0.0 ? std::sqrt(low * high) : 0.5 * high;
  throw std::invalid_argument(
      "mesh '" + id + "': curvature: got " + about(curvature / degree) + " degrees, accepted is " +
      about(low / degree) + " to " + about(high / degree) +
      ", the largest valley and the smallest ridge that the mesh folds by: over a ridge that "
      "counts "
      "as smooth a ball has no contact and falls through; give `curvature " +
      about(advised / degree) + "` to fix mesh/surface");
}

Vector MeshWalls::centre() const
{
  mesh::AreaSums sums;
  for (FixMeshSurface* fix : fixes_)
    for (const mesh::Triangle& t : triangles_of(*fix)) sums.add(t);
  MPI_Allreduce(MPI_IN_PLACE, &sums.area, 1, MPI_DOUBLE, MPI_SUM, world);
  MPI_Allreduce(MPI_IN_PLACE, sums.moment.data(), 3, MPI_DOUBLE, MPI_SUM, world);
  return sums.area > 0.0 ? sums.centre() : mill_.axis.origin;
}

double MeshWalls::wobble_now() const
{
  const Vector off = mill_.axis.radial(centre());
  return std::sqrt(millscale::dot(off, off)) / mill_.radius;
}

void MeshWalls::check_centre(const Warn& warn)
{
  const double wobble = wobble_ = wobble_now();
  if (wobble <= usual_wobble) return;
  const std::string found = "the centre of the meshes' area is " + about(wobble * mill_.radius) +
                            " m off the axis, " + about(wobble) +
                            " of the scaled mill's radius (f_ID[14])";
  const std::string advice =
      "give `origin " + about(centre()) +
      "`, or check axis, move and scale of fix mesh/surface, and the mesh for missing parts";
  if (wobble > tolerance)
    throw std::invalid_argument("origin: " + found + ", accepted is " + about(tolerance) + "; " +
                                advice);
  warn("origin: " + found + ", so the mesh wobbles; if the liner is the same all around, " +
       advice);
}

void MeshWalls::check_radius(const Warn& warn)
{
  const mesh::Axis& axis = mill_.axis;
  double ends[2] = {INFINITY, INFINITY};  // lower, and minus the upper
  for (FixMeshSurface* fix : fixes_)
    for (const mesh::Triangle& t : triangles_of(*fix))
      for (const Vector& node : t) {
        ends[0] = std::min(ends[0], axis.along(node));
        ends[1] = std::min(ends[1], -axis.along(node));
      }
  MPI_Allreduce(MPI_IN_PLACE, ends, 2, MPI_DOUBLE, MPI_MIN, world);
  low_ = ends[0];
  high_ = -ends[1];
  mesh::WallAround around(axis, low_, high_);
  for (FixMeshSurface* fix : fixes_)
    for (const mesh::Triangle& t : triangles_of(*fix)) around.add(t);
  std::vector<double>& nearest = around.nearest();
  MPI_Allreduce(MPI_IN_PLACE, nearest.data(), static_cast<int>(nearest.size()), MPI_DOUBLE, MPI_MIN,
                world);
  if (low_ > high_)
    throw std::invalid_argument(
        "mesh: the engine found no triangle in the files of the meshes; export them as text, or "
        "begin the header of a binary file with a word that is not `solid`");
  const double factor = around.radius() / mill_.radius;
  if (!(std::abs(factor - 1.0) <= tolerance))
    throw std::invalid_argument(
        "radius: the wall of the meshes is " + about(around.radius()) +
        " m from the axis, that of the scaled mill " + about(mill_.radius) + " m, a factor of " +
        about(factor) + ", accepted is " + about(1.0 - tolerance) + " to " +
        about(1.0 + tolerance) + "; " +
        mesh::advice_on_factor(factor, mill_.S, about(factor * mill_.physical_radius)));
  if (around.open() > 0.0)
    warn("mesh: from the axis no wall is seen in " + about(100.0 * around.open()) +
         " % of the directions; if the liner has no openings, check mesh, axis and origin");
}

bool MeshWalls::past_end(const Vector& point) const
{
  const double along = mill_.axis.along(point);
  return along < low_ || along > high_;
}

bool MeshWalls::in_direction(const Vector& point) const
{
  const mesh::Axis& axis = mill_.axis;
  for (FixMeshSurface* fix : fixes_)
    for (const mesh::Triangle& t : triangles_of(*fix))
      if (mesh::in_direction(t, axis, point)) return true;
  return false;
}
