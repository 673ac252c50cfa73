#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/liner/profile.h"
#include "core/math/constants.h"
#include "core/math/mill_frame.h"
#include "core/math/vector.h"

namespace millscale::detachment {

/// The mill and its liner.
struct Mill {
  MillFrame frame;
  double radius = 0.0;  ///< at the liner [m]
  liner::Grooves grooves{};
};

/// A point of the cross-section in polar form.
struct PolarPosition {
  double radius;  ///< distance from the axis [m]
  double psi;     ///< angle from the bottom in the direction of rotation, (-pi, pi] [rad]
};

inline PolarPosition polar(const Mill& mill, const Vector& position)
{
  const MillPoint p = mill.frame.point(position.data());
  return {std::hypot(p.below, p.ahead), std::atan2(p.ahead, p.below)};
}

/// Square of the distance from the axis [m^2].
inline double square_from_axis(const Mill& mill, const Vector& position)
{
  const Vector p = mill.frame.arm(position);
  const double along = dot(p, mill.frame.axis());
  return std::max(0.0, dot(p, p) - along * along);
}

/// Angle from the vertical (the top), positive on the rising side, (-pi, pi] [rad].
inline double angle_from_vertical(double psi)
{
  const double alpha = pi - psi;
  return alpha > pi ? alpha - 2.0 * pi : alpha;
}

/// Groove of the liner that a polar angle lies in; its lifter trails it and pushes its balls. A
/// liner without lifters has a groove for each sector, a plain drum the groove 0.
inline int groove(const Mill& mill, double psi, double mill_angle)
{
  return mill.grooves.at(psi - mill_angle);
}

/// The grooves in a turned mill. Whether a point is still in a groove is decided by the direction
/// of its middle, without an arctangent, except close to a border.
class TurnedGrooves {
 public:
  TurnedGrooves(const Mill& mill, double mill_angle) : mill_angle_(mill_angle)
  {
    const liner::Grooves& grooves = mill.grooves;
    for (int k = 0; k < grooves.count(); ++k) {
      const double begin = grooves.lifter_angle(k);
      const double end = k + 1 < grooves.count() ? grooves.lifter_angle(k + 1)
                                                 : grooves.lifter_angle(0) + 2.0 * pi;
      const double half = 0.5 * (end - begin);
      middles_.push_back(
          {Turn(mill_angle + begin + half), half < wide ? std::tan(half - margin) : 0.0});
    }
  }

  /// Return `groove` of a point. guess: the likely groove; -1: none.
  double at(const Mill& mill, const Vector& position, double guess) const
  {
    if (guess >= 0.0 && guess < static_cast<double>(middles_.size())) {
      const auto& [turn, slope] = middles_[static_cast<std::size_t>(guess)];
      const MillPoint p = mill.frame.point(position.data());
      const double outward = p.below * turn.cosine + p.ahead * turn.sine;
      const double aside = p.ahead * turn.cosine - p.below * turn.sine;
      if (std::abs(aside) < slope * outward) return guess;
    }
    return groove(mill, polar(mill, position).psi, mill_angle_);
  }

 private:
  static constexpr double wide = 1.5, margin = 1e-9;  ///< [rad]
  struct Middle {
    Turn turn;
    double slope;  ///< of the borders against the middle; 0 if they are too wide apart
  };
  double mill_angle_;
  std::vector<Middle> middles_;
};

enum class State { on_wall = 1, in_bed = 2, in_flight = 3 };

/// Return the state of a ball by its contacts: with the wall, and with anything.
inline State state(bool wall_contact, bool contact_force)
{
  if (wall_contact) return State::on_wall;
  return contact_force ? State::in_bed : State::in_flight;
}

/// Contacts and position of a ball at the end of a step.
struct Observation {
  bool liner_contact;  ///< touches the groove (not only a lifter)
  bool wall_contact;   ///< touches any part of the wall
  bool contact_force;  ///< feels any contact force, of wall or ball
  Vector position, velocity;
  double ball_radius, mill_angle, time;
};

/// A moment at which a ball lost a contact. count is the number of confirmed ones so far; angle and
/// groove are worked out when it is confirmed.
struct Event {
  double count = 0.0, angle = 0.0, mill_angle = 0.0, groove = 0.0, time = 0.0;
  Vector position{}, velocity{};
};

/// Record of one ball. All members are double, so that the engine can carry the record through rank
/// changes and restarts as an array.
struct Record {
  double state = 2.0;          ///< State; in bed until observed
  double had_liner = 0.0;      ///< liner contact at the last observation
  double had_force = 0.0;      ///< contact force at the last observation
  double liner_pending = 0.0;  ///< contact lost, ball still near
  double flight_pending = 0.0;
  double in_flight = 0.0;      ///< a confirmed flight goes on
  double touched_liner = 0.0;  ///< on the liner since its last flight began
  double outermost = 0.0;      ///< the last flight began from the outermost layer
  double carrier = -1.0;       ///< lifter that carried the ball last; -1: not seen yet
  Event liner_candidate, flight_candidate;
  Event liner_off, flight;  ///< confirmed
  Vector flight_place{};    ///< of the flight candidate, in the frame that turns with the mill
};
inline constexpr int record_size = sizeof(Record) / sizeof(double);
static_assert(sizeof(Record) == record_size * sizeof(double), "Record holds doubles only");

/// Which events were confirmed by an observation.
struct Confirmed {
  bool liner_off = false, flight = false;
};

namespace detail {

inline Event event_at(const Observation& now, double count)
{
  Event e;
  e.count = count;
  e.mill_angle = now.mill_angle;
  e.time = now.time;
  e.position = now.position;
  e.velocity = now.velocity;
  return e;
}

inline Event confirmed_event(const Mill& mill, Event e)
{
  const double psi = polar(mill, e.position).psi;
  e.angle = angle_from_vertical(psi);
  e.groove = groove(mill, psi, e.mill_angle);
  return e;
}

/// Whether a ball is farther from the groove than `gap` [m].
inline bool clear_of_groove(const Mill& mill, const Vector& position, double ball_radius,
                            double gap)
{
  const double inside = std::max(0.0, mill.radius - ball_radius - gap);
  return square_from_axis(mill, position) < inside * inside;
}

inline void follow_liner(Record& ball, const Mill& mill, const Observation& now, double gap,
                         Confirmed& confirmed)
{
  if (now.liner_contact) {
    ball.liner_pending = 0.0;
    ball.touched_liner = 1.0;
  } else if (ball.had_liner != 0.0) {
    ball.liner_candidate = event_at(now, ball.liner_off.count + 1.0);
    ball.liner_pending = 1.0;
  }
  if (ball.liner_pending != 0.0 && clear_of_groove(mill, now.position, now.ball_radius, gap)) {
    ball.liner_off = confirmed_event(mill, ball.liner_candidate);
    ball.liner_pending = 0.0;
    confirmed.liner_off = true;
  }
  ball.had_liner = now.liner_contact;
}

/// Return the position of the ball in the frame that turns with the mill, from the mill's origin.
inline Vector position_in_mill(const Mill& mill, const Vector& position, const Turn& back)
{
  return rotated(mill.frame.arm(position), mill.frame.axis(), back);
}

/// Return the squared distance of two points in the cross-section: the box may be periodic along
/// the axis.
inline double square_separation(const Mill& mill, const Vector& a, const Vector& b)
{
  Vector separation;
  for (int d = 0; d < 3; ++d) separation[d] = a[d] - b[d];
  const double along = dot(separation, mill.frame.axis());
  return std::max(0.0, dot(separation, separation) - along * along);
}

/// Whether a ball has left a place in the mill by more than `gap` [m].
inline bool left_place(const Mill& mill, const Vector& position, const Turn& back,
                       const Vector& place, double gap)
{
  return square_separation(mill, position_in_mill(mill, position, back), place) > gap * gap;
}

inline void follow_flight(Record& ball, const Mill& mill, const Observation& now, const Turn& back,
                          double gap, Confirmed& confirmed)
{
  if (now.contact_force) {
    ball.flight_pending = 0.0;
    ball.in_flight = 0.0;
  } else if (ball.had_force != 0.0) {
    ball.flight_candidate = event_at(now, ball.flight.count + 1.0);
    ball.flight_place = position_in_mill(mill, now.position, back);
    ball.flight_pending = 1.0;
  }
  if (ball.flight_pending != 0.0 && left_place(mill, now.position, back, ball.flight_place, gap)) {
    ball.flight = confirmed_event(mill, ball.flight_candidate);
    ball.flight_pending = 0.0;
    ball.in_flight = 1.0;
    ball.outermost = ball.touched_liner;
    ball.touched_liner = 0.0;
    confirmed.flight = true;
  }
  ball.had_force = now.contact_force;
}

}  // namespace detail

/// What an observation with the same contacts as the last one could still confirm. Balls that lie
/// near the groove without touching it, or shake in the bed, wait for long.
enum class Pending : signed char { nothing, liner, flight, both };
inline Pending pending(const Record& ball)
{
  const bool liner = ball.liner_pending != 0.0;
  if (ball.flight_pending != 0.0) return liner ? Pending::both : Pending::flight;
  return liner ? Pending::liner : Pending::nothing;
}

/// Whether an observation with the same contacts may change the record of a ball. Of the record it
/// needs the place of the flight candidate only. back: the turn by minus the mill's angle.
inline bool may_confirm(Pending pending, const Mill& mill, const Vector& position, const Turn& back,
                        const Vector& flight_place, double ball_radius, double gap_over_radius)
{
  const double gap = gap_over_radius * ball_radius;
  const bool liner = pending == Pending::liner || pending == Pending::both;
  const bool flight = pending == Pending::flight || pending == Pending::both;
  return (liner && detail::clear_of_groove(mill, position, ball_radius, gap)) ||
         (flight && detail::left_place(mill, position, back, flight_place, gap));
}

/// Advances a ball's record by one observation. Two events are told apart:
///   liner_off  the groove's contact is lost, and the ball has since moved inward by more than
///              `gap_over_radius` ball radii (it may ride a lifter face);
///   flight     no contact force of any kind, and the ball has since left the place that moves with
///              the mill by more than `gap_over_radius` ball radii.
/// Either is recorded as of the step at which contact was lost; a ball that touches again before
/// the gap is reached has only rattled, and nothing is recorded. Derived here.
/// `back` is the turn by minus the mill's angle.
inline Confirmed observe(Record& ball, const Mill& mill, const Observation& now, const Turn& back,
                         double gap_over_radius)
{
  Confirmed confirmed;
  ball.state = static_cast<double>(state(now.wall_contact, now.contact_force));
  const double gap = gap_over_radius * now.ball_radius;
  detail::follow_liner(ball, mill, now, gap, confirmed);
  detail::follow_flight(ball, mill, now, back, gap, confirmed);
  return confirmed;
}
inline Confirmed observe(Record& ball, const Mill& mill, const Observation& now,
                         double gap_over_radius)
{
  return observe(ball, mill, now, Turn(-now.mill_angle), gap_over_radius);
}

/// How fast the mill turns [rad/s], and gravity [m/s^2].
struct Drive {
  double speed, gravity;
};

/// Return whether the mill carries a ball: it touches the wall, or it touches balls and moves with
/// the mill. It moves with the mill if it is slower, relative to the mill, than after a fall
/// through `gap_over_radius` ball radii, v^2 = 2 g gap. A detached ball passes this speed as it
/// falls behind by the gap. Balls that collide in flight are therefore not carried. Derived here.
inline bool carried(const Mill& mill, const Drive& drive, const Observation& now,
                    double gap_over_radius)
{
  if (now.wall_contact || !now.contact_force) return now.wall_contact;
  const Vector with_mill = cross(mill.frame.axis(), mill.frame.arm(now.position));
  double square = 0.0;
  for (int d = 0; d < 3; ++d) {
    const double relative = now.velocity[d] - drive.speed * with_mill[d];
    square += relative * relative;
  }
  return square < 2.0 * drive.gravity * gap_over_radius * now.ball_radius;
}

/// Remembers the lifter that carries a ball, -1 if none has. A ball that is not carried keeps the
/// lifter it left, whatever it meets in flight. What moves with the mill changes its lifter slowly:
/// a look at every few thousandths of a turn is enough.
inline void follow_carrier(double& carrier, const Mill& mill, const TurnedGrooves& grooves,
                           const Drive& drive, const Observation& now, double gap_over_radius)
{
  if (carried(mill, drive, now, gap_over_radius)) carrier = grooves.at(mill, now.position, carrier);
}
inline void follow_carrier(double& carrier, const Mill& mill, const Drive& drive,
                           const Observation& now, double gap_over_radius)
{
  follow_carrier(carrier, mill, TurnedGrooves(mill, now.mill_angle), drive, now, gap_over_radius);
}

/// Count, mean and standard deviation of event angles, gathered one by one (Welford's recurrence)
/// and merged across ranks (Chan, Golub, LeVeque, Am. Stat. 37 (1983) 242).
struct AngleStatistics {
  double count = 0.0, mean = 0.0, sum_squares = 0.0;  ///< sum of squared deviations [rad^2]

  void add(double angle)
  {
    count += 1.0;
    const double deviation = angle - mean;
    mean += deviation / count;
    sum_squares += deviation * (angle - mean);
  }
  void merge(const AngleStatistics& other)
  {
    if (other.count == 0.0) return;
    const double total = count + other.count, deviation = other.mean - mean;
    mean += deviation * other.count / total;
    sum_squares += other.sum_squares + deviation * deviation * count * other.count / total;
    count = total;
  }
  /// Of a sample (n - 1); 0 below two events [rad].
  double standard_deviation() const
  {
    return count < 2.0 ? 0.0 : std::sqrt(sum_squares / (count - 1.0));
  }
};

}  // namespace millscale::detachment
