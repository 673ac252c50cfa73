#include "liggghts/pair/fix_pair_contact_history.h"

#include <algorithm>
#include <numeric>

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "output.h"
#include "pair_gran.h"
#include "update.h"

#include "liggghts/energy/fix_mill_impacts.h"

using namespace LAMMPS_NS;
namespace neighbor = millscale::neighbor;

FixPairContactHistory::FixPairContactHistory(LAMMPS* lmp, int narg, char** arg)
    : FixContactHistory(lmp, narg, arg),
      index_in_list_(atom->nmax, neighbor::absent),
      engine_list_(lmp),
      engine_history_list_(lmp)
{
  // Otherwise the engine calls set_arrays() for existing particles after the first list.
  just_created = 0;
  engine_list_.ghostflag = engine_history_list_.ghostflag =
      0;  // otherwise the engine's destructor reads uninitialised members
}

FixPairContactHistory::~FixPairContactHistory()
{
  for (NeighList* list : {&engine_list_, &engine_history_list_}) {  // their arrays are ours
    list->ilist = list->numneigh = nullptr;
    list->firstneigh = nullptr;
    list->firstdouble = nullptr;
  }
}

/// The pair style keeps a pointer to this fix and does not check that it still exists.
void FixPairContactHistory::pre_delete(bool by_unfix)
{
  if (by_unfix)
    error->fix_error(FLERR, this,
                     "the contacts of pair_style gran need it, it cannot be removed; leave out "
                     "`unfix`, and the pair style removes it when another takes its place");
}

/// Restart files are written from the engine's arrays, and delete_atoms reads them between runs.
void FixPairContactHistory::pre_exchange()
{
  const bool in_a_run = update->whichflag == 1 && !update->setupflag;
  stays_in_list_ = in_use_ && in_a_run && !output->restart_requested(update->ntimestep) &&
                   !domain->box_change && !domain->triclinic;
  if (!in_use_) return FixContactHistory::pre_exchange();
  store_history();
}

/// The engine calls this before a run, and at the end of a step for a restart file. The list
/// remains valid after the file.
void FixPairContactHistory::setup_pre_exchange()
{
  stays_in_list_ = false;
  if (*computeflag_ && !in_use_) return FixContactHistory::pre_exchange();
  if (*computeflag_) store_history();
  if (update->setupflag) in_use_ = false;  // until the run has built a list
}

/// Mark all particles, or only those that may leave: particles inside the rank's subdomain stay.
void FixPairContactHistory::mark_leaving()
{
  leaving_.assign(list_.nlocal(), !stays_in_list_);
  if (!stays_in_list_) return;
  const double *low = domain->sublo, *high = domain->subhi;
  for (int i = 0; i < atom->nlocal; ++i) {
    const double* x = atom->x[i];
    bool inside = true;
    for (int d = 0; d < 3; ++d) inside &= x[d] >= low[d] && x[d] < high[d];
    if (!inside && index_in_list_[i] != neighbor::absent) leaving_[index_in_list_[i]] = 1;
  }
}

/// Store the contact histories of the leaving particles in the engine's arrays.
void FixPairContactHistory::store_history()
{
  mark_leaving();
  *computeflag_ = 0;
  std::fill_n(npartner_, atom->nmax, 0);
  if (impacts_) impacts_->forget_kept();
  ipage_->reset();
  dpage_->reset();
  if (std::find(leaving_.begin(), leaving_.end(), 1) == leaving_.end()) return;
  find_current_indices();
  neighbor::for_each_history_of(leaving_, list_, tag_, [&](int ball, int, const auto&, double) {
    if (current_index_[ball] != neighbor::absent) ++npartner_[current_index_[ball]];
  });
  for (int i = 0; i < atom->nlocal; ++i) {
    if (npartner_[i] == 0) continue;
    maxtouch_ = std::max(maxtouch_, npartner_[i]);
    partner_[i] = ipage_->get(npartner_[i]);
    contacthistory_[i] = dpage_->get(dnum_ * npartner_[i]);
    if (!partner_[i] || !contacthistory_[i])
      error->one(FLERR, "a ball has more contacts than neigh_modify one allows: raise it");
    npartner_[i] = 0;
  }
  neighbor::for_each_history_of(
      leaving_, list_, tag_,
      [&](int ball, int tag, const neighbor::Remembered& known, double sign) {
        const int i = current_index_[ball];
        if (i == neighbor::absent) return;
        const int k = npartner_[i]++;
        partner_[i][k] = tag;
        for (int d = 0; d < 3; ++d)
          contacthistory_[i][dnum_ * k + d] = sign * known.displacement[d];
        if (impacts_) impacts_->keep(i, neighbor::work_on(known, sign));
      });
  const int work = impacts_ ? FixMillImpacts::exchanged_numbers : 0;
  comm->maxexchange_fix = std::max(comm->maxexchange_fix, (dnum_ + 1 + work) * maxtouch_ + 1);
}

void FixPairContactHistory::record_work(FixMillImpacts* impacts)
{
  impacts_ = impacts;
  for (neighbor::PairList* list : {&list_, &old_list_}) {
    list->records_work = impacts != nullptr;
    if (impacts) continue;
    list->work = list->next_work = {};
    list->available = {};
  }
}

void FixPairContactHistory::find_current_indices()
{
  current_index_.assign(list_.nlocal(), neighbor::absent);
  for (int i = 0; i < atom->nlocal; ++i)
    if (index_in_list_[i] != neighbor::absent) current_index_[index_in_list_[i]] = i;
}

neighbor::PairList& FixPairContactHistory::next_list()
{
  if (stays_in_list_) find_current_indices();
  std::swap(list_, old_list_);
  return list_;
}

void FixPairContactHistory::take_over_history(const neighbor::Particles& particles, PairGran* pair)
{
  if (stays_in_list_)
    neighbor::transfer_history(old_list_, tag_, current_index_, list_, particles, atom->tag);
  // The engine's arrays hold the histories of all particles, or of those that have arrived.
  for (int i = 0; i < particles.nlocal; ++i)
    for (int k = 0; k < npartner_[i]; ++k)
      neighbor::restore_history(
          list_, particles, atom->tag, i, partner_[i][k],
          {&contacthistory_[i][dnum_ * k],
           impacts_ ? impacts_->kept(i, k) : millscale::energy::CarriedWork{}},
          1.0);
  neighbor::order_work(list_);
  in_use_ = true;
  tag_.assign(atom->tag, atom->tag + particles.total());
  std::iota(index_in_list_.begin(), index_in_list_.begin() + particles.nlocal, 0);
  publish(pair);
}

void FixPairContactHistory::publish(PairGran* pair)
{
  const int owned = list_.nlocal();
  owned_.resize(owned);
  std::iota(owned_.begin(), owned_.end(), 0);
  first_other_.resize(owned);
  first_touching_.resize(owned);
  first_displacement_.resize(owned);
  for (int i = 0; i < owned; ++i) {
    const int first = list_.first[i];
    first_other_[i] = list_.other.data() + first;
    first_touching_[i] = list_.touching.data() + first;
    first_displacement_[i] = list_.displacement.data() + 3 * static_cast<std::size_t>(first);
  }
  for (NeighList* list : {&engine_list_, &engine_history_list_}) {
    list->inum = owned;
    list->ilist = owned_.data();
    list->numneigh = list_.partners.data();
  }
  engine_list_.firstneigh = first_other_.data();
  engine_list_.listgranhistory = &engine_history_list_;
  engine_history_list_.firstneigh = first_touching_.data();
  engine_history_list_.firstdouble = first_displacement_.data();
  pair->list = &engine_list_;
  pair->listgranhistory = &engine_history_list_;
}

int FixPairContactHistory::pack_exchange(int i, double* buffer)
{
  if (stays_in_list_ && index_in_list_[i] != neighbor::absent && !leaving_[index_in_list_[i]])
    error->one(FLERR,
               "a ball leaves its rank from within its subdomain and would lose its contact "
               "history; please report the deck");
  return FixContactHistory::pack_exchange(i, buffer);
}

int FixPairContactHistory::unpack_exchange(int i, double* buffer)
{
  index_in_list_[i] = neighbor::absent;
  return FixContactHistory::unpack_exchange(i, buffer);
}

void FixPairContactHistory::set_arrays(int i)
{
  FixContactHistory::set_arrays(i);
  index_in_list_[i] = neighbor::absent;
}

void FixPairContactHistory::copy_arrays(int from, int to, int deletes)
{
  FixContactHistory::copy_arrays(from, to, deletes);
  index_in_list_[to] = index_in_list_[from];
}

void FixPairContactHistory::grow_arrays(int count)
{
  FixContactHistory::grow_arrays(count);
  index_in_list_.resize(count, neighbor::absent);
}

double FixPairContactHistory::memory_usage()
{
  return FixContactHistory::memory_usage() +
         static_cast<double>(
             (tag_.capacity() + index_in_list_.capacity() + current_index_.capacity()) *
             sizeof(int));
}
