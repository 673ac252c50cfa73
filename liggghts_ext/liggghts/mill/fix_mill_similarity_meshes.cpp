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
#include "liggghts/mill/fix_mill_similarity.h"

using namespace LAMMPS_NS;
using millscale::degree;
using millscale::Vector;
namespace mesh = millscale::mesh;

namespace {

// The chords of a polygon of ten sides lie 5 % inside their circle; a liner's radius is not known
// better than that where plates are curved or worn. A diameter, a unit or S is farther off.
constexpr double tolerance = 0.05;
// What a mesh of CAD that is not regular, or has a door, has; a wrong origin is mostly more.
constexpr double usual_wobble = 1e-3;

double FixMeshSurface::*curvature_member();

/// The engine keeps the keyword's value private; naming it in an explicit instantiation is exempt
/// from access checks, as in driver/register_styles.cpp.
template <double FixMeshSurface::*Member>
struct PrivateMember {
  friend double FixMeshSurface::*curvature_member() { return Member; }
};
template struct PrivateMember<&FixMeshSurface::curvature_>;

/// Folds of less count as smooth [rad].
double curvature_of(const FixMeshSurface& fix)
{
  const double cosine = fix.*curvature_member();
  return std::acos(cosine > 0.0 ? cosine : 1.0 - EPSILON_CURVATURE);  // not given: the engine's
}

/// Of this rank: all before the first run, then those in its part of the box.
std::vector<mesh::Triangle> triangles_of(FixMeshSurface& fix)
{
  std::vector<mesh::Triangle> triangles(fix.triMesh()->sizeLocal());
  for (int i = 0; i < fix.triMesh()->sizeLocal(); ++i)
    for (int node = 0; node < 3; ++node) fix.triMesh()->node(i, node, triangles[i][node].data());
  return triangles;
}

/// To three digits: what is measured on a mesh is not known better.
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

/// Throws std::invalid_argument if a fix was removed or is another one by now.
void FixMillSimilarity::check_meshes_are_there() const
{
  for (std::size_t m = 0; m < meshes_.size(); ++m)
    if (modify->find_fix_id(mesh_ids_[m].c_str()) != meshes_[m] || !meshes_[m]->mesh()->isMoving())
      throw std::invalid_argument("mesh '" + mesh_ids_[m] +
                                  "' was removed or defined anew; define fix mill/similarity again "
                                  "after it, without `unfix` of the mesh alone");
}

void FixMillSimilarity::check_meshes()
{
  if (meshes_.empty()) return;
  for (std::size_t m = 0; m < meshes_.size(); ++m) check_curvature(*meshes_[m], mesh_ids_[m]);
  check_centre();
  check_radius();
}

void FixMillSimilarity::check_curvature(FixMeshSurface& fix, const std::string& id) const
{
  const mesh::CurvatureRange range = mesh::curvature_range(triangles_of(fix), {axis_, origin_});
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

Vector FixMillSimilarity::centre_of_meshes() const
{
  mesh::AreaSums sums;
  for (FixMeshSurface* fix : meshes_)
    for (const mesh::Triangle& t : triangles_of(*fix)) sums.add(t);
  MPI_Allreduce(MPI_IN_PLACE, &sums.area, 1, MPI_DOUBLE, MPI_SUM, world);
  MPI_Allreduce(MPI_IN_PLACE, sums.moment.data(), 3, MPI_DOUBLE, MPI_SUM, world);
  return sums.area > 0.0 ? sums.centre() : origin_;
}

double FixMillSimilarity::wobble_of_meshes() const
{
  const Vector off = mesh::Axis{axis_, origin_}.radial(centre_of_meshes());
  return std::sqrt(millscale::dot(off, off)) / scaled_.mill.radius;
}

void FixMillSimilarity::check_centre()
{
  const double wobble = wobble_ = wobble_of_meshes();
  if (wobble <= usual_wobble) return;
  const std::string found = "the centre of the meshes' area is " +
                            about(wobble * scaled_.mill.radius) + " m off the axis, " +
                            about(wobble) + " of the scaled mill's radius (f_ID[14])";
  const std::string advice =
      "give `origin " + about(centre_of_meshes()) +
      "`, or check axis, move and scale of fix mesh/surface, and the mesh for missing parts";
  if (wobble > tolerance)
    throw std::invalid_argument("origin: " + found + ", accepted is " + about(tolerance) + "; " +
                                advice);
  warn("origin: " + found + ", so the mesh wobbles; if the liner is the same all around, " +
       advice);
}

void FixMillSimilarity::check_radius()
{
  const mesh::Axis axis{axis_, origin_};
  double ends[2] = {INFINITY, INFINITY};  // lower, and minus the upper
  for (FixMeshSurface* fix : meshes_)
    for (const mesh::Triangle& t : triangles_of(*fix))
      for (const Vector& node : t) {
        ends[0] = std::min(ends[0], axis.along(node));
        ends[1] = std::min(ends[1], -axis.along(node));
      }
  MPI_Allreduce(MPI_IN_PLACE, ends, 2, MPI_DOUBLE, MPI_MIN, world);
  mesh_low_ = ends[0];
  mesh_high_ = -ends[1];
  mesh::WallAround around(axis, mesh_low_, mesh_high_);
  for (FixMeshSurface* fix : meshes_)
    for (const mesh::Triangle& t : triangles_of(*fix)) around.add(t);
  std::vector<double>& nearest = around.nearest();
  MPI_Allreduce(MPI_IN_PLACE, nearest.data(), static_cast<int>(nearest.size()), MPI_DOUBLE, MPI_MIN,
                world);
  if (mesh_low_ > mesh_high_)
    throw std::invalid_argument(
        "mesh: the engine found no triangle in the files of the meshes; export them as text, or "
        "begin the header of a binary file with a word that is not `solid`");
  const double factor = around.radius() / scaled_.mill.radius;
  if (!(std::abs(factor - 1.0) <= tolerance))
    throw std::invalid_argument("radius: the wall of the meshes is " + about(around.radius()) +
                                " m from the axis, that of the scaled mill " +
                                about(scaled_.mill.radius) + " m, a factor of " + about(factor) +
                                ", accepted is " + about(1.0 - tolerance) + " to " +
                                about(1.0 + tolerance) + "; " +
                                mesh::advice_on_factor(factor, 1.0 / scaled_.base.length,
                                                       about(factor * physical_radius_)));
  if (around.open() > 0.0)
    warn("mesh: from the axis no wall is seen in " + about(100.0 * around.open()) +
         " % of the directions; if the liner has no openings, check mesh, axis and origin");
}

bool FixMillSimilarity::past_mesh_end(const Vector& point) const
{
  const double along = mesh::Axis{axis_, origin_}.along(point);
  return along < mesh_low_ || along > mesh_high_;
}

bool FixMillSimilarity::mesh_in_direction(const Vector& point) const
{
  const mesh::Axis axis{axis_, origin_};
  for (FixMeshSurface* fix : meshes_)
    for (const mesh::Triangle& t : triangles_of(*fix))
      if (mesh::in_direction(t, axis, point)) return true;
  return false;
}

void FixMillSimilarity::warn(const std::string& message) const
{
  const std::string words = std::string("Fix ") + style + " (id " + id + "): " + message;
  if (comm->me == 0) error->warning(FLERR, words.c_str());
}
