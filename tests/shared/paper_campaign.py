"""A small valid campaign on the paper's mill, and changes of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.runs.case_file import Case

REPOSITORY = Path(__file__).parents[2]
PAPER = REPOSITORY / "analysis" / "paper" / "tables"
CAMPAIGNS = REPOSITORY / "campaigns"

BASE: dict[str, dict[str, Any]] = {
    "mill": {"radius_m": 3.9, "length_m": 1.0, "gravity_m_s2": 9.81, "speed_rad_s": 1.0},
    "liner": {
        "lifters": 25,
        "lifter_top_radius_m": 3.61,
        "lifter_top_width_m": 0.25,
        "groove_width_m": 0.635,
    },
    "ball": {"radius_m": 0.02, "density_kg_m3": 2678.0},
    "material": {
        "shear_modulus_pa": 2.3e7,
        "poisson_ratio": 0.3,
        "restitution_pp": 0.1,
        "restitution_pw": 0.2,
        "static_friction_pp": 0.545,
        "static_friction_pw": 0.5,
        "rolling_friction_pp": 0.01,
        "rolling_friction_pw": 0.01,
    },
    "scaling": {"S": [1.0, 2.6]},
    "single_ball": {"rotation_angle_rad": 6.0, "step_s": 5e-5},
}
MULTI_BALL = {"multi_ball": {"count": [100, 10], "rotation_angle_rad": 1.0, "step_s": 1e-4}}


def campaign_text(**changes: Any) -> str:
    """TOML of BASE with changes `section__key=value`; None takes a key, or a section, away."""
    sections = {name: dict(content) for name, content in BASE.items()}
    for path, value in changes.items():
        name, _, key = path.partition("__")
        if key:
            sections.setdefault(name, {})[key] = value
        elif value is None:
            del sections[name]
        else:
            sections[name] = dict(value)  # a further change is not of the given one
    if "multi_ball" in sections:
        # Rotations of tests are short, and a mill that starts slowly needs more steps for them.
        sections["multi_ball"] = {"ramp_turns": 0} | sections["multi_ball"]
    lines = []
    for name, content in sections.items():
        lines.append(f"[{name}]")
        given = {key: value for key, value in content.items() if value is not None}
        lines += [f"{key} = {json.dumps(value)}" for key, value in given.items()]
    return "\n".join(lines) + "\n"


def cases(folder: Path, **changes: Any) -> list[Case]:
    """The cases of a changed campaign."""
    return cases_of(load_campaign(write_campaign(folder, **changes)))


def write_campaign(folder: Path, **changes: Any) -> Path:
    """The same as a file."""
    path = folder / "campaign.toml"
    path.write_text(campaign_text(**changes))
    return path
