"""`millscale solve`: plan, run, look and refine in a folder that can be resumed at any time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from rich.console import Console

from millscale.engine.machine import CoreWish, allowed, available_cores
from millscale.engine.record import provenance
from millscale.formats import duration, hundredths
from millscale.prediction.advise import Advice, Design, advise_mills, names_of
from millscale.prediction.error_model import ErrorModel, built_in, nearest_model
from millscale.prediction.planned import PlannedMills
from millscale.prediction.solve import Ask, Look, Outcome, Round, Solver
from millscale.prediction.solve_file import read_rounds, write_rounds
from millscale.prediction.solve_page import Answer, answer_lines, answer_table, write_answer
from millscale.prediction.solve_runs import SolveRuns
from millscale.prediction.table import advice_lines, advice_table
from millscale.runs.lock import hold
from millscale.workflow.placement import OPEN


@dataclass(frozen=True)
class SolveCall:
    """Arguments of the command.

    Attributes:
        file: campaign file with the physical mill and its charge.
        folder: of the rounds and the answer.
        error: relative half width wanted of each interval.
        observables: as for `advise.names_of`.
        budget_s: of all runs on one core [s].
    """

    file: Path
    folder: Path
    error: float
    observables: tuple[str, ...] = ()
    budget_s: float | None = None
    cores: CoreWish = OPEN
    ignore_disk: bool = False


@dataclass(frozen=True)
class _Scene:
    """A call whose arguments are checked."""

    call: SolveCall
    mills: PlannedMills
    model: ErrorModel
    ask: Ask
    rounds: tuple[Round, ...]

    @cached_property
    def advice(self) -> Advice:
        """Return the plan to begin with."""
        ask = self.ask
        return advise_mills(self.mills, self.model, ask.names, ask.error, ask.budget_s, ask.level)

    def design(self) -> Design:
        """Return its runs."""
        return self.advice.chosen

    def save(self, rounds: Sequence[Round]) -> None:
        write_rounds(self.call.folder, self.call.file, self.mills.digest, self.ask, rounds)


def _scene(call: SolveCall) -> _Scene:
    allowed(call.cores, available_cores(), charges=True)
    mills = PlannedMills(call.file)
    case = mills.case
    model = nearest_model(built_in(), mills.ball_over_mill, case.scheme, case.policy)
    ask = Ask(tuple(names_of(call.observables, model)), call.error, call.budget_s)
    return _Scene(call, mills, model, ask, read_rounds(call.folder, call.file, mills.digest))


def dry_run(call: SolveCall, console: Console) -> None:
    """Print the plan of a new folder, or what follows the rounds of one; writes no file."""
    scene = _scene(call)
    runs = SolveRuns(call.folder, scene.mills, console, call.cores, scene.ask.level)
    solver = Solver(scene.ask, runs, scene.model, scene.design, lambda rounds: None, _silent)
    if not scene.rounds:
        advice = scene.advice
        console.print(advice_table(advice))
        for line in advice_lines(advice, None):
            _say(console, line)
    rounds, look, following = solver.following(scene.rounds)
    for text in _lines_of(rounds, look, following, scene.ask):
        _say(console, text)
    _say(console, "no file written")


def solve(call: SolveCall, console: Console) -> Answer:
    """Make runs until the error is reached, the budget is spent or nothing helps; write and print
    the answer.

    Raises:
        CampaignError, PredictionError: wrong arguments, or a folder of something else.
        EngineError: a run failed.
    """
    scene = _scene(call)
    with hold(call.folder):
        runs = SolveRuns(
            call.folder, scene.mills, console, call.cores, scene.ask.level, call.ignore_disk
        )

        def report(asked: Round, look: Look) -> None:
            for text in _lines_of(scene.rounds, look, asked, scene.ask):
                _say(console, text)

        solver = Solver(scene.ask, runs, scene.model, scene.design, scene.save, report)
        rounds, look, outcome = solver.solve(scene.rounds)
        answer = Answer(
            scene.ask,
            outcome,
            tuple(rounds),
            look,
            runs.prediction,
            runs.refused,
            scene.model.origin,
        )
        write_answer(call.folder, answer, provenance())
    console.print(answer_table(answer))
    for line in answer_lines(answer, call.folder):
        _say(console, line)
    return answer


def _lines_of(
    rounds: Sequence[Round], look: Look, following: Round | Outcome, ask: Ask
) -> list[str]:
    """Return what is known and what follows, for the terminal."""
    lines = []
    if look.used:
        widths = ", ".join(f"{name} {hundredths(_known(look, name))} %" for name in ask.names)
        lines.append(f"half widths after {duration(look.spent_s)} on one core: {widths}")
    if isinstance(following, Outcome):
        return [*lines, f"{following.kind}: {following.text}"]
    left = ""
    if ask.budget_s is not None:
        left = f" of {duration(max(ask.budget_s - look.spent_s, 0.0))} left"
    lines.append(
        f"round {following.number}: {following.text}, about {duration(following.cost_s)}{left}: "
        f"{following.why}"
    )
    return lines


def _known(look: Look, name: str) -> float | None:
    track = look.tracks.get(name)
    return track.half_width if track else None


def _say(console: Console, text: str) -> None:
    console.print(text, markup=False, highlight=False, soft_wrap=True)


def _silent(asked: Round, look: Look) -> None:
    pass
