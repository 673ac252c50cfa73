"""Synthetic rows of a parameter study, with given times and errors."""

from dataclasses import replace

from millscale.analysis.measures import STUDIED
from millscale.study import pareto
from millscale.study.errors import StudyError
from millscale.study.pareto import SettingRow


def error(value, spread=0.0):
    within = None if value is None or spread is None else value <= spread
    return StudyError(value, spread, within)


def row(label, time, value, spread=0.0, **more):
    """Return a setting with the same error of every kind."""
    made = SettingRow(
        setting=label,
        label=label,
        about="",
        is_reference=False,
        is_default=False,
        reference="truth",
        scheme="constant-gravity",
        policy="paper",
        S=2.6,
        stiffness="fixed",
        balls=1000,
        step_s=1e-4,
        engine="millscale",
        contacts="fast",
        damping="bounded",
        wall="analytic",
        length_m=0.1,
        rotation_angle_rad=8.0,
        seeds=2,
        ranks=1,
        wall_time_s=time,
        processor_time_s=time,
        time_is="processor",
        time_s=time,
        time_spread_s=0.1 * time,
        errors=dict.fromkeys(STUDIED, error(value, spread)),
    )
    made = replace(made, **more)
    return replace(made, worst=pareto.worst_of(made.errors, list(STUDIED)))
