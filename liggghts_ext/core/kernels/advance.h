#pragma once

#include <cstddef>
#include <cstdint>

#include "core/kernels/rows.h"
#include "core/math/vector.h"

namespace millscale::kernels {

/// Force of one contact with a wall on a ball, in the layout of a force row. The number of the ball
/// is in the place that a force row does not use.
struct alignas(64) WallForce {
  double force[3], ball;      ///< [N]
  double torque[3], damping;  ///< [N m]; tangential coefficient [kg/s]
};

/// What the velocity of a ball gains per force and torque in half a step.
struct Kick {
  double linear, angular;  ///< dt / 2m [s/kg], dt / 2I [s/(kg m^2)]
};

/// A ball when the neighbour list was built.
struct alignas(32) ListStart {
  double x, y, z;  ///< position [m]
  double skin;     ///< of the ball [m]
};

/// A ball whose contacts have changed, or that is watched, at the end of a step.
struct alignas(64) Moment {
  double position[3], radius;  ///< [m]
  double velocity[3];          ///< [m/s]
  int ball;
};

/// A ball that is too fast, at the end of a step.
struct FastBall {
  int ball;
  Vector position, velocity, force;  ///< [m], [m/s], [N]
};

/// Reads the contacts of the balls at the end of a step, for `fix mill/detach/track`.
struct ContactWatch {
  const signed char* wall_marks;  ///< contacts with walls, as bits
  const signed char* seen;        ///< the marks of the last observation
  signed char* marks;             ///< all contacts
  signed char in_contact;         ///< bit of any contact force
  double least;                   ///< square of the least acceleration by contacts [m^2/s^4]
  Moment* moments;                ///< balls whose marks differ from those seen; as many as balls
};

/// The arrays of the engine, three numbers per ball, to which the pass copies the end of the step.
struct EndOfStep {
  double (*position)[3], (*velocity)[3], (*spin)[3];  ///< [m], [m/s], [rad/s]
  double (*force)[3], (*torque)[3];                   ///< [N], [N m]
};

/// One pass over the local balls between two evaluations of the forces: the second half of a step
/// and the first half of the next one, with the arithmetic of `fix nve/sphere` and of the engine's
/// own checks, in their order. Nothing is owned here.
struct Advance {
  Rows rows;    ///< velocity rows in double precision always
  bool single;  ///< the force rows, and a copy of the velocity rows, in single precision
  int balls;
  const Kick* kick;
  double dt;                    ///< [s]
  Vector gravity;               ///< acceleration [m/s^2]
  bool gravity_first;           ///< add the weight before the forces of the walls
  const WallForce* wall_begin;  ///< in ascending order of the ball
  const WallForce* wall_end;

  double* damping;  ///< sum of the tangential coefficients [kg/s], if damping is limited; else null

  // The neighbour list is valid until a ball has moved by more than half the engine's skin, or by
  // more than its own skin in a turning frame.
  const ListStart* start;
  double moved_limit2;  ///< square of half the engine's skin [m^2]
  bool own_skins;
  Vector origin;           ///< of the turning frame [m]
  Vector turn_columns[3];  ///< of the matrix that turns the frame from the list to the next step

  bool checks_speed;
  double speed_limit2;        ///< square of the highest plausible speed [m^2/s^2]
  const ContactWatch* watch;  ///< null if nobody watches
  const EndOfStep* copy;      ///< null if nobody reads
};

/// What the pass has found.
struct Advanced {
  bool moved = false, left_skin = false;  ///< a new list is needed
  bool fast = false;                      ///< a ball is faster than the limit
  FastBall first_fast;                    ///< that ball
  int moments = 0;                        ///< number of moments written
};

using AdvanceBalls = Advanced (*)(const Advance&);

}  // namespace millscale::kernels
