#pragma once

#include "pairs/balls.h"

namespace millscale::pairs {

/// Balls sorted into the cells of a grid. Nothing is owned here.
struct Cells {
  struct Row {
    double x, y, z, radius;
  };
  const int* start;    ///< balls of cell c are start[c] .. start[c + 1]
  const int* cell_of;  ///< of ball i
  const Row* sorted;
  const int* index;  ///< of the sorted balls: i
  int size[2];       ///< cells along x and y
};

/// Visits the ranges of sorted balls in the cells around that of ball i: three cells of a row lie
/// side by side, and a layer of empty cells surrounds the grid.
template <class Visit>
inline void for_rows_around(const Cells& cells, int i, const Visit& visit)
{
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy) {
      const int row = cells.cell_of[i] + cells.size[0] * (dy + cells.size[1] * dz);
      visit(cells.start[row - 1], cells.start[row + 2]);
    }
}

/// Writes every ball j > i whose surface meets a ball at the centre and of the radius given;
/// returns the end. Up to four ints beyond the end may be written.
using ListPartners = int* (*)(const Cells&, int i, Cells::Row centre, int* out);

}  // namespace millscale::pairs
