#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "atom.h"
#include "domain.h"
#include "fix_mill_similarity.h"
#include "fix_wall_mill.h"
#include "liner/groove_box.h"

using namespace LAMMPS_NS;
namespace liner = millscale::liner;
using millscale::format;
using millscale::Vector;

/// The liner, and its ends if it has any, lie in the box. Sides that follow the balls cannot tell.
void FixWallMill::check_box() const
{
  const Vector &axis = mill_fix_->axis(), &origin = mill_fix_->origin();
  for (int d = 0; d < 3; ++d) {
    const bool crosses = std::abs(axis[d]) < 1e-9;
    if (!crosses && !ends_) continue;  // endless in this direction
    const double across = liner_->radius() * std::sqrt(std::max(0.0, 1.0 - axis[d] * axis[d]));
    const double one = ends_ ? axis[d] * ends_->low : 0.0,
                 other = ends_ ? axis[d] * ends_->high : 0.0;
    const double low = origin[d] - across + std::min(one, other);
    const double high = origin[d] + across + std::max(one, other);
    const double box_low = domain->boxlo[d], box_high = domain->boxhi[d];
    // A box as long as the mill may differ from it by rounding.
    const double rounding = 1e-12 * (box_high - box_low);
    const bool below = low < box_low - rounding && domain->boundary[d][0] < 2;
    const bool above = high > box_high + rounding && domain->boundary[d][1] < 2;
    if (below || above)
      throw std::invalid_argument(
          std::string(crosses ? "the liner" : "the ends of the mill") + " must lie in the box, " +
          format(box_low) + " to " + format(box_high) + " m in " + "xyz"[d] + ", got " +
          format(low) + " to " + format(high) +
          " m; enlarge the box (command region) or check the mill's radius, origin and ends");
  }
}

/// The largest ball of all ranks has room in groove, drum and between the ends.
void FixWallMill::check_balls_fit() const
{
  double largest = 0.0;
  for (int i = 0; i < atom->nlocal; ++i)
    if (atom->mask[i] & groupbit) largest = std::max(largest, atom->radius[i]);
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, world);
  const auto require = [largest](double widest, const std::string& where) {
    if (largest >= widest)
      throw std::invalid_argument("balls of radius " + format(largest) + " m do not fit: " + where +
                                  " takes less than " + format(widest) + " m");
  };
  if (liner_->lifters() > 0)
    require(0.5 * liner::narrowest_groove_width(*liner_), "the groove of the liner");
  else
    require(touches_of_->clear_radius(), "the drum");
  if (ends_ && 2.0 * largest > ends_->high - ends_->low)
    throw std::invalid_argument("balls of radius " + format(largest) +
                                " m do not fit between the ends, " +
                                format(ends_->high - ends_->low) + " m apart");
}

/// No ball's centre lies in the wall or beyond an end: nothing would bring it back as it should.
void FixWallMill::check_balls_are_inside() const
{
  const MillNow mill = mill_now();
  int outside = 0, first = MAXTAGINT;
  Vector place{};
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!(atom->mask[i] & groupbit)) continue;
    Vector arm;
    for (int d = 0; d < 3; ++d) arm[d] = atom->x[i][d] - mill.origin[d];
    const double along = millscale::dot(arm, mill.axis);
    if (liner::inside(*liner_, at_rest(mill, arm)) &&
        !(ends_ && (along < ends_->low || along > ends_->high)))
      continue;
    ++outside;
    if (atom->tag[i] >= first) continue;
    first = atom->tag[i];
    place = {atom->x[i][0], atom->x[i][1], atom->x[i][2]};
  }
  const int of_this_rank = first;
  MPI_Allreduce(MPI_IN_PLACE, &outside, 1, MPI_INT, MPI_SUM, world);
  if (outside == 0) return;
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, world);
  if (of_this_rank != first) place = {};
  MPI_Allreduce(MPI_IN_PLACE, place.data(), 3, MPI_DOUBLE, MPI_SUM, world);
  throw std::invalid_argument(
      "balls with their centre outside the liner: " + std::to_string(outside) + ", first ball " +
      std::to_string(first) + " at (" + format(place[0]) + ", " + format(place[1]) + ", " +
      format(place[2]) + ") m; check the liner, its phase and ends, and the mill's origin");
}
