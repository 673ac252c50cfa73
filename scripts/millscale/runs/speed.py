"""The mill's speed against its angle, of a case."""

from __future__ import annotations

from millscale import _core
from millscale.runs.case_file import Case, Times


def schedule_of(case: Case) -> _core.SpeedSchedule:
    """Return the speed of a case's mill over its constant speed, against its angle."""
    return _core.SpeedSchedule(list(case.time.speed_changes))


def turned_angle(time: Times, omega: float) -> float:
    """Return the mill angle at the end of the rotation [rad].

    Args:
        omega: speed of the scaled mill [rad/s].
    """
    phase = time.rotation_steps * time.step_s * omega
    return _core.SpeedSchedule(list(time.speed_changes)).angle(phase)


def steps_of_dumps(case: Case, first: int) -> range | list[int]:
    """Return the steps at which the rotation of a case dumps its balls, in ascending order.

    Args:
        first: step at which the rotation begins.
    """
    time, output = case.time, case.output
    last = first + time.rotation_steps
    if not time.speed_changes:
        return range(first, last + 1, output.dump_steps)
    schedule, turn = schedule_of(case), case.mill.omega_rad_s * time.step_s
    steps, multiple = [first], 1
    while (step := _step_at(schedule, multiple * output.dump_angle_rad, turn, first)) <= last:
        steps.append(step)
        multiple += 1
    return steps


def _step_at(schedule: _core.SpeedSchedule, angle: float, turn: float, first: int) -> int:
    """Return the step nearest to a mill angle; `turn` is that of a step at full speed [rad]."""
    return first + int(_core.nearest_step(schedule.phase(angle) / turn))
