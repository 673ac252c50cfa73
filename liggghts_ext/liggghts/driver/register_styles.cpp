// The only file that touches LIGGGHTS' private style maps.
//
// The engine has no plugin command, and Modify keeps its maps from style names to factories
// private. Naming a private member in an explicit template instantiation is exempt from access
// checks
// ([temp.spec] in the C++ standard), so the maps can be reached without patching the library.
#include "liggghts/driver/register_styles.h"

#include <map>
#include <ostream>
#include <string>

#include "compute.h"
#include "fix.h"
#include "lammps.h"
#include "modify.h"

#include "liggghts/energy/fix_mill_impacts.h"
#include "liggghts/energy/fix_mill_ledger.h"
#include "liggghts/loop/mill_loop.h"
#include "liggghts/measure/compute_mill_charge.h"
#include "liggghts/measure/compute_mill_detach.h"
#include "liggghts/measure/fix_mill_detach_track.h"
#include "liggghts/measure/fix_mill_drive.h"
#include "liggghts/measure/fix_mill_occupancy.h"
#include "liggghts/mill/fix_mill_similarity.h"
#include "liggghts/pair/fix_adaptive_skin.h"
#include "liggghts/pair/fix_ball_rows.h"
#include "liggghts/pair/fix_contact_damping.h"
#include "liggghts/pair/fix_pair_contact_history.h"
#include "liggghts/pair/pair_gran_fast.h"
#include "liggghts/run/fix_mill_forces.h"
#include "liggghts/run/fix_mill_guard.h"
#include "liggghts/run/fix_mill_restart.h"
#include "liggghts/wall/fix_mill_liner_loads.h"
#include "liggghts/wall/fix_wall_mill.h"
#include "liggghts/wall/mesh_file.h"

namespace {

using LAMMPS_NS::Compute;
using LAMMPS_NS::Fix;
using LAMMPS_NS::LAMMPS;
using LAMMPS_NS::Modify;

using FixMap = std::map<std::string, Fix* (*)(LAMMPS*, int, char**)>;
using ComputeMap = std::map<std::string, Compute* (*)(LAMMPS*, int, int, char**)>;

FixMap* Modify::*fix_map_member();
ComputeMap* Modify::*compute_map_member();

template <FixMap* Modify::*Fixes, ComputeMap* Modify::*Computes>
struct ModifyMaps {
  friend FixMap* Modify::*fix_map_member() { return Fixes; }
  friend ComputeMap* Modify::*compute_map_member() { return Computes; }
};
template struct ModifyMaps<&Modify::fix_map, &Modify::compute_map>;

template <typename Style>
Fix* create_fix(LAMMPS* engine, int narg, char** arg)
{
  return new Style(engine, narg, arg);
}

template <typename Style>
Compute* create_compute(LAMMPS* engine, int iarg, int narg, char** arg)
{
  return new Style(engine, iarg, narg, arg);
}

/// The engine's own creators of fixes mesh/surface...
FixMap& mesh_fixes()
{
  static FixMap creators;
  return creators;
}

/// Create a fix of any style mesh/surface... after a check of its file. Modules without a name in
/// the map use `mesh/surface`.
Fix* create_mesh_fix(LAMMPS* engine, int narg, char** arg)
{
  LAMMPS_NS::check_mesh_file(engine, narg, arg);
  const auto found = mesh_fixes().find(arg[2]);
  const auto create = found != mesh_fixes().end() ? found->second : mesh_fixes().at("mesh/surface");
  return create(engine, narg, arg);
}

void check_mesh_files(FixMap& fixes)
{
  for (auto& [style, create] : fixes)
    if (style.rfind("mesh/surface", 0) == 0) {
      mesh_fixes()[style] = create;
      create = &create_mesh_fix;
    }
}

}  // namespace

namespace millscale {

void register_styles(LAMMPS& engine)
{
  FixMap& fixes = *(engine.modify->*fix_map_member());
  check_mesh_files(fixes);
  fixes["mill/similarity"] = &create_fix<LAMMPS_NS::FixMillSimilarity>;
  fixes["wall/mill"] = &create_fix<LAMMPS_NS::FixWallMill>;
  fixes["mill/forces"] = &create_fix<LAMMPS_NS::FixMillForces>;
  fixes[LAMMPS_NS::FixContactDamping::style_name] = &create_fix<LAMMPS_NS::FixContactDamping>;
  fixes[LAMMPS_NS::FixAdaptiveSkin::style_name] = &create_fix<LAMMPS_NS::FixAdaptiveSkin>;
  fixes[LAMMPS_NS::FixBallRows::style_name] = &create_fix<LAMMPS_NS::FixBallRows>;
  fixes["contacthistory"] = &create_fix<LAMMPS_NS::FixPairContactHistory>;  // in the engine's place
  fixes["mill/restart"] = &create_fix<LAMMPS_NS::FixMillRestart>;
  fixes["mill/guard"] = &create_fix<LAMMPS_NS::FixMillGuard>;
  fixes["mill/ledger"] = &create_fix<LAMMPS_NS::FixMillLedger>;
  fixes["mill/impacts"] = &create_fix<LAMMPS_NS::FixMillImpacts>;
  fixes["mill/drive"] = &create_fix<LAMMPS_NS::FixMillDrive>;
  fixes["mill/occupancy"] = &create_fix<LAMMPS_NS::FixMillOccupancy>;
  fixes["mill/liner_loads"] = &create_fix<LAMMPS_NS::FixMillLinerLoads>;
  fixes["mill/detach/track"] = &create_fix<LAMMPS_NS::FixMillDetachTrack>;

  LAMMPS_NS::PairGranFast::add_to_engine();
  LAMMPS_NS::MillLoop::replace_engine_loop(engine);

  ComputeMap& computes = *(engine.modify->*compute_map_member());
  computes["mill/charge"] = &create_compute<LAMMPS_NS::ComputeMillCharge>;
  computes["mill/detach"] = &create_compute<LAMMPS_NS::ComputeMillDetach>;
}

void list_styles(std::ostream& out)
{
  out << "\nStyles added by millscale:\n"
         "  fix mill/similarity      derives scaled gravity and speed, applies gravity, turns the "
         "mill\n"
         "  fix wall/mill            the turning lifter-liner as an analytic wall with exact arcs\n"
         "  pair_style gran ... surface fast\n"
         "                           Hertz-Mindlin contacts of balls, several times faster\n"
         "  fix mill/forces          carries forces through a restart, so that runs are "
         "bit-identical\n"
         "  fix mill/restart         signs complete restart files\n"
         "  fix mill/guard           stops a faulty run and names the ball and the reason\n"
         "  fix mill/ledger          energy budget: work of the mill, energy stored and "
         "dissipated\n"
         "  fix mill/impacts         spectra of the energy that contacts dissipate, to a file\n"
         "  fix mill/drive           work, torque and power of the drive, summed over all steps\n"
         "  fix mill/occupancy       solid fraction of the cross-section on a polar grid, to a "
         "file\n"
         "  fix mill/liner_loads     loads on the liner by arc length, place and lifter, to files\n"
         "  compute mill/charge      energies, monitoring boxes, toe, shoulder, largest overlap of "
         "the "
         "charge\n"
         "  compute mill/detach      state of each ball, and where and when it left liner and "
         "charge\n"
         "  fix mill/detach/track    per-ball records behind compute mill/detach (made by it)\n"
         "Their arguments are described in docs/reference/styles.\n";
}

}  // namespace millscale
