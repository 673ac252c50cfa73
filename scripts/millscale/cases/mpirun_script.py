"""mpirun.sh of a case folder: the engine's runs of a case as one command, without Python."""

from __future__ import annotations

from pathlib import Path

from millscale.cases.decks import template_folder
from millscale.engine.deck_run import ENGINE, mpirun_line, mpirun_text
from millscale.runs.case_file import Case
from millscale.runs.layout import STAGES, Stage
from millscale.runs.writing import write_text

FILE = "mpirun.sh"
_TITLES = {
    "single-ball": "a single ball in the turning mill",
    "multi-ball": "settle the charge, then turn the mill",
}
_SETTLE = """\
if [ -e settled.restart ]; then
    of_this_case log.settle ||
        stop "settled.restart is there and log.settle is not of this case: move it to settle anew"
    echo "mpirun.sh: settled.restart is there, the charge is not settled again"
else
    begin log.settle 0 "$first"
    spread
    {line}
    finished log.settle || stop "log.settle does not end as that of a finished run"
fi
[ "$(whole settled.restart)" = "$first settled.restart" ] ||
    stop "settled.restart is cut or does not end at step $first: move it to settle anew"
"""
_ROTATE = """\
if [ -e series.csv ]; then
    of_this_case log.rotate || [ ! -e log.rotate ] ||
        stop "series.csv is there and log.rotate is not of this case: move both to begin anew"
    ! finished log.rotate ||
        stop "series.csv is there and complete: move it and dump/* elsewhere to run again"
else
    for file in dump/*.liggghts; do
        [ ! -e "$file" ] || stop "$file is there and no series.csv: move dump/* elsewhere"
    done
    # They are of no rotation, or of one that has been moved.
    rm -f mill.1.restart mill.2.restart resume.restart
fi
begin log.rotate "$first" "$last"
spread
{line}
finished log.rotate || stop "log.rotate does not end as that of a finished run"
echo "mpirun.sh: done, series.csv is complete"
"""


def script_text(case: Case, ranks: int) -> str:
    """Return mpirun.sh of a case, a POSIX shell script.

    Args:
        ranks: MPI ranks, if the environment of the script does not name others.
    """
    stages = [stage for stage in STAGES[case.kind] if stage.deck]
    bodies = {"settle": _SETTLE, "rotate": _ROTATE}
    values = {
        "title": f"{case.id}: {_TITLES[case.kind]}.",
        "ranks": str(ranks),
        "engine": ENGINE,
        "lines": "\n".join(f"#   {mpirun_text(_line(stage, ranks))}" for stage in stages),
        "stages": "\n".join(
            bodies[stage.name].format(line=_shell_line(stage, ranks)) for stage in stages
        ).rstrip("\n"),
    }
    text = (template_folder() / FILE).read_text(encoding="utf-8")
    for name, value in values.items():
        text = text.replace(f"@{name}@", value)
    return text


def write_script(case: Case, ranks: int, folder: Path) -> None:
    """Write mpirun.sh of a case to a folder."""
    path = folder / FILE
    write_text(path, script_text(case, ranks))
    path.chmod(0o755)


def _line(stage: Stage, ranks: int) -> list[str]:
    return mpirun_line(ENGINE, stage.deck, f"log.{stage.name}", ranks)


def _shell_line(stage: Stage, ranks: int) -> str:
    """Return the line with shell variables for what the user of the script may choose."""
    words = _line(stage, ranks)
    words[words.index("-np") + 1] = '"$ranks"'
    at = words.index(ENGINE)
    words[at : at + 1] = ['"$@"', '"$engine"']
    return " ".join([*words, "${resume:+-var resume 1}", "</dev/null"])
