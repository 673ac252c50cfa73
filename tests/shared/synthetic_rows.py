"""Rows of a study, made up: times and errors as given."""

from millscale.study import pareto
from millscale.study.errors import ERRORS


def error(value, spread=0.0):
    within = None if value is None or spread is None else value <= spread
    return {"error": value, "spread": spread, "within_spread": within}


def row(label, time, value, spread=0.0, **more):
    """A setting with the same error of every kind."""
    made = {
        "label": label,
        "setting": label,
        "time_s": time,
        "time_spread_s": 0.1 * time,
        "is_reference": False,
        "is_default": False,
        "engine": "millscale",
        "errors": {name: error(value, spread) for name in ERRORS},
    } | more
    return made | {"worst": pareto.worst_of(made["errors"], list(ERRORS))}
