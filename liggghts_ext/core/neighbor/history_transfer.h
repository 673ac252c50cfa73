#pragma once

#include <vector>

#include "core/neighbor/pair_list.h"

namespace millscale::pairs {

/// In place of an index: not there.
constexpr int absent = -1;

/// Names of balls in the order of a list; ghosts have those of their balls.
using Tags = std::vector<int>;

inline bool overlap(const Balls& balls, int i, int j)
{
  const double radii = balls.radius[i] + balls.radius[j];
  return apart_square(balls, i, j) < radii * radii;
}

/// Restores the contact history of ball i with the ball of this tag: `memory` times `sign`, if the
/// pair is listed under i and overlaps. Returns true if that is the contact's only entry: one with
/// a ghost has a second, under the ball that the ghost is an image of.
inline bool remember(HalfList& list, const Balls& balls, const int* tag, int i, int name,
                     const double* memory, double sign)
{
  bool only = false;
  for (int entry = list.first[i]; entry < list.first[i] + list.partners[i]; ++entry) {
    const int j = list.other[entry];
    if (tag[j] != name || !overlap(balls, i, j)) continue;
    list.touching[entry] = 1;
    for (int d = 0; d < 3; ++d) list.displacement[3 * entry + d] = sign * memory[d];
    only = j < balls.owned;
  }
  return only;
}

/// Carries the contact histories from list to list, whatever the balls are numbered in the new one.
/// Either ball may have the pair now; both have it once one of them has left through a periodic end
/// of the same rank. `now`: index in the new list of each owned ball of the old, or `absent`.
inline void carry(const HalfList& old, const Tags& old_tag, const std::vector<int>& now,
                  HalfList& list, const Balls& balls, const int* tag)
{
  for (int entry = 0; entry < old.entries; ++entry) {
    if (!old.touching[entry]) continue;
    const int a = old.own[entry], b = old.other[entry];
    const int i = now[a], j = b < old.owned() ? now[b] : absent;
    const double* memory = &old.displacement[3 * static_cast<std::size_t>(entry)];
    if (i != absent && remember(list, balls, tag, i, old_tag[b], memory, 1.0)) continue;
    if (j != absent) remember(list, balls, tag, j, old_tag[a], memory, -1.0);
  }
}

/// The contacts of the owned balls that are marked: visit(ball, name of the other, memory, sign),
/// where sign times memory is that on the ball.
template <class Visit>
void for_memories_of(const std::vector<char>& marked, const HalfList& list, const Tags& tag,
                     const Visit& visit)
{
  for (int entry = 0; entry < list.entries; ++entry) {
    if (!list.touching[entry]) continue;
    const int a = list.own[entry], b = list.other[entry];
    const double* memory = &list.displacement[3 * static_cast<std::size_t>(entry)];
    if (marked[a]) visit(a, tag[b], memory, 1.0);
    if (b < list.owned() && marked[b]) visit(b, tag[a], memory, -1.0);
  }
}

}  // namespace millscale::pairs
