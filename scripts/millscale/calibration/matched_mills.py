"""`millscale calibrate`: the friction exponent of a mill, from two of its scaled mills.

The scaled mill of S_near stands for the physical mill of a campaign of its own. There the mill of
S_far has S = S_far / S_near: policy `paper` is k = 0, and `friction-matched` any other k.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from rich.console import Console

from millscale.analysis.charge.measured import measure
from millscale.analysis.finished import Charge
from millscale.analysis.shapes.comparison import curve_distances
from millscale.calibration.friction_exponent import (
    LARGEST_EXPONENT,
    Match,
    exponent_of,
    largest_chance,
    match,
)
from millscale.campaign.build import campaign_of
from millscale.campaign.keys import ADVISED, FRICTION_MATCHED
from millscale.campaign.reader import campaign_tree
from millscale.campaign.writer import Tree, toml_text
from millscale.cases.case import cases_of
from millscale.engine.machine import CoreWish
from millscale.engine.record import provenance
from millscale.errors import CampaignError, PredictionError
from millscale.formats import duration
from millscale.prediction.contour import mean_contour
from millscale.prediction.extrapolation import Group
from millscale.prediction.noise import noise_of
from millscale.prediction.selection import usable_charges
from millscale.runs.case_file import Case
from millscale.runs.lock import hold
from millscale.runs.untrusted import RunFolderError
from millscale.runs.writing import write_json, write_text
from millscale.workflow.placement import campaign_time
from millscale.workflow.run_command import check_free_disk, request, run_campaign

SCHEMA = 1
RESULT = "calibration.json"
CAMPAIGN = "calibration.toml"
# Runs after those of both ends of the range that look for the exponent.
MOST_SEARCHES = 3
# x of the centre of mass over R: the torque of the drive over M g R is its negative.
MATCHED = "centre_x"
SHOWN = (MATCHED, "centre_z", "kinetic", "toe_angle_rad", "solid_fraction", "flying_share")


@dataclass(frozen=True)
class Mills:
    """The two scaled mills of a campaign file.

    Attributes:
        near: S of the reference.
        far: S of the mill whose friction is matched to it.
        tree: content of the campaign in which the reference is the physical mill, without the
            keys of `campaign_text`.
    """

    file: Path
    near: float
    far: float
    scheme: str
    tree: Tree
    counts: tuple[int, int] | None

    @property
    def ratio(self) -> float:
        return self.far / self.near

    def campaign_text(self, exponents: Sequence[float]) -> str:
        """Return a campaign file of the reference with k = 0 and another, or of one k alone."""
        begins = 0.0 in exponents
        tree = deepcopy(self.tree)
        shown = ", ".join(f"{k:g}" for k in exponents)
        tree["campaign"] = {
            "name": "calibration",
            "about": f"S = {self.far:g} at friction exponents {shown}, against S = {self.near:g}",
        }
        tree["scaling"] |= {
            "S": [1.0, self.ratio] if begins else [self.ratio],
            "policies": ["paper", FRICTION_MATCHED] if begins else [FRICTION_MATCHED],
            "friction_exponent": exponents[-1],
        }
        if self.counts:
            tree["multi_ball"]["count"] = list(self.counts if begins else self.counts[1:])
        return toml_text(tree)


@dataclass(frozen=True)
class Observable:
    """A measured number of the reference, and by k of the other mill; None if not measured.

    Attributes:
        chance: largest difference that the noise makes; None if the noise is not known.
    """

    name: str
    reference: float | None
    tried: Mapping[float, float | None]
    chance: float | None

    @property
    def exponent(self) -> float | None:
        """Return the exponent at which it is that of the reference; None if there is none."""
        if self.reference is None:
            return None
        known = {k: value for k, value in self.tried.items() if value is not None}
        return exponent_of({k: value - self.reference for k, value in known.items()})

    def is_worse_at(self, exponent: float) -> bool:
        """Return whether it lies farther from the reference than at k = 0, and than by chance."""
        matched, unmatched = self.tried[exponent], self.tried[0.0]
        if matched is None or unmatched is None or self.reference is None:
            return False
        least = max(abs(unmatched - self.reference), self.chance or 0.0)
        return abs(matched - self.reference) > least


@dataclass(frozen=True)
class MatchedFriction:
    """The friction exponent of a mill.

    Attributes:
        noise_from: "seeds", or "lifter pitches" of single runs.
        contours: mean distance of the contour from the reference's by k, over R - a.
        excluded: charges that are not used, and why.
    """

    near: float
    far: float
    scheme: str
    match: Match
    noise_from: str
    observables: tuple[Observable, ...]
    contours: Mapping[float, float]
    excluded: Mapping[str, str]

    @property
    def exponent(self) -> float:
        """Return the exponent as it is written into a campaign file."""
        return round(self.match.exponent, 2)

    @property
    def confirmed_at(self) -> float:
        """Return the exponent of the run that confirms it."""
        return min(self.match.differences, key=lambda k: abs(k - self.match.exponent))

    def worse_at(self, exponent: float) -> list[str]:
        """Return the observables that lie farther from the reference than at k = 0."""
        return [row.name for row in self.observables if row.is_worse_at(exponent)]

    def document(self) -> dict[str, Any]:
        """Return it as JSON types."""
        return {
            "schema": SCHEMA,
            "friction_exponent": self.exponent,
            "half_width": self.match.half_width,
            "reference_S": self.near,
            "S": self.far,
            "scheme": self.scheme,
            "noise_from": self.noise_from,
            "difference_of_minus_centre_x": _by_text(self.match.differences),
            "difference_by_chance": self.match.largest_chance,
            "observables": [
                asdict(row) | {"tried": _by_text(row.tried), "friction_exponent": row.exponent}
                for row in self.observables
            ],
            "contour_distance": _by_text(self.contours),
            "excluded": dict(self.excluded),
        }


@dataclass
class _Runs:
    """Steady charges of the reference and, by k, of the other mill, with their measured numbers.

    Attributes:
        excluded: charges that are not used, and why.
    """

    reference: list[Charge] = field(default_factory=list)
    tried: dict[float, list[Charge]] = field(default_factory=dict)
    numbers: dict[Charge, dict[str, float | None]] = field(default_factory=dict)
    excluded: dict[str, str] = field(default_factory=dict)

    def read(self, folder: Path, exponents: Sequence[float]) -> None:
        """Add the charges of a runs folder.

        Raises:
            PredictionError: no charge of the reference or of an exponent is steady.
        """
        charges, excluded = usable_charges([folder])
        self.excluded |= {f"{folder.name}/{name}": why for name, why in excluded.items()}
        for charge in charges:
            if charge.is_physical:
                self.reference.append(charge)
            elif charge.policy == FRICTION_MATCHED:
                self.tried.setdefault(charge.case.friction_exponent or 1.0, []).append(charge)
            else:
                self.tried.setdefault(0.0, []).append(charge)
        self.numbers |= measure(charges, []).numbers
        if not self.reference or any(k not in self.tried for k in exponents):
            reasons = ", ".join(f"{name}: {why}" for name, why in self.excluded.items())
            raise PredictionError(f"a mill has no steady charge ({reasons}): turn longer")

    def match(self) -> tuple[Match, str]:
        """Return the exponent, and what its noise was found from."""
        reference, tried = self._groups(MATCHED)
        noise, noise_from = noise_of(MATCHED, [reference, *tried.values()], self._charges)
        if noise is None:
            raise PredictionError("the noise of x_c is not known: turn longer, or add seeds")
        return match(_negative(reference), {k: _negative(x) for k, x in tried.items()}, noise), (
            noise_from
        )

    def observable(self, name: str) -> Observable:
        """Return a number by its name in `measures.NUMBERS`."""
        reference, tried = self._groups(name)
        if not reference.values or not all(group.values for group in tried.values()):
            return Observable(name, None, dict.fromkeys(tried), None)
        noise, _ = noise_of(name, [reference, *tried.values()], self._charges)
        chance = largest_chance(noise, reference, tried.values()) if noise else None
        values = {k: group.mean for k, group in tried.items()}
        return Observable(name, reference.mean, values, chance)

    def contours(self) -> dict[float, float]:
        """Return the mean distance of the contours from those of the reference, over R - a."""
        try:
            references = [mean_contour(charge) for charge in self.reference]
            lines = {k: [mean_contour(x) for x in self.tried[k]] for k in sorted(self.tried)}
        except RunFolderError:
            return {}
        return {
            k: _mean([curve_distances([x], [y])[0] for x in found for y in references])
            for k, found in lines.items()
        }

    @property
    def _charges(self) -> list[Charge]:
        return [*self.reference, *(x for charges in self.tried.values() for x in charges)]

    def _groups(self, name: str) -> tuple[Group, dict[float, Group]]:
        """Return a number of the reference, and of the other mill by k; only where measured."""

        def group(charges: Sequence[Charge]) -> Group:
            values = (self.numbers[charge][name] for charge in charges)
            return Group(charges[0].S, tuple(value for value in values if value is not None))

        return group(self.reference), {k: group(self.tried[k]) for k in sorted(self.tried)}


def mills_of(file: Path, near: float | None = None, far: float | None = None) -> Mills:
    """Return the scaled mills to calibrate a campaign with.

    Args:
        near, far: S of the reference and of the other mill; by default the smallest and the
            largest scaled mill of the campaign.

    Raises:
        CampaignError: the campaign has no charge, or not two such mills.
    """
    base = campaign_tree(file)
    base.pop("single_ball", None)
    if "multi_ball" not in base:
        raise CampaignError(file, "multi_ball", "missing", "a charge, [multi_ball]")
    first, (part,) = _charge(file, base), campaign_of(file, base).parts
    ratios = sorted(S for S in part.ratios if S > 1.0)
    near = near or next(iter(ratios), 1.0)
    far = far or next(reversed(ratios), 1.0)
    if not 1.0 <= near < far:
        cause = f"S = {far:g}, and {near:g} of the reference"
        accepted = "two scaled mills: --reference-S NEAR --S FAR, 1 <= NEAR < FAR"
        raise CampaignError(file, "scaling.S", cause, accepted)
    counts: tuple[int, int] | None = None
    if "count" in base["multi_ball"]:
        # N S^3 in the whole length of each mill is the same where all are filled alike.
        whole = first.ball.count * first.mill.length_m / first.mill.simulated_length_m
        counts = (round(whole * (first.S / near) ** 3), round(whole * (first.S / far) ** 3))
    reference = _at(base, near, first.scheme, counts[0] if counts else None)
    tree = _as_physical(reference, _charge(file, reference), part.wait)
    return Mills(file, near, far, first.scheme, tree, counts)


def _charge(file: Path, tree: Tree) -> Case:
    return cases_of(campaign_of(file, tree))[0]


def _at(base: Tree, S: float, scheme: str, count: int | None) -> Tree:
    """Return the campaign of one scaled mill of policy paper."""
    tree = deepcopy(base)
    scaling, part = tree.setdefault("scaling", {}), tree["multi_ball"]
    for section in (scaling, part):
        for key in ("S", "scaled_radius_m", "schemes", "policies", "friction_exponent"):
            section.pop(key, None)
    part.pop("seeds_from_S", None)
    scaling |= {"S": [S], "schemes": [scheme], "policies": ["paper"]}
    if count:
        part["count"] = [count]
    return tree


def _as_physical(tree: Tree, case: Case, settling: float) -> Tree:
    """Return the campaign in which a scaled mill is the physical mill.

    Args:
        tree: the campaign of that mill.
        case: the mill, every number of it resolved.
        settling: of the campaign's physical mill [s].
    """
    tree = deepcopy(tree)
    tree["mill"] = {
        "radius_m": case.mill.radius_m,
        "length_m": case.mill.length_m,
        "gravity_m_s2": case.mill.gravity_m_s2,
        "speed_rad_s": case.mill.omega_rad_s,
        "allow_centrifuging": case.allow_centrifuging,
        **{key: value for key, value in tree["mill"].items() if key.startswith("end")},
    }
    for section in ("liner", "wall"):
        for key in tree.get(section, {}):
            if key.endswith("_m"):
                tree[section][key] *= case.factors.length
    for key in ("shear_modulus_pa", "youngs_modulus_pa"):
        tree["material"].pop(key, None)
    tree["material"]["youngs_modulus_pa"] = case.material.youngs_modulus_pa
    part = tree["multi_ball"]
    part["settle_s"] = settling * case.factors.time
    if part.get("step_s", ADVISED) != ADVISED:
        part["step_s"] = case.time.step_s
    for key in ("revolutions", "rotation_s"):
        part.pop(key, None)
    part["rotation_angle_rad"] = case.time.rotation_angle_rad
    if "time_factor" in tree["scaling"]:
        # The same factor at every S: none between the two mills.
        tree["scaling"]["time_factor"] = 1.0
    return tree


def match_friction(
    mills: Mills, runs: Path, cores: CoreWish, ignore_disk: bool, console: Console
) -> MatchedFriction | None:
    """Run what is missing and return the friction exponent; None if a case failed.

    Raises:
        PredictionError: the exponent is not determined, out of range or not confirmed.
    """
    found = _Runs()
    exponents: tuple[float, ...] = (0.0, LARGEST_EXPONENT)
    with hold(runs):
        for _ in range(1 + MOST_SEARCHES):
            folder = runs / f"k{exponents[-1]:.2f}"
            if not _run(mills.campaign_text(exponents), folder, cores, ignore_disk, console):
                return None
            found.read(folder, exponents)
            matched, noise_from = found.match()
            if matched.next_exponent is None:
                result = MatchedFriction(
                    mills.near,
                    mills.far,
                    mills.scheme,
                    matched,
                    noise_from,
                    tuple(found.observable(name) for name in SHOWN),
                    found.contours(),
                    found.excluded,
                )
                write_json(runs / RESULT, provenance() | result.document())
                return result
            if matched.next_exponent in matched.differences:
                break
            exponents = (matched.next_exponent,)
    tried = ", ".join(f"{k:g}" for k in matched.differences)
    raise PredictionError(
        f"k = {matched.exponent:.2f} is not confirmed by the runs of k = {tried}: add seeds"
    )


def _run(text: str, folder: Path, cores: CoreWish, ignore_disk: bool, console: Console) -> bool:
    """Run a campaign in its folder; return whether all cases have results."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / CAMPAIGN
    write_text(file, text)
    asked = request(file, folder, [], cores)
    time = duration(campaign_time(asked.cases, asked.allocation, asked.rates))
    line = f"{folder.name}: {', '.join(case.id for case in asked.cases)}, about {time} in all"
    console.print(line, markup=False, highlight=False)
    if not ignore_disk:
        check_free_disk(asked)
    return run_campaign(asked, console)


def _negative(group: Group) -> Group:
    return Group(group.S, tuple(-value for value in group.values))


def _mean(values: Sequence[float]) -> float:
    return math.fsum(values) / len(values)


def _by_text(values: Mapping[float, float | None]) -> dict[str, float | None]:
    """Return values by k, k as text as JSON has it."""
    return {f"{k:g}": value for k, value in values.items()}
