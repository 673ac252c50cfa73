"""Scaled mills of one physical mill whose torque follows a known power of S."""

import numpy as np

from millscale.prediction.extrapolation import scale_function
from millscale.runs.writing import write_json
from synthetic_case import (
    case_document,
    finish_case,
    timing_document,
    write_campaign,
    write_case,
)
from synthetic_charge import charge_columns

BALLS_AT_1 = 20_000
END = 6.0  # mill angle of the rotation [rad]
TORQUE, EXPONENT, SLOPE = 0.36, 0.3, 0.02
COST_AT_1 = 900.0  # of a rotation [s]
SEEDS = {1: 1e-3, 2: -1e-3}  # of the torque, relative


def torque_number(S, seed):
    """Return the torque over M g R: a power of S, and the scatter of the seeds."""
    return (TORQUE + SLOPE * float(scale_function(S, EXPONENT))) * (1.0 + SEEDS[seed])


def charge_case(S, seed, scheme="constant-gravity", policy="paper", **changes):
    """Return the content of a case.json of a mill of equal filling; `part__key` changes a value."""
    case = case_document("multi-ball", scheme, policy, S, round(BALLS_AT_1 / S**3), 0.02)
    case["id"] += f"-seed{seed}"
    case["seed"] = seed
    if policy == "friction-matched":
        case["factors"]["friction"] = 1.0 / S
        case["material"]["static_friction_pp"] /= S
    for path, value in changes.items():
        part, _, key = path.partition("__")
        case[part][key] = value
    return case


def columns_of(case, steady=True, torque=torque_number):
    """Return the series of a steady charge whose torque and centre of mass follow a law.

    Args:
        torque: returns the torque number of an S and a seed.
    """
    columns, mill = charge_columns(case, END), case["mill"]
    mass = case["ball"]["mass_kg"] * case["ball"]["count"]
    weight = mass * mill["gravity_m_s2"] * mill["radius_m"]
    angle, number = columns["mill_angle_rad"], torque(case["S"], case["seed"])
    wave = 0.02 * np.sin(25.0 * angle)
    drift = 0.0 if steady else 0.1 * angle / END
    columns["centre_x_m"] = -mill["radius_m"] * (number + wave + drift)
    columns["drive_work_J"] = weight * (number * angle + 0.02 * (1.0 - np.cos(25.0 * angle)) / 25.0)
    columns["angular_momentum_Nms"] = 0.1 * weight * np.ones_like(angle)
    return columns


def write_mills(runs, *cases, unsteady=(), torque=torque_number):
    """Write the finished cases of a campaign; a rotation takes `COST_AT_1` / S^3 of processor time,
    settling a tenth of it."""
    folders = []
    for case in cases:
        columns = columns_of(case, case["id"] not in unsteady, torque)
        folders.append(write_case(runs, case, columns))
        cost = COST_AT_1 / case["S"] ** 3
        timing = timing_document(case["ball"]["count"], 9000) | {"processor_time_s": cost}
        write_json(folders[-1] / "timing.json", timing)
        write_json(folders[-1] / "settled.json", {"processor_time_s": 0.1 * cost})
        finish_case(folders[-1])
    write_campaign(runs, [folder.name for folder in folders])
    return runs
