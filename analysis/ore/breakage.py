"""Breakage of an ore in the physical mill, by the impacts of finished scaled mills.

No ore is simulated, so no run can verify these numbers. Impacts of a scaled mill become those of
the physical mill by the similarity law: energies as m (omega R)^2, impacts per second as N omega,
with the N balls of the whole mill, and those on the liner as the area of the liner times omega.
Models, sources and limits: docs/theory/breakage.md.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from millscale.analysis.charge.impacts import (
    NAMES,
    Collapse,
    collapses,
    energy_unit,
    rebinned,
    summed_bins,
)
from millscale.analysis.charge.physical_mill import balls_per_length, physical_mill
from millscale.analysis.charge.scaled_mills import ScaledMill, scaled_mills
from millscale.analysis.finished import Charge
from millscale.analysis.means import deviation, mean_known
from millscale.analysis.ore.file import ENERGIES, FEWEST_FITTED, OreFile
from millscale.analysis.result_file import PAIRINGS
from millscale.breakage import (
    JOULE_PER_KG,
    AustinSelection,
    Grinding,
    Spectrum,
    TavaresOre,
    broken_share,
    fit_austin,
    selection_rates,
    t10,
)
from millscale.formats import counted
from millscale.runs.case_file import Case
from millscale.runs.untrusted import RunFolderError

MINUTE = 60.0
# Of the JK drop-weight test (docs/theory/breakage.md).
TESTED_ENERGIES = (0.1, 2.5)  # kWh/t
TESTED_SIZES = (13e-3, 63e-3)  # m
# Decades of the energy of an impact of the physical mill, powers of ten [J].
DECADES = (-15, 6)
# Shares below it are warned of.
ALIKE = 0.5
SAME_S = 1e-6
POST_PROCESSING = (
    "Post-processing: the simulation has balls and no ore, so it cannot verify these numbers. "
    "Balls strike one another with nothing between them; ore would damp impacts and share them."
)


@dataclass(frozen=True)
class SizeRow:
    """What impacts do to particles of one size. Numbers are means over the seeds.

    Attributes:
        size: [m].
        specific_energy: mean energy of an impact over the mass of a particle, each impact weighted
            by its energy [kWh/t].
        tested_share: of the energy, in impacts within TESTED_ENERGIES.
        t10: of the JK drop-weight test, impacts weighted by energy [%]; None without A and b.
        breaking_share: of the energy, in impacts weighted by their probability to break.
        fragments_t10: mean t10 of the particles that break, by Tavares [%].
        rate: selection function, of particles without damage [1/s].
        rate_deviation: standard deviation over the seeds; None of one seed.
        broken_share: of the particles, within a minute, damage included.
        austin: selection function of the batch test that the ore file states [1/s].
    """

    size: float
    specific_energy: float | None
    tested_share: float | None
    t10: float | None
    breaking_share: float | None
    fragments_t10: float | None
    rate: float | None
    rate_deviation: float | None
    broken_share: float | None
    austin: float | None


@dataclass(frozen=True)
class DecadeRow:
    """Impacts of the physical mill of one decade of energy.

    Attributes:
        low: lower edge [J].
        impacts: per second.
        power: [W].
        rate_shares: of the selection function of each size; empty without Tavares' model.
    """

    low: float
    impacts: float
    power: float
    rate_shares: tuple[float, ...]


@dataclass(frozen=True)
class Fit:
    """Austin's function nearest to the rates of all sizes, per minute.

    Attributes:
        error: root mean square of the logarithm of the ratio.
    """

    selection: AustinSelection
    error: float


@dataclass(frozen=True)
class MillBreakage:
    """Breakage in the physical mill by one scaled mill.

    Attributes:
        energy_factor, rate_factor: physical over simulated, of an impact's energy and of impacts
            of balls on balls per second.
        power: of the chosen energy in all impacts, by pairing, physical mill [W].
        other_power: of the energy that was not chosen [W].
        drive_power: of the physical mill [W].
        specific_power: that the ore takes [W/kg].
        fit: None of too few sizes with a rate.
    """

    id: str
    scheme: str
    policy: str
    S: float
    seeds: int
    energy_factor: float
    rate_factor: float
    impacts: float
    power: dict[str, float]
    other_power: float
    drive_power: float
    specific_power: float
    sizes: tuple[SizeRow, ...]
    decades: tuple[DecadeRow, ...]
    fit: Fit | None


@dataclass(frozen=True)
class Breakage:
    """Breakage by all scaled mills of a runs folder, the smallest S first.

    Attributes:
        collapses: spectra of the chosen energy beside those of the smallest S.
        warnings: in words.
    """

    ore: OreFile
    mills: tuple[MillBreakage, ...]
    collapses: tuple[Collapse, ...]
    warnings: tuple[str, ...]

    def document(self) -> dict[str, Any]:
        """Return the result as a JSON object, SI units unless a key names another."""
        return {
            "about": POST_PROCESSING,
            "ore": self.ore.document(),
            "mills": [asdict(mill) for mill in self.mills],
            "warnings": list(self.warnings),
        }


def back_scaling(case: Case) -> tuple[float, float]:
    """Return energy of an impact and impacts per second, physical over simulated.

    Both mills have the same balls, so energies scale as (omega R)^2. The simulated slice is a part
    of the length, so impacts of balls on balls scale as N omega. Those on the liner scale as its
    area times omega, 1 / S of that: the scaled mill has S times as much liner for each ball.
    """
    mill = physical_mill(case, balls_per_length(case))
    energy = case.ball.mass_kg * (mill.omega * mill.radius) ** 2 / energy_unit(case)
    rate = mill.balls * mill.omega / (case.ball.count * case.mill.omega_rad_s)
    return energy, rate


def physical_spectrum(charge: Charge, energy: str, pairing: str | None = None) -> Spectrum:
    """Return the spectrum of the physical mill by a charge that recorded its impacts.

    Args:
        energy: of `file.ENERGIES`.
        pairing: of PAIRINGS; None: all.
    """
    result = charge.result.impacts
    assert result is not None
    bins = summed_bins(result, pairing, energy, charge.S)
    if not bins.contacts_per_s:
        nothing = np.zeros(1)
        return Spectrum(result.energy_unit_J * np.array([1.0, 10.0]), nothing, nothing)
    # The first bin has the contacts that gained energy by round-off, too.
    power = np.maximum(bins.power_W, 0.0)
    columns = (bins.energy_low_J, bins.energy_high_J, bins.contacts_per_s, power)
    return Spectrum.of_bins(*map(np.array, columns)).scaled(*back_scaling(charge.case))


def breakage_of(charges: Sequence[Charge], ore: OreFile, where: Path) -> Breakage:
    """Return the breakage of an ore by the charges that recorded their impacts.

    Raises:
        RunFolderError: none did.
    """
    kept = [charge for charge in charges if charge.result.impacts is not None]
    if not kept:
        remedy = "set impacts = true in [multi_ball] and run: millscale run FILE --runs DIR"
        raise RunFolderError(where, "no finished case has spectra of its impacts", remedy)
    mills = tuple(
        _mill(mill, ore)
        for mill in sorted(scaled_mills(kept), key=lambda x: (x.first.S, x.first.id))
    )
    compared = collapses(kept, ore.energy)
    return Breakage(ore, mills, compared, tuple(_warnings(kept, ore, mills, compared)))


def _mill(mill: ScaledMill, ore: OreFile) -> MillBreakage:
    charges, case = mill.seeds, mill.first.case
    spectra = [physical_spectrum(charge, ore.energy) for charge in charges]
    sizes = tuple(_size(size, spectra, ore) for size in ore.sizes)
    other = next(name for name in ENERGIES if name != ore.energy)
    physical = physical_mill(case, balls_per_length(case))
    drive = np.mean([charge.result.dimensionless["power"] for charge in charges])
    power = {
        pairing: _mean(physical_spectrum(x, ore.energy, pairing).power for x in charges)
        for pairing in PAIRINGS
    }
    energy_factor, rate_factor = back_scaling(case)
    return MillBreakage(
        id=mill.first.id,
        scheme=mill.first.scheme,
        policy=mill.first.variant,
        S=mill.first.S,
        seeds=len(charges),
        energy_factor=energy_factor,
        rate_factor=rate_factor,
        impacts=_mean(x.rate for x in spectra),
        power=power,
        other_power=_mean(physical_spectrum(x, other).power for x in charges),
        drive_power=physical.power_scale * float(drive),
        specific_power=ore.nip.energy_share * sum(power.values()) / ore.hold_up,
        sizes=sizes,
        decades=_decades(spectra, ore),
        fit=_fit(sizes),
    )


def _mean(values: Iterable[float]) -> float:
    return float(np.mean(list(values)))


def ground(spectrum: Spectrum, ore: OreFile, tavares: TavaresOre) -> Grinding:
    """Return an ore file's ore in a mill."""
    return Grinding(spectrum, tavares, ore.hold_up, ore.nip)


def _size(size: float, spectra: Sequence[Spectrum], ore: OreFile) -> SizeRow:
    found = [_of_seed(size, spectrum, ore) for spectrum in spectra]
    rates = [x.rate for x in found if x.rate is not None]
    return SizeRow(
        size=size,
        **{
            name: mean_known([getattr(x, name) for x in found])
            for name in (
                *("specific_energy", "tested_share", "t10", "breaking_share", "fragments_t10"),
                *("rate", "broken_share"),
            )
        },
        rate_deviation=deviation(rates),
        austin=None if ore.austin is None else float(ore.austin.at(np.array(size))) / MINUTE,
    )


@dataclass(frozen=True)
class _OfSeed:
    """The numbers of a SizeRow by one packing; None without impacts or without the model."""

    specific_energy: float | None = None
    tested_share: float | None = None
    t10: float | None = None
    breaking_share: float | None = None
    fragments_t10: float | None = None
    rate: float | None = None
    broken_share: float | None = None


def _of_seed(size: float, spectrum: Spectrum, ore: OreFile) -> _OfSeed:
    mass = ore.density * math.pi / 6.0 * size**3
    taken = ore.nip.energy_share / (ore.nip.particles * mass) * spectrum.energies
    weights = spectrum.energies * spectrum.counts
    if not weights.sum() > 0.0:
        return _OfSeed()
    weights = weights / weights.sum()
    specific = taken / JOULE_PER_KG
    least, most = TESTED_ENERGIES
    jk = ore.drop_weight
    found = _OfSeed(
        specific_energy=float(weights @ specific),
        tested_share=float(weights[(specific >= least) & (specific <= most)].sum()),
        t10=None if jk is None else float(weights @ t10(specific, jk.A, jk.b)),
    )
    if ore.tavares is None:
        return found
    grinding = ground(spectrum, ore, ore.tavares)
    broken = ore.tavares.broken(taken, size)
    hits = grinding.impact_rates(size) * broken
    fineness = ore.tavares.t10(taken, size)
    return replace(
        found,
        breaking_share=float(weights @ broken),
        fragments_t10=float(hits @ fineness / hits.sum()) if hits.sum() > 0.0 else None,
        rate=float(selection_rates(grinding, np.array([size]))[0]),
        broken_share=broken_share(grinding, size, MINUTE),
    )


def _decades(spectra: Sequence[Spectrum], ore: OreFile) -> tuple[DecadeRow, ...]:
    """Return the impacts by decade of energy [J], means over the seeds."""
    columns = []
    for spectrum in spectra:
        edges = spectrum.edges[:-1], spectrum.edges[1:]
        values = [spectrum.counts, spectrum.counts * spectrum.energies]
        if ore.tavares is not None:
            grinding = ground(spectrum, ore, ore.tavares)
            values += [
                grinding.impact_rates(size)
                * ore.tavares.broken(grinding.specific_energies(size), size)
                for size in ore.sizes
            ]
        columns.append([rebinned(*edges, x, 1.0, DECADES) for x in values])
    impacts, power, *rates = np.mean(columns, axis=0)
    shares = [x / x.sum() if x.sum() > 0.0 else np.zeros_like(x) for x in rates]
    return tuple(
        DecadeRow(
            10.0 ** (DECADES[0] + k),
            float(impacts[k]),
            float(power[k]),
            tuple(float(x[k]) for x in shares),
        )
        for k in np.flatnonzero(impacts > 0.0).tolist()
    )


def _fit(sizes: Sequence[SizeRow]) -> Fit | None:
    known = [(row.size, row.rate) for row in sizes if row.rate]
    if len(known) < FEWEST_FITTED:
        return None
    of_size, rate = np.array(known).T
    return Fit(*fit_austin(of_size, MINUTE * rate))


def _warnings(
    charges: Sequence[Charge],
    ore: OreFile,
    mills: Sequence[MillBreakage],
    compared: Sequence[Collapse],
) -> Iterator[str]:
    smallest = mills[0].S
    if smallest > 1.0 + SAME_S and len({mill.S for mill in mills}) == 1:
        yield (
            f"only S = {smallest:.4g} has spectra: nothing tests which part of them the physical "
            "mill has; a second S beside it does"
        )
    for one in compared:
        if one.alike_share < ALIKE:
            yield (
                f"{one.id}, {NAMES[one.pairing]}: {100.0 * one.alike_share:.0f} % of the energy "
                f"of S = {one.reference_S:.4g} is in decades that agree with it; the section "
                "Impacts of the report has each decade"
            )
    ball = charges[0].case.physical.ball_radius_m * 2.0
    if ore.sizes[-1] >= ball:
        yield (
            f"particles of {1e3 * ore.sizes[-1]:.3g} mm are as large as the balls, "
            f"{1e3 * ball:.3g} mm: balls do not catch them"
        )
    if ore.tavares is not None and (unusual := ore.tavares.unusual()):
        yield f"outside of the ranges of published ores: {'; '.join(unusual)}"
    if ore.drop_weight is not None:
        yield from _outside_test(mills[0].sizes)


def _outside_test(sizes: Sequence[SizeRow]) -> Iterator[str]:
    least, most = TESTED_SIZES
    small = [x.size for x in sizes if not least <= x.size <= most]
    if small:
        yield (
            f"A and b are of particles of {1e3 * least:g} to {1e3 * most:g} mm: "
            f"{counted(len(small), 'size')} outside, and smaller particles are stronger"
        )
    within = min((x.tested_share for x in sizes if x.tested_share is not None), default=1.0)
    if within < ALIKE:
        yield (
            f"A and b are of {TESTED_ENERGIES[0]:g} to {TESTED_ENERGIES[1]:g} kWh/t: of one size "
            f"only {100.0 * within:.0f} % of the energy is in such impacts"
        )
