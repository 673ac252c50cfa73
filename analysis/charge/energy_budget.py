"""Energy budget of a charge: ledger.csv over one revolution, impacts.csv per revolution."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from millscale.analysis.result_file import (
    PAIRINGS,
    EnergyBudget,
    ImpactSpectrum,
    PairingBudget,
)
from millscale.runs.series import Series, read_series
from millscale.runs.untrusted import MOST_SERIES, RunFolderError, read_text

LEDGER, IMPACTS = "ledger.csv", "impacts.csv"
CHARGE = ("kinetic_translation_J", "kinetic_rotation_J", "potential_J")
ELASTIC = ("elastic_normal_J", "elastic_tangential_J")
DISSIPATED = ("dissipated_normal_J", "dissipated_tangential_J", "dissipated_rolling_J")
_REMEDY = "run the case again: millscale run FILE --runs DIR --only ID"
_IMPACT_COLUMNS = (
    *("mill_angle_from_rad", "mill_angle_to_rad", "pairing"),
    *("energy_low_J", "energy_high_J", "impacts", "energy_J"),
)


def energy_budget(ledger: Series) -> EnergyBudget:
    """Return what became of the mill's work in the last revolution, or in all of a shorter
    rotation; without impacts.

    Every column of ledger.csv is a sum since its begin, so each term is a difference of two rows.
    `closure` is the residual over the work of the mill:
    (W - kinetic - potential - elastic - dissipated) / W. The residual contains the error of the
    time steps in the normal springs, `spring_error_J`, which is measured too; `closure_of_forces`
    is without it.

    Args:
        ledger: columns of ledger.csv, each (n,) float.

    Raises:
        ValueError: the mill does no work in it.
    """
    angle = ledger["mill_angle_rad"]
    last = len(angle) - 1
    # The rows are at steps: the one nearest to a revolution ago.
    first = int(np.argmin(np.abs(angle - (angle[last] - math.tau))))
    if not angle[last] > angle[first]:
        raise ValueError("ledger.csv: the mill does not turn")

    def change(name: str) -> float:
        return float(ledger[name][last] - ledger[name][first])

    work = change("mill_work_J")
    if work == 0.0:
        raise ValueError("ledger.csv: the mill does no work")
    pairings = {name: _pairing(name, change) for name in PAIRINGS}
    kept = {name: change(name) for name in CHARGE}
    elastic = sum(x.elastic_normal_J + x.elastic_tangential_J for x in pairings.values())
    dissipated = sum(x.dissipated_J for x in pairings.values())
    error = sum(x.spring_error_J for x in pairings.values())
    residual = work - sum(kept.values()) - elastic - dissipated
    return EnergyBudget(
        from_rad=float(angle[first]),
        to_rad=float(angle[last]),
        duration_s=change("time_s"),
        mill_work_J=work,
        **kept,
        elastic_J=elastic,
        dissipated_J=dissipated,
        spring_error_J=error,
        **pairings,
        closure=residual / work,
        closure_of_forces=(residual - error) / work,
    )


def _pairing(pairing: str, change: Callable[[str], float]) -> PairingBudget:
    """Return the terms of one pairing of bodies. `tangential_spring_J` is the rest of the
    tangential dissipation besides dashpot and slip: a spring whose stiffness follows the overlap is
    not conservative."""
    names = (*ELASTIC, *DISSIPATED, "tangential_dashpot_J", "tangential_slip_J")
    terms = {name: change(f"{pairing}_{name}") for name in (*names, "spring_error_J")}
    spring = terms["dissipated_tangential_J"]
    spring -= terms["tangential_dashpot_J"] + terms["tangential_slip_J"]
    return PairingBudget(
        **terms,
        tangential_spring_J=spring,
        dissipated_J=sum(terms[name] for name in DISSIPATED),
        impacts=change(f"{pairing}_impacts"),
        impact_energy_J=change(f"{pairing}_impact_energy_J"),
    )


def read_ledger(folder: Path) -> Series:
    """Return the columns of a case's ledger.csv, each (n,) float."""
    return read_series(folder / LEDGER, "ledger")


def impact_spectrum(path: Path) -> dict[str, ImpactSpectrum]:
    """Return impacts per revolution by pairing and energy, of an impacts.csv."""
    lines = read_text(path, MOST_SERIES, _REMEDY).splitlines()
    if not lines or tuple(lines[0].split(",")) != _IMPACT_COLUMNS:
        raise RunFolderError(path, f"columns must be {', '.join(_IMPACT_COLUMNS)}", _REMEDY)
    rows = [dict(zip(_IMPACT_COLUMNS, line.split(","), strict=False)) for line in lines[1:]]
    return {name: _spectrum(path, [r for r in rows if r["pairing"] == name]) for name in PAIRINGS}


def _spectrum(path: Path, rows: list[dict[str, str]]) -> ImpactSpectrum:
    columns = ("energy_low_J", "energy_high_J", "impacts", "energy_J")
    try:
        turned = [float(r["mill_angle_to_rad"]) - float(r["mill_angle_from_rad"]) for r in rows]
        values = np.array([[float(r[name]) for name in columns] for r in rows])
        if not np.isfinite([*turned, *values.ravel()]).all():
            raise ValueError("a number is not finite")
    except (KeyError, ValueError) as error:
        raise RunFolderError(path, f"a row is not whole: {error}", _REMEDY) from None
    if not turned or min(turned) <= 0.0:
        raise RunFolderError(path, "holds no turned angle", _REMEDY)
    values[:, 2:] *= math.tau / turned[0]
    kept = values[values[:, 2] > 0.0]
    return ImpactSpectrum(**{name: tuple(kept[:, k].tolist()) for k, name in enumerate(columns)})


def read_energy_budget(folder: Path) -> EnergyBudget:
    """Return the energy budget of a case folder, with the impacts of a revolution."""
    budget = energy_budget(read_ledger(folder))
    return replace(budget, impacts=impact_spectrum(folder / IMPACTS))
