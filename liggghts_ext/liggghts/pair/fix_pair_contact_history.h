#pragma once

#include <vector>

#include "fix_contact_history.h"
#include "neigh_list.h"

#include "core/neighbor/history_transfer.h"

namespace LAMMPS_NS {

/// The engine's contact history, replaced, and the pair list of `surface fast`. Contact histories
/// of particles that stay on their rank are transferred from list to list. Only those of particles
/// that leave, or all before a restart file or a set-up, are stored in the engine's arrays. With
/// other contact styles this fix is the engine's.
class FixPairContactHistory : public FixContactHistory {
 public:
  FixPairContactHistory(class LAMMPS*, int, char**);
  ~FixPairContactHistory() override;

  void pre_delete(bool by_unfix) override;
  void pre_exchange() override;
  void setup_pre_exchange() override;
  double memory_usage() override;
  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double*) override;
  int unpack_exchange(int, double*) override;

  /// Record the work of contacts in the lists from the next one on, and keep that of balls that
  /// leave in a fix; null: record none.
  void record_work(class FixMillImpacts*);
  /// Return the list to build. The old list is kept until `take_over_history`.
  millscale::neighbor::PairList& next_list();
  /// Transfer all contact histories to the new list, and set it as the engine's neighbour list.
  void take_over_history(const millscale::neighbor::Particles&, class PairGran*);
  millscale::neighbor::PairList& list() { return list_; }
  /// Note that the list holds the histories, after an evaluation that the engine does not see.
  void in_list() { *computeflag_ = 1; }

 private:
  void store_history();
  void mark_leaving();
  void find_current_indices();
  void publish(class PairGran*);

  millscale::neighbor::PairList list_, old_list_;
  class FixMillImpacts* impacts_ = nullptr;  ///< keeps the work of contacts; null if nobody records
  bool in_use_ = false;                      ///< the list holds the histories of the last step
  bool stays_in_list_ = false;               ///< the histories stay in the list during the exchange
  millscale::neighbor::Tags tag_;            ///< of the particles of the list
  std::vector<int> index_in_list_;           ///< of each particle, or absent
  std::vector<int> current_index_;           ///< of each local particle of the list, or absent
  std::vector<char> leaving_;                ///< of each local particle of the list

  NeighList engine_list_, engine_history_list_;
  std::vector<int> owned_;
  std::vector<int*> first_other_, first_touching_;
  std::vector<double*> first_displacement_;
};

}  // namespace LAMMPS_NS
