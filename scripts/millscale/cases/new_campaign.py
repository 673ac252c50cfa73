"""A commented campaign file of a new mill, from ten numbers or fewer: `millscale new`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from millscale import _core
from millscale.campaign.build import campaign_of_text
from millscale.campaign.keys import SECTIONS
from millscale.campaign.reader import read_value
from millscale.campaign.spellings import spelling_of
from millscale.cases.case import cases_of
from millscale.cases.slips import USUAL_OVERLAP
from millscale.errors import CampaignError, Mistakes
from millscale.runs.case_file import Case
from millscale.runs.soft_balls import impact_overlap, modulus_for

# Fewer ball diameters across a mill, or in a groove, are no model of a charge.
LEAST_MILL, LEAST_GROOVE = 15.0, 1.5
LEAST_SCALE = 1.3
SLICE_DIAMETERS = 4.0


@dataclass(frozen=True)
class NewMill:
    """A mill in the units of its drawing; with `lifters` 0, the rest of the liner is not used."""

    diameter_m: float = 5.0
    length_m: float = 7.0
    percent_of_critical: float = 75.0
    filling_percent: float = 30.0
    ball_diameter_mm: float = 50.0
    density_kg_m3: float = 7800.0
    lifters: int = 32
    lifter_height_mm: float = 150.0
    lifter_width_mm: float = 100.0
    face_angle_deg: float = 15.0


def suggested(name: str, known: NewMill) -> float:
    """Return the usual value of a number of a mill, from those before it in `NewMill`."""
    diameter, ball = known.diameter_m, known.ball_diameter_mm
    usual: dict[str, float] = {
        # Tube mills are longer than wide, mills of the laboratory as long.
        "length_m": diameter if diameter < 2.0 else round(1.4 * diameter, 1),
        "ball_diameter_mm": min(125.0, max(5.0, 5.0 * round(2.0 * diameter))),
        # A common rule: two rows a foot of diameter; one in large mills, whose balls are larger.
        "lifters": max(8, 2 * round(diameter / (0.3048 if diameter < 8.0 else 0.6096))),
        "lifter_height_mm": min(3.0 * ball, round(60.0 * diameter)),
        "lifter_width_mm": min(2.0 * ball, round(60.0 * diameter)),
    }
    value: float = usual.get(name, getattr(NewMill(), name))
    return value


# Keys of the campaign file that bound the numbers.
_KEYS = {
    "diameter_m": ("mill", "diameter_m"),
    "length_m": ("mill", "length_m"),
    "percent_of_critical": ("mill", "percent_of_critical"),
    "filling_percent": ("multi_ball", "filling_percent"),
    "ball_diameter_mm": ("ball", "diameter_mm"),
    "density_kg_m3": ("ball", "density_kg_m3"),
    "lifters": ("liner", "lifters"),
    "lifter_height_mm": ("liner", "lifter_height_mm"),
    "lifter_width_mm": ("liner", "lifter_top_width_mm"),
    "face_angle_deg": ("liner", "face_angle_deg"),
}


def _check(path: Path, mill: NewMill) -> None:
    """Refuse numbers that no campaign file may have.

    Raises:
        CampaignError: holds each of them.
    """
    mistakes = Mistakes()
    for name, (section, word) in _KEYS.items():
        known = SECTIONS[section]
        spelling = spelling_of(word, known)
        with mistakes.collected():
            key = spelling.key if spelling else known[word]
            read_value(path, f"{section}.{word}", key, getattr(mill, name))
    mistakes.raise_all()


def checked_text(path: Path, mill: NewMill) -> tuple[str, list[Case]]:
    """Return the campaign file of a mill, and its cases.

    Raises:
        CampaignError: no such mill can be planned.
    """
    _check(path, mill)
    # The stiffness follows from the impacts of a first plan.
    soft = campaign_text(mill, 1e9)
    (first, *_) = cases_of(campaign_of_text(path, soft))
    modulus = float(f"{modulus_for(first, 0.99 * USUAL_OVERLAP):.2g}")
    text = campaign_text(mill, modulus)
    cases = cases_of(campaign_of_text(path, text))
    assert max(map(impact_overlap, cases)) <= 1.01 * USUAL_OVERLAP
    return text, cases


def scales(mill: NewMill) -> list[float]:
    """Return S of two scaled mills that hold balls and keep lifters above a ball diameter."""
    ball = 1e-3 * mill.ball_diameter_mm
    most = mill.diameter_m / (LEAST_MILL * ball)
    if mill.lifters:
        try:
            groove = _liner(mill).narrowest_width
        except ValueError as cause:
            raise CampaignError("millscale new", "", f"impossible liner: {cause}") from None
        most = min(most, groove / (LEAST_GROOVE * ball), mill.lifter_height_mm / 1e3 / ball)
    most = math.floor(10.0 * most) / 10.0
    return [round(math.sqrt(most), 1), most] if most >= LEAST_SCALE else [1.0]


def _liner(mill: NewMill) -> _core.Lifters:
    radius = 0.5 * mill.diameter_m
    return _core.Lifters.from_face_angle(
        radius,
        radius - 1e-3 * mill.lifter_height_mm,
        1e-3 * mill.lifter_width_mm,
        math.radians(mill.face_angle_deg),
        mill.lifters,
        0.0,
    )


def campaign_text(mill: NewMill, youngs_modulus_pa: float) -> str:
    """Return the campaign file of a mill as TOML with comments."""
    ratios = scales(mill)
    longest = mill.length_m / max(ratios) / (1e-3 * mill.ball_diameter_mm)
    return "\n".join(
        [
            "# A campaign of millscale: a physical mill, the scaled mills to make of it, and what",
            "# to simulate. Check it with `millscale plan`, then `millscale run`.",
            "# The end of a key is its unit. Others are converted: radius_mm, density_g_cm3.",
            "# All keys: docs/reference/campaign-file.md",
            "",
            "[mill]",
            _line(f"diameter_m = {mill.diameter_m:g}", "inside the liner, between the lifters"),
            f"length_m = {mill.length_m:g}",
            _line(f"percent_of_critical = {mill.percent_of_critical:g}", "or speed_rpm"),
            "",
            *_liner_lines(mill),
            "",
            "[ball]",
            f"diameter_mm = {mill.ball_diameter_mm:g}",
            f"density_kg_m3 = {mill.density_kg_m3:g}",
            "",
            _line("[material]", "pp: ball-ball, pw: ball-wall; usual values of steel"),
            "# Softer than steel, for longer steps: impacts overlap by a twentieth of a radius.",
            f"youngs_modulus_pa = {youngs_modulus_pa:.1e}",
            "poisson_ratio = 0.3",
            "restitution_pp = 0.5",
            "restitution_pw = 0.5",
            "static_friction_pp = 0.35",
            "static_friction_pw = 0.5",
            "rolling_friction_pp = 0.003",
            "rolling_friction_pw = 0.004",
            "",
            "[model]",
            _line('precision = "mixed"', "single precision where no error adds up"),
            "",
            "[scaling]",
            _line(
                f"S = [{', '.join(f'{S:g}' for S in ratios)}]", "physical radius / scaled radius"
            ),
            'schemes = ["constant-gravity"]',
            "",
            "[multi_ball]",
            _line(f"filling_percent = {mill.filling_percent:g}", "bed with its voids"),
            *([_line(f"slice_diameters = {SLICE_DIAMETERS:g}", "simulated length, in balls")]
              if longest > SLICE_DIAMETERS else []),
            _line("revolutions = 4", "steady after about one; fewer leave too much chance"),
            "",
        ]
    )  # fmt: skip


def _liner_lines(mill: NewMill) -> list[str]:
    if not mill.lifters:
        return ["# No [liner]: a plain drum."]
    return [
        _line("[liner]", "equal trapezoids"),
        f"lifters = {mill.lifters}",
        f"lifter_height_mm = {mill.lifter_height_mm:g}",
        f"lifter_top_width_mm = {mill.lifter_width_mm:g}",
        _line(f"face_angle_deg = {mill.face_angle_deg:g}", "from the lifter's centre line"),
    ]


def _line(text: str, comment: str) -> str:
    return f"{text:<28}# {comment}"
