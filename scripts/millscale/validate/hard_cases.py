"""Largest stable time step of mills that are hard to integrate: `millscale validate hard-cases`."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from millscale.engine.record import provenance
from millscale.errors import CampaignError
from millscale.runs.untrusted import read_object
from millscale.runs.writing import write_json, write_text
from millscale.validate.cases import CASES, Case, Mill, base_campaign, mill_of
from millscale.validate.deck import BACKENDS, run_case
from millscale.validate.hard_cases_page import COMMAND, page
from millscale.validate.scenes import balls_of
from millscale.validate.verdict import STABLE, Measured, energy_error, measure, verdict

# Fractions of the Rayleigh time. Runs at the first ones differ by chaos, not by the step, and their
# mean is the reference.
RESOLVED = (0.05, 0.1)
LADDER = (*RESOLVED, 0.2, 0.4)
SEED = 1
ORDER = [case.name for case in CASES]
# The engine's mesh wall takes a fifth of a millisecond a step.
STOCK_STEPS = 100_000


class CaseRuns:
    """Runs of one case with one contact backend."""

    def __init__(self, case: Case, backend: str, folder: Path):
        if backend == "stock" and case.steps:
            case = replace(case, steps=min(case.steps, STOCK_STEPS))
        self.case, self.backend = case, backend
        self._folder = folder
        self._mill = mill_of(case, base_campaign())
        self._found: dict[float, Measured] = {}

    def run(self, share: float) -> None:
        """Run at a fraction of the Rayleigh time."""
        balls = balls_of(self.case, self._mill, SEED)
        step = share * self._mill.rayleigh_time
        folder = self._folder / f"{share:g}"
        ran = run_case(folder, self.case, self._mill, balls, self.backend, step)
        self._found[share] = measure(self.case, self._mill, balls, ran)

    def rows(self) -> list[dict]:
        """Return the rows of all steps, and of one between the last stable and the next."""
        for share in self.case.only or LADDER:
            self.run(share)
        rows = self._rows()
        bad = next((k for k, r in enumerate(rows) if r["verdict"] != STABLE), 0)
        if bad > 0:
            low, high = (rows[k]["dt_over_rayleigh"] for k in (bad - 1, bad))
            self.run(round((low * high) ** 0.5, 4))
        return self._rows()

    def reference(self) -> float:
        """Return the mean energy of the finished runs at the first steps; NaN without any."""
        energies = [self._found[s].energy for s in RESOLVED if s in self._found]
        ended = [e for e in energies if np.isfinite(e)]
        return float(np.mean(ended)) if ended else float("nan")

    def scatter(self) -> float | None:
        """Return the largest energy error of a run at the first steps."""
        errors = [r["energy_error"] for r in self._rows() if r["dt_over_rayleigh"] in RESOLVED]
        return max((e for e in errors if e is not None), default=None)

    def _rows(self) -> list[dict]:
        return [self._row(share, self._found[share]) for share in sorted(self._found)]

    def _row(self, share: float, found: Measured) -> dict:
        error = energy_error(self.case, found, self.reference())
        numbers = {
            "energy_error": error,
            "max_overlap": found.max_overlap,
            "spin_noise": found.spin_noise,
        }
        return {
            "case": self.case.name,
            **step_of(self._mill, self.backend, share),
            **{k: float(v) if np.isfinite(v) else None for k, v in numbers.items()},
            "lost": found.lost,
            "stopped_by": found.stopped_by,
            "verdict": verdict(self.case, found, error),
        }


def step_of(mill: Mill, backend: str, share: float) -> dict:
    """Return the part of a row for a backend and a fraction of the Rayleigh time."""
    step = share * mill.rayleigh_time
    return {
        "path": backend,
        "dt": step,
        "dt_over_rayleigh": share,
        "dt_over_damping_limit": step / mill.damping_limit(BACKENDS[backend].bounded),
    }


def turn_of(rows: list[dict]) -> dict:
    """Return the largest stable step of a case and backend, and the first that is not stable."""
    bad = next((r for r in rows if r["verdict"] != STABLE), None)
    good = [r for r in rows if bad is None or r["dt"] < bad["dt"]]
    return {
        "case": rows[0]["case"],
        "path": rows[0]["path"],
        "stable_up_to": good[-1]["dt_over_rayleigh"] if good else None,
        "turns_by": bad["dt_over_rayleigh"] if bad else None,
        "turns_to": bad["verdict"] if bad else None,
        "rayleigh_s": rows[0]["dt"] / rows[0]["dt_over_rayleigh"],
        "damping_limit_over_rayleigh": rows[0]["dt_over_rayleigh"]
        / rows[0]["dt_over_damping_limit"],
    }


def run_all(cases: tuple[Case, ...], backends: tuple[str, ...], before: dict) -> Iterator[dict]:
    """Yield rows and turns of the cases with the backends, after each case those so far.

    Args:
        before: results, of which those of other cases and backends are kept.
    """
    rows, turns = (list(kept(before.get(part, []), cases, backends)) for part in ("rows", "turns"))
    began = time.time()
    for case in cases:
        for backend in backends:
            with tempfile.TemporaryDirectory(prefix="hard-case-") as folder:
                runs = CaseRuns(case, backend, Path(folder))
                own = runs.rows()
                rows += own
                turns.append(turn_of(own) | {"scatter": runs.scatter()})
            first = turns[-1]["turns_by"] or "none"
            spent = f"{time.time() - began:5.0f} s"
            print(f"{spent}  {case.name}, {backend}: unstable from {first} T_R", flush=True)
        yield {"schema": 1, "rows": in_order(rows), "turns": in_order(turns)}


def kept(rows: list[dict], cases: tuple[Case, ...], backends: tuple[str, ...]) -> Iterator[dict]:
    """Yield rows or turns of known cases and backends that are not run again."""
    again = {(case.name, backend) for case in cases for backend in backends}
    for row in rows:
        known = row["case"] in ORDER and row["path"] in BACKENDS
        if known and (row["case"], row["path"]) not in again:
            yield row


def in_order(rows: list[dict]) -> list[dict]:
    """Return rows in the order of the tables of cases and backends."""
    backends = list(BACKENDS)
    return sorted(rows, key=lambda row: (ORDER.index(row["case"]), backends.index(row["path"])))


def write_hard_cases(docs: Path, only: str, backends: Sequence[str]) -> None:
    """Write results/hard-cases.json and results/hard-cases.md into a folder after each case.

    Args:
        only: text in the names of the cases to run; empty for all. Other results are kept.
        backends: keys of BACKENDS to run; empty for all. Other results are kept.

    Raises:
        CampaignError: no case has such a name, or a backend is not a key of BACKENDS.
    """
    for backend in backends:
        if backend not in BACKENDS:
            raise CampaignError(COMMAND, "--backend", f"got {backend}", ", ".join(BACKENDS))
    cases = tuple(case for case in CASES if only in case.name)
    if not cases:
        raise CampaignError(COMMAND, "--only", f"got {only}", "; ".join(ORDER))
    file = docs / "results" / "hard-cases.json"
    before = read_object(file, "remove it") if file.exists() else {}
    file.parent.mkdir(parents=True, exist_ok=True)
    record = provenance() | {"command": COMMAND}
    for found in run_all(cases, tuple(backends) or tuple(BACKENDS), before):
        document = found | {"provenance": record}
        write_json(file, document)
        write_text(docs / "results" / "hard-cases.md", page(document))
