"""Checks a case.json before anything is made of it: it may be damaged, or made to do harm.

Words go into decks, which can run programs, so they are plain words; numbers are finite; counts
have bounds.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from millscale.errors import CampaignError
from millscale.runs.untrusted import RunFolderError, read_object

LARGEST_FILE_BYTES = 1 << 20
KINDS = ("single-ball", "multi-ball")
# As `case_id` makes them; also the name of the case's folder.
CASE_ID = re.compile(r"(sb|mb)-[a-z]{2}-[a-z-]{1,20}-S[0-9]{1,9}\.[0-9]{3}(-seed[0-9]{1,10})?")
DIGEST = re.compile(r"[0-9a-f]{64}")
# A word of a deck: `liner.stl`, `history`, `constant-gravity`.
DECK_WORD = re.compile(r"[a-z][a-z0-9_-]{0,40}(\.[a-z]{1,8})?")
MOST_BALLS, MOST_STEPS, MOST_RANKS = 10**9, 10**15, 10**5
_DEEPEST = 8
_REMEDY = "as generated: millscale generate FILE --runs DIR writes it anew"
_COUNTS = {
    "count": MOST_BALLS,
    "lifters": 10**4,
    "axial_divisions": 10**4,
    "triangles": 10**9,
    "seed": 10**9,
}
_AT_LEAST_ONE = {
    *("count", "steps", "axial_divisions"),
    *("thermo_steps", "sample_steps", "dump_steps", "restart_steps"),
}
# What the stages, the status and the plan read.
_NUMBERS = {
    "": ("S", "time_factor", "seed"),
    "physical": ("radius_m", "gravity_m_s2", "omega_rad_s"),
    "mill": (
        *("radius_m", "length_m", "simulated_length_m", "lifter_top_radius_m"),
        *("lifter_top_width_m", "groove_width_m", "phase_rad", "lifters"),
    ),
    "ball": ("radius_m", "density_kg_m3", "radius_std_m", "truncation", "count", "mass_kg"),
    "material": (
        *("youngs_modulus_pa", "poisson_ratio", "restitution_pp", "restitution_pw"),
        *("static_friction_pp", "static_friction_pw", "rolling_friction_pp"),
        "rolling_friction_pw",
    ),
    "time": (
        *("step_s", "start_s", "rest_steps", "settle_steps", "rotation_steps", "steps"),
        "rotation_angle_rad",
    ),
    "wall": ("chord_error_m", "axial_divisions", "triangles"),
    "domain": ("half_box_m", "skin_m"),
    "output": ("thermo_steps", "sample_steps", "dump_steps", "restart_steps"),
}
_WORDS = {
    "": ("scheme", "policy"),
    "wall": ("kind",),
    "deck": ("pair", "dumps", "surface"),
}


def read_case(path: Path) -> dict[str, Any]:
    """Content of a case.json that names a known kind and a plain id; no more is checked.

    Raises:
        CampaignError: cannot be read, or is no such document.
    """
    try:
        document = read_object(path, "", LARGEST_FILE_BYTES)
    except RunFolderError as error:
        raise CampaignError(path, "", error.cause, f"a case.json {_REMEDY}") from None
    if document.get("kind") not in KINDS:
        raise CampaignError(path, "kind", f"got {_shown(document.get('kind'))}", " or ".join(KINDS))
    return document


def check_case(path: Path, document: Mapping[str, Any]) -> None:
    """Refuse a case.json with which the stages could not work.

    Raises:
        CampaignError: names the first key that is not accepted.
    """
    case_id = document.get("id")
    if not isinstance(case_id, str) or not CASE_ID.fullmatch(case_id):
        raise CampaignError(path, "id", f"got {_shown(case_id)}", "such as sb-cg-paper-S1.000")
    digest = document.get("digest")
    if not isinstance(digest, str) or not DIGEST.fullmatch(digest):
        raise CampaignError(path, "digest", f"got {_shown(digest)}", f"a SHA-256; {_REMEDY}")
    for key, value in _leaves(path, document):
        _check_leaf(path, key, value)
    if not isinstance(document.get("allow_centrifuging"), bool):
        raise CampaignError(path, "allow_centrifuging", "no such flag", f"true or false; {_REMEDY}")
    meshed = _part(path, document, "wall").get("kind") == "mesh"
    for section, names in _NUMBERS.items():
        for name in (*names, "curvature_deg") if meshed and section == "wall" else names:
            value = _part(path, document, section).get(name)
            if not _is_number(value):
                key = f"{section}.{name}".lstrip(".")
                raise CampaignError(path, key, f"got {_shown(value)}", f"a number; {_REMEDY}")
    for section, names in _WORDS.items():
        for name in names:
            check_word(
                path, f"{section}.{name}".lstrip("."), _part(path, document, section).get(name)
            )


def check_word(path: Path | str, key: str, value: Any) -> None:
    """Refuse what is no plain word."""
    if not isinstance(value, str) or not DECK_WORD.fullmatch(value):
        raise CampaignError(path, key, f"got {_shown(value)}", f"a plain word; {_REMEDY}")


def _part(path: Path, document: Mapping[str, Any], section: str) -> Mapping[str, Any]:
    part = document.get(section) if section else document
    if not isinstance(part, Mapping):
        raise CampaignError(path, section, f"got {_shown(part)}", f"a section; {_REMEDY}")
    return part


def _leaves(path: Path, value: Any, key: str = "", depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Every value that holds no others, with its path."""
    if depth > _DEEPEST:
        raise CampaignError(path, key, "nested too deep", _REMEDY)
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _leaves(path, inner, f"{key}.{name}"[-80:].lstrip("."), depth + 1)
    elif isinstance(value, list):
        for inner in value:
            yield from _leaves(path, inner, key, depth + 1)
    else:
        yield key, value


def _check_leaf(path: Path, key: str, value: Any) -> None:
    if isinstance(value, bool | str) or value is None:
        return
    if not _is_number(value):
        raise CampaignError(path, key, f"got {_shown(value)}", f"a finite number; {_REMEDY}")
    name = key.rpartition(".")[2]
    most = MOST_STEPS if name.endswith("_steps") or name == "steps" else _COUNTS.get(name)
    least = 1 if name in _AT_LEAST_ONE else 0
    if most is not None and not (isinstance(value, int) and least <= value <= most):
        accepted = f"a whole number from {least} to {most}; {_REMEDY}"
        raise CampaignError(path, key, f"got {_shown(value)}", accepted)


def _is_number(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) < 10**300 and math.isfinite(value)


def _shown(value: Any) -> str:
    if isinstance(value, int) and value.bit_length() > 200:
        return f"a number of {value.bit_length()} bits"
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
