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
