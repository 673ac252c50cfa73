"""The hard cases, each as its changes of the mill of campaigns/hard-cases.toml."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from millscale import _core
from millscale.campaign.build import load_campaign
from millscale.campaign.campaign import Campaign, LinerShape
from millscale.cases.time_step import COORDINATION

MILL, IMPACT, REST = "mill", "impact", "rest"
BASE_S = 8.0


@dataclass(frozen=True)
class Case:
    """One hard case.

    Attributes:
        name: of the row.
        kind: MILL, a charge in the rotating mill; IMPACT, one collision; REST, a bed at rest.
        scene: initial state of the balls, a function of `scenes`.
        S, froude, filling, thickness: of the mill; thickness of the slice in ball diameters.
        restitution, friction: of all contacts; None for those of the campaign.
        softer: factor on Young's modulus.
        smallest: smallest over largest radius, if there are two sizes.
        duration: simulated time [s].
        steps: number of steps, instead of `duration`.
        only: fractions of the Rayleigh time; empty for all of LADDER, and the unstable step.
    """

    name: str
    kind: str = MILL
    scene: str = "heap"
    S: float = BASE_S
    froude: float = 0.4
    filling: float = 0.30
    thickness: float = 1.5
    restitution: float | None = None
    friction: float | None = None
    softer: float = 1.0
    smallest: float = 1.0
    duration: float = 0.4
    steps: int | None = None
    only: tuple[float, ...] = field(default=())


CASES = (
    Case("the mill itself"),
    Case("Fr 0.1, slipping and cascading", froude=0.1),
    Case("Fr 0.9", froude=0.9),
    Case("Fr 1.5, centrifuging", froude=1.5),
    # The engine refuses 0.05 itself.
    Case("e = 0.051", restitution=0.051),
    Case("e = 0.99", restitution=0.99),
    Case("mu = 0", friction=0.0),
    Case("mu = 1", friction=1.0),
    Case("E ten times softer", softer=0.1),
    Case("E a hundred times stiffer", softer=100.0, duration=0.1, filling=0.15),
    Case("balls of 20 and 4 mm", smallest=0.2, duration=0.1, filling=0.10),
    Case("45 % full", filling=0.45),
    Case("S = 1", S=1.0, filling=0.02, thickness=1.05, duration=0.2),
    Case("S = 10", S=10.0),
    Case("a slice one ball thick", thickness=1.05),
    Case("5 m/s onto a lifter's edge", IMPACT, "edge", duration=0.01),
    Case("5 m/s into the corner of lifter and liner", IMPACT, "corner", duration=0.01),
    Case("a ball in that corner, hit at 5 m/s", IMPACT, "wedge", duration=0.02),
    Case("10 m/s into a packed bed", IMPACT, "bed", duration=0.35, filling=0.15),
    Case("balls that begin 0.1 radii deep", IMPACT, "overlapping", duration=0.02, thickness=1.9),
    Case("a bed at rest", REST, filling=0.05, duration=2.0, only=(0.1, 0.2, 0.4)),
    Case("a bed at rest, 1e6 steps", REST, filling=0.02, steps=1_000_000, only=(0.137,)),
)


@dataclass(frozen=True)
class Mill:
    """Mill and balls of a case, SI units."""

    radius: float
    lifters: int
    lifter_top_radius: float
    lifter_top_width: float
    groove_width: float
    omega: float
    gravity: float
    length: float
    radii: tuple[float, ...]  # largest first
    density: float
    youngs_modulus: float
    poisson_ratio: float
    restitution: tuple[float, float]  # ball-ball, ball-wall
    friction: tuple[float, float]
    rolling: tuple[float, float]

    @property
    def liner(self) -> _core.Profile:
        shape = self.lifter_top_radius, self.lifter_top_width, self.groove_width, self.lifters
        return _core.Lifters(self.radius, *shape)

    @property
    def rayleigh_time(self) -> float:
        """Rayleigh time of the smallest ball [s]."""
        return _core.rayleigh_time(self._material(), self.radii[-1])

    def damping_limit(self, bounded: bool) -> float:
        """Largest linearly stable step in a bed as deep as the mill's radius [s].

        Args:
            bounded: whether the tangential damping of balls is bounded.
        """
        material = self._material()
        overlap = self.radii[-1] * _core.bed_overlap(material, self.gravity, self.radius)
        return _core.damping_time_step_limit(
            material,
            self.radii[-1],
            min(self.restitution),
            overlap,
            COORDINATION["multi-ball"],
            bounded,
        )

    def _material(self) -> _core.Material:
        return _core.Material(self.youngs_modulus, self.poisson_ratio, self.density)


def base_campaign() -> Campaign:
    """Return campaigns/hard-cases.toml, of the installation or of the sources."""
    name, here = "hard-cases.toml", Path(__file__)
    installed = here.parent / name
    return load_campaign(installed if installed.is_file() else here.parents[3] / "campaigns" / name)


def mill_of(case: Case, base: Campaign) -> Mill:
    """Return the mill and balls of a case."""
    liner, ball, material = base.liner, base.ball, base.material
    radius, small = base.mill.radius / case.S, case.smallest * ball.radius
    # hard-cases.toml states these.
    assert isinstance(liner, LinerShape) and liner.groove_width is not None
    radii = (ball.radius,) if case.smallest == 1.0 else (ball.radius, small)

    def pair(value, *given):
        return given if value is None else (value, value)

    return Mill(
        radius,
        liner.lifters,
        liner.lifter_top_radius / case.S,
        liner.lifter_top_width / case.S,
        liner.groove_width / case.S,
        (case.froude * base.mill.gravity / radius) ** 0.5,
        base.mill.gravity,
        2.0 * ball.radius * case.thickness,
        radii,
        ball.density,
        material.youngs_modulus * case.softer,
        material.poisson_ratio,
        pair(case.restitution, material.restitution_pp, material.restitution_pw),
        pair(case.friction, material.static_friction_pp, material.static_friction_pw),
        (material.rolling_friction_pp, material.rolling_friction_pw),
    )
