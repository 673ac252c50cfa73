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

using namespace LAMMPS_NS;
namespace pairs = millscale::pairs;

FixPairMemories::FixPairMemories(LAMMPS* lmp, int narg, char** arg)
    : FixContactHistory(lmp, narg, arg),
      born_as_(atom->nmax, pairs::absent),
      shown_(lmp),
      shown_history_(lmp)
{
  // Else the engine calls set_arrays() for balls that are there, after the first list.
  just_created = 0;
  shown_.ghostflag = shown_history_.ghostflag =
      0;  // else the engine's destructor reads what is not set
}

FixPairMemories::~FixPairMemories()
{
  for (NeighList* list : {&shown_, &shown_history_}) {  // their arrays are ours
    list->ilist = list->numneigh = nullptr;
    list->firstneigh = nullptr;
    list->firstdouble = nullptr;
  }
}

/// The pair style keeps a pointer to this fix and never asks whether it is still there.
void FixPairMemories::pre_delete(bool by_unfix)
{
  if (by_unfix)
    error->fix_error(FLERR, this,
                     "the contacts of pair_style gran need it, it cannot be removed; leave out "
                     "`unfix`, and the pair style removes it when another takes its place");
}

/// Files of a step are written from the history, and delete_atoms asks for it between runs.
void FixPairMemories::pre_exchange()
{
  const bool in_a_run = update->whichflag == 1 && !update->setupflag;
  stays_in_list_ = in_use_ && in_a_run && !output->restart_requested(update->ntimestep) &&
                   !domain->box_change && !domain->triclinic;
  if (!in_use_) return FixContactHistory::pre_exchange();
  hand_over();
}

/// Before a run, and at the end of a step for a file: the list goes on after that.
void FixPairMemories::setup_pre_exchange()
{
  stays_in_list_ = false;
  if (*computeflag_ && !in_use_) return FixContactHistory::pre_exchange();
  if (*computeflag_) hand_over();
  if (update->setupflag) in_use_ = false;  // until the run has a list, perhaps of other contacts
}

/// All balls, or those that may leave: ones inside of their rank's part of the box stay on it.
void FixPairMemories::mark_leaving()
{
  leaving_.assign(list_.owned(), !stays_in_list_);
  if (!stays_in_list_) return;
  const double *low = domain->sublo, *high = domain->subhi;
  for (int i = 0; i < atom->nlocal; ++i) {
    const double* x = atom->x[i];
    bool inside = true;
    for (int d = 0; d < 3; ++d) inside &= x[d] >= low[d] && x[d] < high[d];
    if (!inside && born_as_[i] != pairs::absent) leaving_[born_as_[i]] = 1;
  }
}

/// Writes the contacts of balls that leave into the history.
void FixPairMemories::hand_over()
{
  mark_leaving();
  *computeflag_ = 0;
  std::fill_n(npartner_, atom->nmax, 0);
  ipage_->reset();
  dpage_->reset();
  if (std::find(leaving_.begin(), leaving_.end(), 1) == leaving_.end()) return;
  find_now();
  pairs::for_memories_of(leaving_, list_, tag_, [&](int ball, int, const double*, double) {
    if (now_[ball] != pairs::absent) ++npartner_[now_[ball]];
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
  pairs::for_memories_of(leaving_, list_, tag_,
                         [&](int ball, int name, const double* memory, double sign) {
                           const int i = now_[ball];
                           if (i == pairs::absent) return;
                           const int k = npartner_[i]++;
                           partner_[i][k] = name;
                           for (int d = 0; d < 3; ++d)
                             contacthistory_[i][dnum_ * k + d] = sign * memory[d];
                         });
  comm->maxexchange_fix = std::max(comm->maxexchange_fix, (dnum_ + 1) * maxtouch_ + 1);
}

void FixPairMemories::find_now()
{
  now_.assign(list_.owned(), pairs::absent);
  for (int i = 0; i < atom->nlocal; ++i)
    if (born_as_[i] != pairs::absent) now_[born_as_[i]] = i;
}

pairs::HalfList& FixPairMemories::next_list()
{
  if (stays_in_list_) find_now();
  std::swap(list_, old_list_);
  return list_;
}

void FixPairMemories::take_on(const pairs::Balls& balls, PairGran* pair)
{
  if (stays_in_list_) pairs::carry(old_list_, tag_, now_, list_, balls, atom->tag);
  // The history has those of all balls, or of the ones that have come.
  for (int i = 0; i < balls.owned; ++i)
    for (int k = 0; k < npartner_[i]; ++k)
      pairs::remember(list_, balls, atom->tag, i, partner_[i][k], &contacthistory_[i][dnum_ * k],
                      1.0);
  in_use_ = true;
  tag_.assign(atom->tag, atom->tag + balls.all);
  std::iota(born_as_.begin(), born_as_.begin() + balls.owned, 0);
  show(pair);
}

void FixPairMemories::show(PairGran* pair)
{
  const int owned = list_.owned();
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
  for (NeighList* list : {&shown_, &shown_history_}) {
    list->inum = owned;
    list->ilist = owned_.data();
    list->numneigh = list_.partners.data();
  }
  shown_.firstneigh = first_other_.data();
  shown_.listgranhistory = &shown_history_;
  shown_history_.firstneigh = first_touching_.data();
  shown_history_.firstdouble = first_displacement_.data();
  pair->list = &shown_;
  pair->listgranhistory = &shown_history_;
}

int FixPairMemories::pack_exchange(int i, double* buffer)
{
  if (stays_in_list_ && born_as_[i] != pairs::absent && !leaving_[born_as_[i]])
    error->one(FLERR,
               "a ball leaves its rank from within its part of the box, and would forget its "
               "contacts; please report the deck");
  return FixContactHistory::pack_exchange(i, buffer);
}

int FixPairMemories::unpack_exchange(int i, double* buffer)
{
  born_as_[i] = pairs::absent;
  return FixContactHistory::unpack_exchange(i, buffer);
}

void FixPairMemories::set_arrays(int i)
{
  FixContactHistory::set_arrays(i);
  born_as_[i] = pairs::absent;
}

void FixPairMemories::copy_arrays(int from, int to, int deletes)
{
  FixContactHistory::copy_arrays(from, to, deletes);
  born_as_[to] = born_as_[from];
}

void FixPairMemories::grow_arrays(int count)
{
  FixContactHistory::grow_arrays(count);
  born_as_.resize(count, pairs::absent);
}

double FixPairMemories::memory_usage()
{
  return FixContactHistory::memory_usage() +
         static_cast<double>((tag_.capacity() + born_as_.capacity() + now_.capacity()) *
                             sizeof(int));
}
