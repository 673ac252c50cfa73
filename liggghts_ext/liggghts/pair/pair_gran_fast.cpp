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
#include "liggghts/common/contact_laws.h"
#include "liggghts/common/end_run.h"
#include "liggghts/common/first_fix.h"
#include "liggghts/common/keywords.h"
#include "liggghts/common/reads_overlap.h"
#include "liggghts/energy/fix_mill_impacts.h"
#include "liggghts/energy/fix_mill_ledger.h"
#include "liggghts/pair/fix_adaptive_skin.h"
#include "liggghts/pair/fix_ball_rows.h"
#include "liggghts/pair/fix_contact_damping.h"
#include "liggghts/pair/fix_pair_contact_history.h"

using namespace LAMMPS_NS;
namespace kernels = millscale::kernels;

namespace {

namespace models = LIGGGHTS::ContactModels;
constexpr int surface_fast = 62;  // of 64; the engine's own surface models are below 10
constexpr const char* tangential_models[] = {"off", "no_history", "history"};
constexpr const char* style_name = "pair_style gran ... surface fast";

/// Return the hash of hertz with a tangential model, with or without constant directional torque.
int64_t hash_of(const char* tangential, bool rolling)
{
  models::Factory& known = models::Factory::instance();
  return LIGGGHTS::Utils::generate_gran_hashcode(
      known.getNormalModelId("hertz"), known.getTangentialModelId(tangential),
      known.getCohesionModelId("off"), known.getRollingModelId(rolling ? "cdt" : "off"),
      surface_fast);
}

LIGGGHTS::PairStyles::IGranularPairStyle* create_pair(LAMMPS* engine, PairGran* pair, int64_t hash)
{
  return new PairGranFast(engine, pair, hash);
}

/// Refuse the engine's other models. The engine's own error would say that the surface model is
/// unknown.
LIGGGHTS::PairStyles::IGranularPairStyle* refuse(LAMMPS* engine, PairGran*, int64_t)
{
  engine->error->all(FLERR, (std::string(style_name) +
                             " covers model hertz, tangential history or off, rolling_friction cdt "
                             "or off, no cohesion; for other models leave out `surface fast`")
                                .c_str());
  return nullptr;
}

/// List the numbers of the implementations that this machine supports.
std::string supported_kernels()
{
  std::string list;
  for (const kernels::Implementation& each : kernels::implementations())
    if (each.supported()) {
      const std::string name = each.name;
      list += (list.empty() ? "" : ", ") + name.substr(name.size() - 1) + " (" + name + ")";
    }
  return list;
}

}  // namespace

void PairGranFast::add_to_engine()
{
  models::Factory::instance().addSurfaceModel("fast", surface_fast);
  std::map<int, decltype(&create_pair)> creators;
  // The ids of LIGGGHTS-PUBLIC 3.8 end at 12, 4, 8 and 6.
  for (int normal = 0; normal <= 12; ++normal)
    for (int tangential = 0; tangential <= 4; ++tangential)
      for (int cohesion = 0; cohesion <= 8; ++cohesion)
        for (int rolling = 0; rolling <= 6; ++rolling)
          creators[LIGGGHTS::Utils::generate_gran_hashcode(normal, tangential, cohesion, rolling,
                                                           surface_fast)] = &refuse;
  for (const char* tangential : tangential_models)
    for (const bool rolling : {false, true}) creators[hash_of(tangential, rolling)] = &create_pair;
  for (const auto& [hash, creator] : creators)
    LIGGGHTS::PairStyles::Factory::instance().addStyle("gran", hash, creator);
}

PairGranFast::PairGranFast(LAMMPS* engine, PairGran* pair, int64_t hash)
    : Pointers(engine), pair_(pair), hash_(hash), kernel_(&kernels::best_implementation())
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
    millscale::Keywords("for other options leave out `surface fast`")
        .add("tangential_damping",
             [this](millscale::ArgumentList& list) {
               const std::string word = list.one_of("tangential_damping", {"on", "off", "bounded"});
               terms_.tangential_damping = word != "off";
               terms_.limited_damping = word == "bounded";
             })
        .choice("memory", "of_contact", "stock", reset_on_separation_)
        .choice("precision", "mixed", "double", mixed_)
        .count("check", check_every_)
        .add("kernel",
             [this](millscale::ArgumentList& list) {
               const std::string level = std::to_string(list.count("kernel"));
               kernel_ = kernels::find_implementation("x86-64-v" + level);
               if (!kernel_)
                 throw std::invalid_argument("kernel: got " + level + ", this machine supports " +
                                             supported_kernels());
             })
        .parse({narg, arg, 0});
    mixed_ = mixed_ && kernel_->evaluate_mixed;  // x86-64-v2 has double precision only
  } catch (const std::invalid_argument& problem) {
    error->all(FLERR, (std::string(style_name) + ": " + problem.what()).c_str());
  }
  // Also without a tangential spring, so that the engine's lists always have one form.
  history->add_history_value("shearx", "1");
  history->add_history_value("sheary", "1");
  history->add_history_value("shearz", "1");
}

void PairGranFast::init_granular()
{
  // Cancel the engine's requests for lists, which it would build at every rebuild.
  while (neighbor->nrequest > 0 &&
         neighbor->requests[neighbor->nrequest - 1]->requestor == static_cast<void*>(pair_))
    delete neighbor->requests[--neighbor->nrequest];
  if (pair_->dnum() == 0)  // made by read_restart, without settings
    error->all(
        FLERR,
        (std::string(style_name) + ": repeat the pair_style command after read_restart").c_str());
  require_covered();
  damping_ = terms_.limited_damping ? own_fix<FixContactDamping>("contact_damping") : nullptr;
  skin_ = own_fix<FixAdaptiveSkin>("pair_margins");
  skin_->use();
  rows_ = own_fix<FixBallRows>("pair_rows");
  rows_->pair = this;
  ledger_ = first_fix<FixMillLedger>(modify);
  find_overlap_readers();
  history_ =
      static_cast<FixPairContactHistory*>(pair_->get_fix_history());  // so for all, by its style
  impacts_ = first_fix<FixMillImpacts>(modify);
  if (impacts_ && !reset_on_separation_)
    error->all(FLERR,
               (std::string(style_name) +
                ": fix mill/impacts needs `memory of_contact`: with `memory stock` a contact "
                "outlasts a separation")
                   .c_str());
  history_->record_work(impacts_);
  try {
    laws_ = contact_laws(lmp, style_name, tangential_ != "off", terms_.rolling);
    if (tangential_ == "no_history") refuse_friction_of_balls();
  } catch (const std::invalid_argument& problem) {
    error->all(FLERR, (std::string(style_name) + ": " + problem.what()).c_str());
  }
}

void PairGranFast::find_overlap_readers()
{
  overlap_readers_.clear();
  const auto add = [this](auto* style) {
    if (auto* reader = dynamic_cast<ReadsOverlap*>(style)) overlap_readers_.push_back(reader);
  };
  std::for_each(modify->compute, modify->compute + modify->ncompute, add);
  std::for_each(modify->fix, modify->fix + modify->nfix, add);
}

/// Return where the kernel is to note the largest overlap; null if no style reads it at this step.
double* PairGranFast::begin_overlap()
{
  overlap_.reset();
  overlap_step_ = update->ntimestep;
  for (ReadsOverlap* reader : overlap_readers_)
    if (reader->reads_overlap_now()) return &overlap_.emplace(0.0);
  return nullptr;
}

std::optional<double> PairGranFast::largest_overlap() const
{
  return overlap_step_ == update->ntimestep ? overlap_ : std::nullopt;
}

/// Return a fix of this pair style, created at the first run.
template <class Style>
Style* PairGranFast::own_fix(const char* name)
{
  std::string id = name, all = "all", style = Style::style_name;
  char* words[] = {id.data(), all.data(), style.data()};
  if (modify->find_fix(id.data()) < 0) modify->add_fix(3, words);
  return static_cast<Style*>(modify->fix[modify->find_fix(id.data())]);
}

/// Refuse friction without history: the kernels have no tangential force without a spring.
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

void PairGranFast::require_covered()
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

millscale::neighbor::Particles PairGranFast::particles() const
{
  const auto rows = [](double** field) {
    return reinterpret_cast<const double(*)[3]>(field ? field[0] : nullptr);
  };
  return {rows(atom->x), rows(atom->v), rows(atom->omega), atom->radius,
          atom->rmass,   atom->type,    atom->nlocal,      atom->nghost};
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
  const kernels::Rows rows = rows_->store.rows();
  kernels::Task now = task(rows);
  now.step.advance = pair_->computeflag() && pair_->shearupdate();
  now.sums = {reinterpret_cast<double(*)[3]>(atom->f[0]),
              reinterpret_cast<double(*)[3]>(atom->torque[0]),
              damping_ ? damping_->up_to_date() : nullptr};
  if (impacts_ && now.particles.nlocal > 0)
    now.record = impacts_->begin_balls(history_->list(), now.laws, now.step.advance);
  if (now.particles.nlocal > 0 && ledger_)
    kernels::evaluate_with_budget(now, ledger_->between_balls());
  else if (now.particles.nlocal > 0)
    (mixed_ ? kernel_->evaluate_mixed : kernel_->evaluate)(now);
  if (now.record) impacts_->end_balls();
  if (checks_list_now()) check_list();
}

/// Return the task of a step, without sums.
kernels::Task PairGranFast::task(const kernels::Rows& rows)
{
  millscale::neighbor::PairList& list = history_->list();
  return {particles(),
          &rows,
          {list.entries, list.own.data(), list.other.data(), list.touching.data(),
           list.displacement.data()},
          {laws_.data(), atom->ntypes, only_type_},
          terms_,
          {update->dt, true, reset_on_separation_},
          {},
          begin_overlap()};
}

void PairGranFast::evaluate_rows()
{
  history_->in_list();
  const kernels::Rows rows = rows_->store.rows();
  if (atom->nlocal == 0) return;
  kernels::Task now = task(rows);
  if (impacts_) now.record = impacts_->begin_balls(history_->list(), now.laws, true);
  (mixed_ ? kernel_->evaluate_rows_mixed : kernel_->evaluate_rows)(now);
  if (impacts_) impacts_->end_balls();
}

std::string PairGranFast::needs_engine_loop() const
{
  if (ledger_) return "fix mill/ledger records every contact";
  if (!kernel_->advance) return std::string("kernel ") + kernel_->name + " evaluates no rows";
  return {};
}

bool PairGranFast::checks_list_now() const
{
  return check_every_ > 0 && update->ntimestep % check_every_ == 0;
}

void PairGranFast::check_list()
{
  const auto missed = millscale::neighbor::missed_contact(history_->list(), particles());
  if (!missed) return;
  const std::string pair =
      std::to_string(atom->tag[missed->i]) + " and " + std::to_string(atom->tag[missed->j]);
  millscale::EndRun(lmp).because(
      std::string(style_name) + ": check: at step " + std::to_string(update->ntimestep) +
      " balls " + pair + " overlap by " + millscale::format(missed->overlap) + " m and " +
      (missed->listed ? "count as separated" : "are no pair of the neighbour list") +
      "; neigh_modify must check distances at every step");
}

void PairGranFast::build_list()
{
  if (neighbor->exclude_setting())  // the engine knows only now
    error->all(FLERR, (std::string(style_name) +
                       " does not cover neigh_modify exclude; leave out `surface fast`")
                          .c_str());
  const millscale::neighbor::Particles now = particles();
  only_type_ = now.total() > 0 ? now.type[0] : 0;
  if (std::any_of(now.type, now.type + now.total(), [&](int t) { return t != only_type_; }))
    only_type_ = 0;
  millscale::neighbor::PairList& list = history_->next_list();
  millscale::neighbor::build(list, grid_, now, skin_->at_build(now, by_position_only()),
                             kernel_->list_partners);
  rows_->single = mixed_ && !ledger_;
  rows_->store.resize(now.total(), rows_->single, true);
  history_->take_over_history(now, pair_);
  if (ledger_) ledger_->between_balls().begin_list(list.touching.data(), list.entries);
}

/// Return whether the list may depend on positions only. A run from a restart file needs the lists
/// of the run that wrote it, but velocities at set-up differ from those within the step. The
/// engine's contact histories last as long as a list.
bool PairGranFast::by_position_only() const
{
  return update->setupflag || output->restart_requested(update->ntimestep) ||
         !reset_on_separation_ || domain->box_change;
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
