#pragma once

#include <vector>

#include "fix_contact_history.h"
#include "neigh_list.h"

#include "core/neighbor/history_transfer.h"

namespace LAMMPS_NS {

/// The engine's contact history, in its place, and the neighbour list of `surface fast`. Memories
/// of balls that stay on their rank go from list to list without the history; it gets those of
/// balls that leave, and all for restart files and set-ups. With other contacts it is the engine's.
class FixPairMemories : public FixContactHistory {
 public:
  FixPairMemories(class LAMMPS*, int, char**);
  ~FixPairMemories() override;

  void pre_delete(bool by_unfix) override;
  void pre_exchange() override;
  void setup_pre_exchange() override;
  double memory_usage() override;
  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double*) override;
  int unpack_exchange(int, double*) override;

  /// To be built, and then to be given its memories. The one before is kept until then.
  millscale::pairs::HalfList& next_list();
  /// The new list takes on what is remembered, and the engine is shown it as one of its own.
  void take_on(const millscale::pairs::Balls&, class PairGran*);
  millscale::pairs::HalfList& list() { return list_; }

 private:
  void hand_over();
  void mark_leaving();
  void find_now();
  void show(class PairGran*);

  millscale::pairs::HalfList list_, old_list_;
  bool in_use_ = false;         ///< the list holds the memories of the last step
  bool stays_in_list_ = false;  ///< they are in it over the exchange
  millscale::pairs::Tags tag_;  ///< of the balls of the list
  std::vector<int> born_as_;    ///< of each ball its index in the list, or absent
  std::vector<int> now_;        ///< the other way round
  std::vector<char> leaving_;   ///< of the list's owned balls

  NeighList shown_, shown_history_;
  std::vector<int> owned_;
  std::vector<int*> first_other_, first_touching_;
  std::vector<double*> first_displacement_;
};

}  // namespace LAMMPS_NS
