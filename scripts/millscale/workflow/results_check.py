"""Checks of engine results that no stage has recorded: whole, and of this case.

The engine's logs repeat the decks as they were generated, with the digest of case.json, and agree
with the rows, dumps and restart files beside them. The checks find mix-ups and damage, not forgery.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from millscale.cases.parameters import parameters
from millscale.engine import deck_echo, provenance
from millscale.engine.attempts import Cost
from millscale.engine.deck_run import Spent
from millscale.engine.log import engine_version, error_line, loop_timing, read_log
from millscale.engine.output_files import check_output
from millscale.engine.restart_file import SIGNATURE, NotWholeError, holds, read_restart
from millscale.engine.timing import Before, timing_record
from millscale.runs.case_file import Case
from millscale.runs.digests import Digests
from millscale.runs.layout import (
    BED_DUMP,
    DUMP_FOLDER,
    IMPACTS_FILES,
    LEDGER_FILES,
    LOADS_FILES,
    Stage,
)
from millscale.runs.provenance import read_provenance
from millscale.runs.speed import steps_of_dumps
from millscale.runs.untrusted import MOST_SERIES, RunFolderError, read_object, read_text
from millscale.workflow.stage_work import inputs_of

if TYPE_CHECKING:
    import numpy as np

OCCUPANCY_FILE = "occupancy.csv"
UNKNOWN_HARDWARE = {"cpu": "unknown", "cores": 0, "available_cores": 0}
_BALLS_SOUGHT = 3
# The engine's log has 8 digits, a dump 6.
_LOG_DIGITS, _DUMP_DIGITS = 1e-6, 1e-4
# Errors that damaged text causes.
_NOT_UNDERSTOOD = (ValueError, KeyError, IndexError, TypeError, ArithmeticError)
_ROW = re.compile(r"^\s+(\d+)\s+(\d+)\s+(\S+)\s+(\S+)\s*$", re.M)
_WINDOW = re.compile(r"^fix occupancy .* from ([-+.\de]+) to ([-+.\de]+) file", re.M)
_GRID = re.compile(r"^\s*(\d+) by (\d+) by (\d+) MPI processor grid", re.M)


class NotUsedError(RuntimeError):
    """Results made by hand that cannot be used; the text states the reason."""


@dataclass(frozen=True)
class HandRun:
    """An engine stage that was run by hand.

    Attributes:
        files: files of the engine, names relative to the case folder.
        timing: content of timing.json.
        engine: version line of the engine's log.
    """

    ranks: int
    files: tuple[str, ...]
    timing: dict[str, Any]
    engine: str


@dataclass(frozen=True)
class _Log:
    """The log of one start of the engine.

    Attributes:
        rows: step -> kinetic energy of translation [J] and mill angle [rad].
    """

    name: str
    text: str
    ranks: int
    balls: int
    rows: dict[int, tuple[float, float]]


def examine(folder: Path, case: Case, stage: Stage, dumps: bool = True) -> HandRun:
    """Check the results of an engine stage that was run by hand, and describe them.

    Args:
        dumps: whether to read the dumps, which takes longest.

    Raises:
        NotUsedError: they are not whole, or not of this case.
    """
    try:
        provenance.check_inputs(folder, stage.inputs)
        return (_settled if stage.name == "settle" else _rotated)(folder, case, stage, dumps)
    except (NotWholeError, provenance.DamagedFileError, OSError, *_NOT_UNDERSTOOD) as error:
        cause = f"{error.path.name}: {error.cause}" if isinstance(error, RunFolderError) else error
        raise NotUsedError(f"{stage.products[0]} made by hand is not used: {cause}") from None


def _settled(folder: Path, case: Case, stage: Stage, dumps: bool) -> HandRun:
    from millscale.packing.bed import read_bed

    steps = case.time.settle_steps
    logs = _logs(folder, case, stage, first=0, steps=steps)
    restart = read_restart(folder / stage.products[0])
    if restart.step != steps:
        raise NotWholeError(f"{restart.path.name} is of step {restart.step}, not {steps}")
    if not (folder / BED_DUMP).exists():
        raise NotWholeError(f"no {BED_DUMP}, which settle.in writes")
    try:
        bed, velocities = read_bed(folder / BED_DUMP, case.mill.simulated_length_m)
    except ValueError as error:
        raise NotWholeError(f"{BED_DUMP} is not whole: {error}") from None
    if len(velocities) != case.ball.count:
        raise NotWholeError(f"{BED_DUMP} has {len(velocities)} balls, not {case.ball.count}")
    some = bed.centres[:: max(1, len(bed.centres) // _BALLS_SOUGHT)][:_BALLS_SOUGHT]
    if not holds(restart.path, some):
        raise NotWholeError(f"{restart.path.name} does not hold the balls of {BED_DUMP}")
    energy = _kinetic_energy(case, bed.radii, velocities)
    _agree(BED_DUMP, logs[-1], steps, energy, logs[-1].rows[steps][0], _LOG_DIGITS)
    return _run(folder, stage, logs, first=0, files=(stage.products[0],))


def _rotated(folder: Path, case: Case, stage: Stage, dumps: bool) -> HandRun:
    time, output = case.time, case.output
    first, steps = time.settle_steps, time.steps
    last = first + steps
    logs = _logs(folder, case, stage, first, steps)
    if "settled.restart" in stage.inputs:
        _begun_from(folder, case, logs[0], first)
    check_output(folder, first, last)
    series = _Series(folder / stage.products[0])
    every = output.sample_steps
    if series.steps != [*range(first // every * every + every, last + 1, every)]:
        raise NotWholeError(
            f"{series.name} has not a row every {every} steps from {first} to {last}"
        )
    both = [step for log in logs for step in log.rows if step in series.row]
    if not both:
        raise NotWholeError(f"no row of {series.name} is at a step of the table in {logs[-1].name}")
    for log in logs:
        for step, (energy, angle) in log.rows.items():
            if step in series.row:
                row = series.row[step]
                _agree(series.name, log, step, row["kinetic_translation_J"], energy, _LOG_DIGITS)
                _agree(series.name, log, step, row["mill_angle_rad"], angle, _LOG_DIGITS)
    files = [stage.products[0]]
    if case.kind == "multi-ball":
        files.append(_occupancy(folder, series, logs[-1]))
    if case.deck.ledger == "on":
        files += [name for name in LEDGER_FILES if _is_whole(folder / name)]
        _check_ledger(_Series(folder / "ledger.csv"), series)
    if case.deck.liner_loads == "on":
        files += [name for name in LOADS_FILES if _is_whole(folder / name)]
    if case.deck.impacts == "on":
        files += [name for name in IMPACTS_FILES if _is_whole(folder / name)]
    if case.deck.dumps == "on":
        _check_dumps(folder, series, steps_of_dumps(case, first), dumps)
        files.append(DUMP_FOLDER)
    return _run(folder, stage, logs, first, tuple(files))


def _logs(folder: Path, case: Case, stage: Stage, first: int, steps: int) -> list[_Log]:
    """Return the logs of all starts of the engine; together they cover all steps of the stage."""
    names = [f"log.{stage.name}"]
    while (folder / f"log.{stage.name}.{len(names)}").exists():
        names.insert(-1, f"log.{stage.name}.{len(names)}")
    decks = _decks(folder, stage)
    logs = [_log(folder / name, case, stage, decks) for name in names]
    at = first
    for log, after in zip(logs, [*logs[1:], None], strict=True):
        if min(log.rows) != at:
            raise NotWholeError(f"{log.name} begins at step {min(log.rows)}, not at {at}")
        if after:
            signature = SIGNATURE.search(log.text.encode(errors="replace"))
            if not signature:
                raise NotWholeError(f"{log.name} does not end with the signature of a restart file")
            at = int(signature[1])
    final = logs[-1]
    done = loop_timing(final.text)
    cause = error_line(final.text)
    if (
        done is None
        or cause
        or max(final.rows) != first + steps
        or at + done.steps != first + steps
    ):
        where = f"ends at step {max(final.rows)} of {first + steps}"
        raise NotWholeError(f"{final.name} {where}{f': {cause}' if cause else ''}")
    if len({log.ranks for log in logs}) > 1:
        counts = ", ".join(str(log.ranks) for log in logs)
        raise NotWholeError(f"its starts were on different numbers of ranks: {counts}")
    return logs


def _decks(folder: Path, stage: Stage) -> dict[str, str]:
    """Return the decks of a stage, by name; refuse decks that were edited."""
    written = read_provenance(folder).get("deck", {}).get("products", {})
    found, decks = Digests(folder), {}
    for name in inputs_of(stage, folder):
        if not name.endswith(".in"):
            continue
        if found.of(name) != written.get(name):
            raise NotWholeError(f"{name} was edited since millscale generate wrote it")
        decks[name] = read_text(folder / name, MOST_SERIES, "")
    return decks


def _log(path: Path, case: Case, stage: Stage, decks: Mapping[str, str]) -> _Log:
    """Return a log; refuse one of another case or of other decks."""
    if not path.exists():
        raise NotWholeError(f"no {path.name} shows how it was made")
    text = read_log(path)
    digest = f"variable case_digest string {parameters(case)['case_digest']}"
    if digest not in text:
        raise NotWholeError(f"{path.name} is not of this case.json: `{digest}` is not in it")
    if different := deck_echo.difference(text, decks, stage.deck):
        raise NotWholeError(f"{path.name} is not that of {stage.deck}: {different}")
    grid = _GRID.search(text)
    rows = {int(s): (_number(e), _number(a), int(n)) for s, n, e, a in _ROW.findall(text)}
    if not grid or not rows:
        raise NotWholeError(f"{path.name} ends before the first step")
    balls = {count for *_, count in rows.values()}
    if balls != {case.ball.count}:
        raise NotWholeError(f"{path.name} has {max(balls)} balls, not {case.ball.count}")
    ranks = math.prod(int(x) for x in grid.groups())
    return _Log(path.name, text, ranks, max(balls), {s: (e, a) for s, (e, a, _) in rows.items()})


def _begun_from(folder: Path, case: Case, log: _Log, step: int) -> None:
    """Refuse a rotation that began from another bed than the one in the folder."""
    own = folder / "log.settle"
    try:
        settled_by = read_object(folder / "settled.json", "").get("settled_by")
    except RunFolderError:
        settled_by = case.id
    rows = _ROW.findall(read_log(own)) if settled_by == case.id else []
    energies = [_number(energy) for at, _, energy, _ in rows if int(at) == step]
    if energies:
        _agree(own.name, log, step, energies[-1], log.rows[step][0], _LOG_DIGITS)


def _run(
    folder: Path, stage: Stage, logs: list[_Log], first: int, files: tuple[str, ...]
) -> HandRun:
    """Return the run of some logs. Its wall time is that of the time loop; logs have no other."""
    final = logs[-1]
    loop = loop_timing(final.text)
    if loop is None:
        raise NotWholeError(f"{final.name} states no loop time")
    before = Cost()
    for log in logs[:-1]:
        signature = SIGNATURE.search(log.text.encode(errors="replace"))
        if signature is None:
            raise NotWholeError(f"{log.name} does not end with the signature of a restart file")
        spent, processor = float(signature[4]), float(signature[5])
        before += Cost(spent, processor, spent, spent * log.ranks)
    timing = timing_record(
        stage.name,
        Spent(loop.loop_time, loop.loop_time * loop.ranks),
        loop,
        Before(min(final.rows) - first, len(logs) - 1, before),
    )
    version = engine_version(folder / final.name)
    return HandRun(final.ranks, files, timing | {"hardware": UNKNOWN_HARDWARE}, version)


class _Series:
    """The rows of a series: mill angle, kinetic energy and centre of mass, by step."""

    def __init__(self, path: Path) -> None:
        self.name = path.name
        text = read_text(path, MOST_SERIES, "")
        wanted = ("mill_angle_rad", "kinetic_translation_J", "centre_x_m", "centre_z_m")
        self.row: dict[int, dict[str, float]] = {}
        for row in csv.DictReader(text.splitlines()):
            try:
                step = int(row["step"])
                self.row[step] = {x: float(row[x]) for x in wanted if x in row}
            except (ValueError, KeyError, TypeError):
                raise NotWholeError(f"{path.name} has a row that is not understood") from None
        self.steps = list(self.row)

    def column(self, name: str) -> list[float]:
        return [row[name] for row in self.row.values()]


def _agree(name: str, log: _Log, step: int, got: float, logged: float, digits: float) -> None:
    if not math.isclose(got, logged, rel_tol=digits, abs_tol=1e-12):
        what = f"{name} has {got:.8g} at step {step} where {log.name} has {logged:.8g}"
        raise NotWholeError(f"{what}: they are of different runs")


def _kinetic_energy(case: Case, radii: np.ndarray, velocities: np.ndarray) -> float:
    """Return the kinetic energy of translation [J]; radii (n,) [m], velocities (n, 3) [m/s]."""
    masses = case.ball.density_kg_m3 * 4.0 / 3.0 * math.pi * radii**3
    return float(0.5 * (masses * (velocities**2).sum(axis=1)).sum())


def _occupancy(folder: Path, series: _Series, log: _Log) -> str:
    """Return the name of occupancy.csv; refuse one that is averaged over other mill angles than
    the deck states."""
    name = OCCUPANCY_FILE
    _is_whole(folder / name)
    row = next(csv.DictReader(read_text(folder / name, MOST_SERIES, "").splitlines()))
    found = [float(row[f"mill_angle_{x}_rad"]) for x in ("from", "to")]
    low, high = (float(x) for x in _WINDOW.findall(log.text)[-1])
    within = [x for x in series.column("mill_angle_rad") if low <= x <= high]
    for got, expected in zip(found, (within[0], within[-1]), strict=True):
        if not math.isclose(got, expected, rel_tol=_LOG_DIGITS):
            what = f"{name} has the mill angle {got:.8g} rad where {series.name} has {expected:.8g}"
            raise NotWholeError(f"{what}: they are of different runs")
    return name


def _check_ledger(ledger: _Series, series: _Series) -> None:
    """Refuse an energy budget whose changes of the kinetic energy are not those of the series."""
    energies = series.column("kinetic_translation_J")
    changes = ledger.column("kinetic_translation_J")
    same_rows = ledger.steps == series.steps
    start = energies[0] - changes[0]
    tolerance = _LOG_DIGITS * max(map(abs, energies))
    if not same_rows or any(
        abs(energy - change - start) > tolerance
        for energy, change in zip(energies, changes, strict=True)
    ):
        raise NotWholeError(f"{ledger.name} and {series.name} are of different runs")


def _is_whole(path: Path) -> bool:
    """Return true; raise an error if a row has another number of columns than the header."""
    lines = read_text(path, MOST_SERIES, "").split("\n")
    if len(lines) < 3 or lines[-1] or len({line.count(",") for line in lines[:-1]}) != 1:
        raise NotWholeError(f"{path.name} is not whole")
    return True


def _check_dumps(folder: Path, series: _Series, steps: Collection[int], read: bool) -> None:
    """Refuse missing dumps and, with `read`, dumps whose centre of mass differs from the series."""
    import numpy as np

    from millscale.runs.dumps import dump_files, read_dump

    files = dump_files(folder)
    missing = [step for step in steps if step not in files]
    if missing:
        raise NotWholeError(f"no dump of step {missing[0]} in {DUMP_FOLDER}/")
    if more := [path.name for step, path in files.items() if step not in steps]:
        raise NotWholeError(f"{DUMP_FOLDER}/{more[0]} is of no step at which mill.in dumps")
    for step in steps if read else ():
        dump = read_dump(files[step])
        weights = dump["radius"] ** 3
        for axis in "xz":
            column = series.column(f"centre_{axis}_m")
            expected = float(np.interp(step, series.steps, column))
            moved = float(np.abs(np.diff(column)).max(initial=0.0))
            centre = float(np.average(dump[axis], weights=weights))
            if abs(centre - expected) > 2.0 * moved + _DUMP_DIGITS * abs(expected):
                raise NotWholeError(
                    f"{files[step].name} has its centre of mass at {axis} = {centre:.6g} m where "
                    f"{series.name} has {expected:.6g}: they are of different runs"
                )


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
