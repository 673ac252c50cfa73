"""Folders of the cases of a study: in its own runs folder, or finished in another.

A case is reused if its case.json agrees in all keys but `id` and `campaign`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from millscale.cases.generate import as_written, changed_cases
from millscale.errors import CampaignError
from millscale.runs.case_file import load_case
from millscale.runs.current import unfinished
from millscale.runs.layout import CAMPAIGN_FILE, CASE_FILE, CASES_FOLDER
from millscale.runs.untrusted import MOST_JSON, RunFolderError, read_text
from millscale.runs.writing import write_json, write_text
from millscale.study.file import Setting, StudyFile

SETTINGS_FOLDER = "settings"
STUDY_JSON = "study.json"
SETTING_FILE = "setting.toml"


@dataclass(frozen=True)
class Places:
    """Folders of a study.

    Attributes:
        runs: runs folder of the study.
        others: runs folders of campaigns whose finished cases are reused.
    """

    runs: Path
    others: tuple[Path, ...] = ()

    def of(self, setting: Setting) -> Path:
        """Return the runs folder of a setting."""
        return self.runs / SETTINGS_FOLDER / setting.name

    def check(self, command: str) -> None:
        """Refuse another folder that is not a runs folder.

        Args:
            command: that the folders were given to, for messages.

        Raises:
            CampaignError: not a runs folder.
        """
        for folder in self.others:
            if not (folder / CAMPAIGN_FILE).exists():
                cause = f"got {folder}, which has no {CAMPAIGN_FILE}"
                raise CampaignError(command, "--from", cause, "a folder of millscale run")


def found_cases(settings: Iterable[Setting], setting: Setting, places: Places) -> dict[str, Path]:
    """Return the folders of the finished cases of a setting, by id.

    A folder is that of the setting, or one of the same case in another setting or runs folder.

    Args:
        settings: every setting of the runs folder.
    """
    own = places.of(setting)
    changed = changed_cases(as_written(setting.cases, own), own)
    found = {
        case.id: own / CASES_FOLDER / case.id
        for case in setting.cases
        if case.id not in changed and _is_finished(own / CASES_FOLDER / case.id)
    }
    wanted = {x.identity: x.id for x in setting.cases if x.id not in found}
    others = [places.of(other) for other in settings if other is not setting]
    for folder in _case_folders([*places.others, *others]) if wanted else ():
        case_id = wanted.get(_identity_at(folder) or "")
        if case_id and case_id not in found and _is_finished(folder):
            found[case_id] = folder
    return found


def record(study: StudyFile, places: Places) -> None:
    """Write study.json: the settings and the folders of their cases, for the analysis.

    Cases that are not finished have the folder of their setting.
    """
    settings = []
    for setting in study.settings:
        found = found_cases(study.settings, setting, places)
        own = places.of(setting)
        cases = [
            {
                "id": x.id,
                "folder": _from(places.runs, found.get(x.id, own / CASES_FOLDER / x.id)),
                "identity": x.identity,
            }
            for x in setting.cases
        ]
        settings.append(
            {
                "name": setting.name,
                "about": setting.about,
                "cases": cases,
            }
        )
    content = {
        "schema": 1,
        "name": study.name,
        "about": study.about,
        "file": study.file.name,
        "reference": study.reference,
        "default": study.default,
        "settings": settings,
    }
    write_json(places.runs / STUDY_JSON, content)


def write_setting(setting: Setting, folder: Path) -> Path:
    """Write the campaign file of a setting into its runs folder unless it exists."""
    folder.mkdir(parents=True, exist_ok=True)
    file, text = folder / SETTING_FILE, setting.text()
    if not file.exists() or read_text(file, MOST_JSON, "remove it") != text:
        write_text(file, text)
    return file


def _from(runs: Path, folder: Path) -> str:
    """Return the path of a folder, relative to that of the study if it is inside."""
    runs, folder = runs.resolve(), folder.resolve()
    return str(folder.relative_to(runs) if folder.is_relative_to(runs) else folder)


def _case_folders(runs: Sequence[Path]) -> Iterable[Path]:
    for folder in runs:
        yield from sorted(path.parent for path in folder.glob(f"{CASES_FOLDER}/*/{CASE_FILE}"))


def _identity_at(folder: Path) -> str | None:
    try:
        return load_case(folder).identity
    except RunFolderError:
        return None


def _is_finished(folder: Path) -> bool:
    return not unfinished(folder, "multi-ball")
