#include "liggghts/pair/pair_gran_fast.h"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <string>

#include "atom.h"
#include "comm.h"
#include "contact_models.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "modify.h"
#include "neigh_request.h"
#include "neighbor.h"
#include "output.h"
#include "pair_gran.h"
#include "timer.h"
#include "update.h"

#include "core/math/format.h"
#include "core/neighbor/list_check.h"
#include "liggghts/common/argument_list.h"
#include "liggghts/common/contact_laws.h"
#include "liggghts/common/end_run.h"
#include "liggghts/common/first_fix.h"
#include "liggghts/energy/fix_mill_ledger.h"
#include "liggghts/pair/fix_adaptive_skin.h"
#include "liggghts/pair/fix_contact_damping.h"
#include "liggghts/pair/fix_pair_contact_history.h"

using namespace LAMMPS_NS;
namespace pairs = millscale::pairs;

namespace {

namespace models = LIGGGHTS::ContactModels;
constexpr int surface_fast = 62;  // of 64; the engine's own surface models are below 10
constexpr const char* tangential_models[] = {"off", "no_history", "history"};
constexpr const char* style_name = "pair_style gran ... surface fast";

/// Of hertz with a tangential model and with or without constant directional torque.
int64_t hash_of(const char* tangential, bool rolling)
{
  models::Factory& known = models::Factory::instance();
  return LIGGGHTS::Utils::generate_gran_hashcode(
      known.getNormalModelId("hertz"), known.getTangentialModelId(tangential),
      known.getCohesionModelId("off"), known.getRollingModelId(rolling ? "cdt" : "off"),
      surface_fast);
}

LIGGGHTS::PairStyles::IGranularPairStyle* create(LAMMPS* engine, PairGran* pair, int64_t hash)
{
  return new PairGranFast(engine, pair, hash);
}

/// Of the engine's other models; it would answer that it does not know the surface model.
LIGGGHTS::PairStyles::IGranularPairStyle* refuse(LAMMPS* engine, PairGran*, int64_t)
{
  engine->error->all(FLERR, (std::string(style_name) +
                             " covers model hertz, tangential history or off, rolling_friction cdt "
                             "or off, no cohesion; for other models leave out `surface fast`")
                                .c_str());
  return nullptr;
}

}  // namespace

void PairGranFast::add_to_engine()
{
  models::Factory::instance().addSurfaceModel("fast", surface_fast);
  std::map<int, decltype(&create)> creators;
  // The ids of LIGGGHTS-PUBLIC 3.8 end at 12, 4, 8 and 6.
  for (int normal = 0; normal <= 12; ++normal)
    for (int tangential = 0; tangential <= 4; ++tangential)
      for (int cohesion = 0; cohesion <= 8; ++cohesion)
        for (int rolling = 0; rolling <= 6; ++rolling)
          creators[LIGGGHTS::Utils::generate_gran_hashcode(normal, tangential, cohesion, rolling,
                                                           surface_fast)] = &refuse;
  for (const char* tangential : tangential_models)
    for (const bool rolling : {false, true}) creators[hash_of(tangential, rolling)] = &create;
  for (const auto& [hash, creator] : creators)
    LIGGGHTS::PairStyles::Factory::instance().addStyle("gran", hash, creator);
}

PairGranFast::PairGranFast(LAMMPS* engine, PairGran* pair, int64_t hash)
    : Pointers(engine), pair_(pair), hash_(hash), kernel_(pairs::best_kernel())
{
  for (const char* tangential : tangential_models)
    for (const bool rolling : {false, true})
      if (hash == hash_of(tangential, rolling)) {
        tangential_ = tangential;
        terms_.history = tangential_ == "history";
        terms_.rolling = rolling;
      }
}

void PairGranFast::settings(int narg, char** arg, LIGGGHTS::IContactHistorySetup* history)
{
  try {
    millscale::ArgumentList list(narg, arg, 0);
    while (!list.done()) {
      const std::string key = list.word("a keyword");
      if (key == "tangential_damping")
        read_damping(list.word("on, off or bounded"));
      else if (key == "memory")
        forget_apart_ = list.choice(key, "of_contact", "stock");
      else if (key == "precision")
        mixed_ = list.choice(key, "mixed", "double");
      else if (key == "check")
        check_every_ = list.count(key);
      else if (key == "kernel") {
        const int level = list.count(key);
        if (level < 2 || level > 4 || !pairs::runs(level))
          throw std::invalid_argument(
              "kernel: 2, 3 or 4 for x86-64-v2, v3, v4, as far as this "
              "machine has it, got " +
              std::to_string(level));
        kernel_ = pairs::kernel(level);
      } else
        throw std::invalid_argument(
            "unknown keyword '" + key +
            "'; accepted are tangential_damping, memory, precision, check, kernel; for other "
            "options leave out `surface fast`");
    }
    mixed_ = mixed_ && kernel_.evaluate_mixed;  // else double: never less precise than asked for
  } catch (const std::invalid_argument& problem) {
    error->all(FLERR, (std::string(style_name) + ": " + problem.what()).c_str());
  }
  // Kept even without a tangential spring: the engine's lists then have one form.
  history->add_history_value("shearx", "1");
  history->add_history_value("sheary", "1");
  history->add_history_value("shearz", "1");
}

void PairGranFast::read_damping(const std::string& word)
{
  if (word != "on" && word != "off" && word != "bounded")
    throw std::invalid_argument("tangential_damping: got '" + word +
                                "', accepted are on, off, bounded");
  terms_.tangential_damping = word != "off";
  terms_.limited_damping = word == "bounded";
}

void PairGranFast::init_granular()
{
  // The engine has just asked for lists it would build at every turn; we have our own.
  while (neighbor->nrequest > 0 &&
         neighbor->requests[neighbor->nrequest - 1]->requestor == static_cast<void*>(pair_))
    delete neighbor->requests[--neighbor->nrequest];
  if (pair_->dnum() == 0)  // made by read_restart, which knows no settings
    error->all(
        FLERR,
        (std::string(style_name) + ": repeat the pair_style command after read_restart").c_str());
  refuse_what_is_not_covered();
  damping_ = terms_.limited_damping ? own_fix<FixContactDamping>("contact_damping") : nullptr;
  margins_ = own_fix<FixPairMargins>("pair_margins");
  ledger_ = first_fix<FixMillLedger>(modify);
  memories_ = static_cast<FixPairMemories*>(pair_->get_fix_history());  // so for all, by its style
  try {
    laws_ = contact_laws(lmp, style_name, tangential_ != "off", terms_.rolling);
    if (tangential_ == "no_history") refuse_friction_of_balls();
  } catch (const std::invalid_argument& problem) {
    error->all(FLERR, (std::string(style_name) + ": " + problem.what()).c_str());
  }
}

/// A fix of ours, made at the first run.
template <class Style>
Style* PairGranFast::own_fix(const char* name)
{
  std::string id = name, all = "all", style = Style::style_name;
  char* words[] = {id.data(), all.data(), style.data()};
  if (modify->find_fix(id.data()) < 0) modify->add_fix(3, words);
  return static_cast<Style*>(modify->fix[modify->find_fix(id.data())]);
}

/// Without memory there is no spring; ours is right then only where no friction acts at all.
void PairGranFast::refuse_friction_of_balls()
{
  const int types = atom->ntypes;
  std::vector<int> of_ball(types, 0);
  for (int i = 0; i < atom->nlocal; ++i) of_ball[atom->type[i] - 1] = 1;
  MPI_Allreduce(MPI_IN_PLACE, of_ball.data(), types, MPI_INT, MPI_MAX, world);
  for (int a = 0; a < types; ++a)
    for (int b = 0; b < types; ++b)
      if (of_ball[a] && of_ball[b] && laws_[a * types + b].sliding > 0.0)
        throw std::invalid_argument(
            "does not cover `tangential no_history` with friction between "
            "balls; use `history`, or leave out `surface fast`");
}

void PairGranFast::refuse_what_is_not_covered()
{
  const auto refuse = [&](bool there, const std::string& what) {
    if (there)
      error->all(FLERR, (std::string(style_name) + " does not cover " + what +
                         "; leave out `surface fast`")
                            .c_str());
  };
  refuse(!atom->rmass || !atom->sphere_flag, "this atom style; it needs spheres with own mass");
  refuse(atom->superquadric_flag || atom->shapetype_flag, "other shapes than spheres");
  refuse(pair_->fr_pair() != nullptr, "rigid bodies (fix rigid)");
  refuse(pair_->freeze_group_bit() != 0, "frozen balls (fix freeze)");
  refuse(pair_->storeContactForces() || pair_->storeContactForcesStress() ||
             pair_->storeSumDelta() || pair_->store_sum_normal_force(),
         "stored contact forces");
  refuse(modify->n_fixes_style("relax") > 0, "fix relax");
  refuse(modify->n_fixes_style("insert/stream/predefined") > 0, "fix insert/stream/predefined");
  refuse(pair_->cpl() != nullptr, "compute pair/gran/local");
  refuse(neighbor->contactDistanceFactor != 1.0, "models that act at a distance");
  refuse(pair_->dnum() != 3, "fixes that add to the contact history");
  refuse(force->pair != pair_, "pair_style hybrid");
  refuse(neighbor->includegroup != 0, "neigh_modify include");
}

pairs::Balls PairGranFast::balls() const
{
  const auto rows = [](double** field) {
    return reinterpret_cast<const double(*)[3]>(field ? field[0] : nullptr);
  };
  return {rows(atom->x), rows(atom->v), rows(atom->omega), atom->radius,
          atom->rmass,   atom->type,    atom->nlocal,      atom->nlocal + atom->nghost};
}

void PairGranFast::compute_force(PairGran*, int eflag, int vflag, int addflag)
{
  if (vflag || addflag)
    error->all(FLERR, (std::string(style_name) +
                       " computes no pressure, virial or list of pair forces; leave out `surface "
                       "fast`")
                          .c_str());
  if (neighbor->ago == 0) {
    timer->stamp();
    build_list();
    timer->stamp(TIME_NEIGHBOR);
  }
  const pairs::Balls now = balls();
  const pairs::Rows rows = rows_.rows();
  pairs::HalfList& list = memories_->list();
  const pairs::Task task{now,
                         &rows,
                         list.entries,
                         list.own.data(),
                         list.other.data(),
                         list.touching.data(),
                         list.displacement.data(),
                         laws_.data(),
                         atom->ntypes,
                         only_type_,
                         terms_,
                         update->dt,
                         pair_->computeflag() && pair_->shearupdate(),
                         forget_apart_,
                         reinterpret_cast<double(*)[3]>(atom->f[0]),
                         reinterpret_cast<double(*)[3]>(atom->torque[0]),
                         damping_ ? damping_->up_to_date() : nullptr};
  if (task.balls.owned > 0 && ledger_)
    pairs::v2::evaluate(task, ledger_->between_balls());
  else if (task.balls.owned > 0)
    (mixed_ ? kernel_.evaluate_mixed : kernel_.evaluate)(task);
  if (check_every_ > 0 && update->ntimestep % check_every_ == 0) check_list();
}

void PairGranFast::check_list()
{
  const auto missed = pairs::missed_contact(memories_->list(), balls());
  if (!missed) return;
  const std::string pair =
      std::to_string(atom->tag[missed->i]) + " and " + std::to_string(atom->tag[missed->j]);
  millscale::EndRun(lmp).because(
      std::string(style_name) + ": check: at step " + std::to_string(update->ntimestep) +
      " balls " + pair + " overlap by " + millscale::format(missed->overlap) + " m and " +
      (missed->listed ? "count as apart" : "are no pair of the neighbour list") +
      "; neigh_modify must check distances at every step");
}

void PairGranFast::build_list()
{
  if (neighbor->exclude_setting())  // known to the engine only now
    error->all(FLERR, (std::string(style_name) +
                       " does not cover neigh_modify exclude; leave out `surface fast`")
                          .c_str());
  const pairs::Balls now = balls();
  only_type_ = now.all > 0 ? now.type[0] : 0;
  if (std::any_of(now.type, now.type + now.all, [&](int t) { return t != only_type_; }))
    only_type_ = 0;
  pairs::HalfList& list = memories_->next_list();
  pairs::build(list, grid_, now, margins_->at_birth(now, grid_, by_places()),
               kernel_.list_partners);
  rows_.for_balls(now.all, mixed_ && !ledger_);
  memories_->take_on(now, pair_);
  if (ledger_) ledger_->between_balls().begin_list(list.touching.data(), list.entries);
}

/// A run that goes on from a restart file must have the lists of the one that wrote it, but speeds
/// at its set-up are not those in the midst of the step. Stock memories last as long as a list.
bool PairGranFast::by_places() const
{
  return update->setupflag || output->restart_requested(update->ntimestep) || !forget_apart_ ||
         domain->box_change;
}

void PairGranFast::write_restart_settings(FILE* file)
{
  fwrite(&hash_, sizeof hash_, 1, file);
}

void PairGranFast::read_restart_settings(FILE* file, int64_t hash)
{
  int64_t written = 0;
  if (comm->me == 0 && (fread(&written, sizeof written, 1, file) != 1 || written != hash))
    error->one(FLERR, "the restart file is of another pair style");
}

int PairGranFast::get_history_offset(const std::string)
{
  return -1;
}

bool PairGranFast::contact_match(const std::string type, const std::string model)
{
  if (type == "model") return model == "hertz";
  if (type == "tangential") return model == tangential_;
  if (type == "rolling_friction") return model == (terms_.rolling ? "cdt" : "off");
  if (type == "cohesion") return model == "off";
  return type == "surface" && model == "fast";
}
