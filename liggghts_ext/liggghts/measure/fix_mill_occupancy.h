#pragma once

#include <memory>
#include <string>
#include <vector>

#include "fix.h"

#include "core/measure/occupancy_grid.h"

namespace LAMMPS_NS {

class FixMillSimilarity;

/// Solid fraction of the cross-section on a polar grid, averaged over the samples between two mill
/// angles, to a file. Arguments: docs/reference/styles/fix-mill-occupancy.md.
/// File: docs/reference/files.md, occupancy.csv.
class FixMillOccupancy : public Fix {
 public:
  FixMillOccupancy(class LAMMPS*, int, char**);

  int setmask() override;
  void init() override;
  void end_of_step() override;
  void post_run() override;
  double compute_scalar() override;
  void write_restart(FILE*) override;
  void restart(char*) override;

 private:
  /// What is gathered besides the volumes, alike on all ranks.
  struct Window {
    double samples = 0.0, first_angle = 0.0, last_angle = 0.0;
    double written = 0.0;  ///< 1: complete, and in the file
  };

  void parse(int narg, char** arg);
  void sample(double mill_angle);
  std::vector<double> volumes_of_all_ranks() const;
  void write();
  bool put_file(const std::string& name, const std::vector<double>& volumes) const;
  double mill_length() const;

  std::string mill_id_, file_;
  FixMillSimilarity* mill_fix_ = nullptr;
  double from_ = 0.0, to_ = -1.0;  ///< mill angles of the window [rad]
  int rings_ = 50, sectors_ = 180;
  Window window_;
  std::unique_ptr<millscale::charge::OccupancyGrid> grid_;
};

}  // namespace LAMMPS_NS
