"""Made-up run folders in the form of docs/reference/files.md, with motion known in closed form."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from millscale import _core
from millscale.analysis.case import analyse_case
from millscale.runs.case_digest import case_digest
from millscale.runs.case_file import Case, case_of
from millscale.runs.digests import digest_of
from millscale.runs.layout import STAGES
from millscale.runs.provenance import write_provenance
from millscale.runs.writing import write_json

PHYSICAL = _core.OperatingPoint(radius=3.9, ball_radius=0.02, gravity=9.81, omega=1.0)
LINER = _core.Lifters(3.9, 3.61, 0.25, 0.635, 25)
SHORT = {"constant-gravity": "cg", "constant-speed": "cs", "froude": "fr"}
LENGTH = 1.0
MODELS = (1.0, 1.3, 2.6)
SCHEMES = ("constant-gravity", "constant-speed")
POLICIES = ("paper", "corrected", "offset-liner")


def case_document(
    kind: str, scheme: str, policy: str, S: float, balls: int = 1, sample_angle: float = 0.004
) -> dict[str, Any]:
    """Return the content of a case.json."""
    scaled = _core.scale(PHYSICAL, S, scheme, policy)
    offset = policy == "offset-liner"
    liner = LINER.offset_scaled(S, PHYSICAL.ball_radius) if offset else LINER.scaled(S)
    mill = scaled.mill
    critical = _core.critical_speed(mill)
    mass = 2678.0 * 4.0 / 3.0 * math.pi * mill.ball_radius**3
    short = {"single-ball": "sb", "multi-ball": "mb"}[kind]
    return {
        "schema": 1,
        "id": f"{short}-{SHORT[scheme]}-{policy}-S{S:.3f}",
        "campaign": "synthetic",
        "kind": kind,
        "scheme": scheme,
        "policy": policy,
        "S": S,
        "time_factor": 0.0,
        "allow_centrifuging": False,
        "seed": 1,
        "physical": {"radius_m": 3.9, "ball_radius_m": 0.02, "gravity_m_s2": 9.81}
        | {"omega_rad_s": 1.0, "length_m": LENGTH, **widths(LINER)},
        "mill": {
            "radius_m": liner.radius,
            "length_m": LENGTH / S,
            "simulated_length_m": LENGTH / S,
            "gravity_m_s2": mill.gravity,
            "omega_rad_s": mill.omega,
            "froude": scaled.froude,
            "critical_speed_rad_s": critical,
            "percent_of_critical": 100.0 * mill.omega / critical,
            "detach_angle_deg": math.degrees(_core.detach_angle(scaled.froude)),
            "regime": _core.regime(scaled.froude),
            **widths(liner),
            "phase_rad": 0.0,
            "area_m2": liner.area,
        },
        "factors": {
            "length": scaled.base.length,
            "mass": 1.0,
            "time": scaled.base.time,
            "energy": _core.factor(scaled.base, 2, 1, -2),
        },
        "predicted_energy_ratio": scaled.predicted_energy_ratio,
        "centre_path_energy_ratio": scaled.centre_path_energy_ratio,
        "groups": {
            "ball_radius_over_mill_radius": mill.ball_radius / liner.radius,
            "lifter_height_over_ball_diameter": 7.0,
            "groove_width_over_ball_diameter": liner.groove_width / (2.0 * mill.ball_radius),
            "length_over_ball_diameter": LENGTH / S / (2.0 * mill.ball_radius),
        },
        "ball": {
            **{"radius_m": 0.02, "density_kg_m3": 2678.0, "mass_kg": mass, "count": balls},
            **{"radius_std_m": 0.0, "truncation": 3.0},
        },
        "material": {
            **{"youngs_modulus_pa": 5.98e7, "shear_modulus_pa": 2.3e7, "poisson_ratio": 0.3},
            **dict.fromkeys(("restitution_pp", "restitution_pw"), 0.2),
            **dict.fromkeys(("static_friction_pp", "static_friction_pw"), 0.5),
            **dict.fromkeys(("rolling_friction_pp", "rolling_friction_pw"), 0.01),
            "stiffness": "fixed",
        },
        "time": {
            **{"step_s": 1e-4, "step_choice": "given", "start_s": 0.1},
            **{"rest_steps": 1000, "settle_steps": 0, "rotation_steps": 9000, "steps": 10000},
            **{"rotation_angle_rad": 1.0, "duration_s": 1.0, "sample_angle_rad": sample_angle},
            **{"rayleigh_time_s": 1e-3, "rayleigh_fraction": 0.1},
            **{"damping_limit_s": 1e-3, "limit_fraction": 0.1, "mean_overlap_m": 1e-5},
            **{"impact_speed_m_s": 5.0, "collision_time_s": 1e-3, "steps_per_contact": 10.0},
        },
        "wall": {"kind": "analytic", "chord_error_m": 1e-3, "axial_divisions": 1, "triangles": 9},
        "deck": {
            **{"pair": "gran", "dumps": "on", "surface": "fast", "tangential_damping": "bounded"},
            **dict.fromkeys(("rolling_model_pp", "rolling_model_pw"), "cdt"),
            **dict.fromkeys(("tangential_model_pp", "tangential_model_pw"), "history"),
        },
        "domain": {"half_box_m": 4.0, "skin_m": 0.02},
        "output": {
            **{"thermo_steps": 100, "sample_steps": 100, "dump_steps": 1000, "restart_steps": 1000},
            **{"dump_angle_rad": 0.5, "restart_angle_rad": 0.5},
        },
        "warnings": [],
        "model": {
            "in": [{"what": "lifters", "reason": "Table 4"}],
            "out": [{"what": "air", "reason": "its drag on 20 mm balls is below 1 % of gravity"}],
        },
        "versions": {"millscale": "0"},
        "predicted": {"particle_steps": 1, "ranks": 1, "wall_time_s": 1.0, "output_bytes": 1},
        "digest": "0" * 64,
    }


def typed(document: dict[str, Any]) -> Case:
    """Return the case of a content of case.json."""
    return case_of(Path("case.json"), document)


def widths(liner: _core.Lifters) -> dict[str, float]:
    """Return the liner keys shared by `physical` and `mill`."""
    return {
        "lifter_top_radius_m": liner.lifter_top_radius,
        "lifter_top_width_m": liner.lifter_top_width,
        "groove_width_m": liner.groove_width,
        "lifters": liner.lifters,
        "face_angle_deg": math.degrees(liner.face_angle),
    }


def timing_document(balls: int, steps: int) -> dict[str, Any]:
    """Return the content of a timing.json."""
    return {
        "schema": 1,
        "stage": "rotate",
        "hardware": {"cpu": "A made-up CPU", "cores": 2, "available_cores": 2},
        "ranks": 2 if balls > 1 else 1,
        "balls": balls,
        "steps": steps,
        "particle_steps": balls * steps,
        "wall_time_s": 12.5,
        "loop_time_s": 12.0,
        "particle_steps_per_s_core": balls * steps / 12.0,
        "share": {"pair": 0.6, "output": 0.02},
    }


def write_case(runs: Path, case: dict[str, Any], columns: dict[str, np.ndarray]) -> Path:
    """Write a case folder whose engine stage is done."""
    folder = runs / "cases" / case["id"]
    folder.mkdir(parents=True)
    (folder / "case.json").write_text(json.dumps(case))
    write_series(folder / "series.csv", columns)
    timing = timing_document(case["ball"]["count"], int(columns["step"][-1]))
    (folder / "timing.json").write_text(json.dumps(timing))
    return folder


def finish_case(folder: Path) -> dict[str, Any]:
    """Analyse a case folder and record its products, as the stages do.

    Returns:
        The content of result.json.
    """
    result = analyse_case(folder)
    write_json(folder / "result.json", result)
    record_stages(folder)
    return result


def record_stages(folder: Path) -> None:
    """Write provenance.json of a finished case; missing products count as removed later."""
    case = json.loads((folder / "case.json").read_text())

    def digest(name: str) -> str:
        return digest_of(folder / name) if (folder / name).exists() else "removed"

    write_provenance(
        folder,
        {
            stage.name: {
                "case": case_digest(case),
                "inputs": {name: digest(name) for name in stage.inputs},
                "products": {name: digest(name) for name in stage.products},
            }
            for stage in STAGES[case["kind"]]
        },
    )


def write_series(path: Path, columns: dict[str, np.ndarray]) -> None:
    """Write series.csv with ten digits, as the engine prints."""
    np.savetxt(
        path,
        np.column_stack(list(columns.values())),
        delimiter=",",
        header=",".join(columns),
        comments="",
        fmt="%.10g",
    )


def write_campaign(runs: Path, ids: list[str]) -> None:
    """Write campaign.json."""
    content = {"schema": 1, "name": "synthetic", "about": "closed forms", "cases": ids}
    (runs / "campaign.json").write_text(json.dumps(content))
