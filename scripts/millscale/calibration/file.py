"""Calibration file: a campaign, parameters with ranges, and what was measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from millscale.calibration.inference import Parameter
from millscale.calibration.targets import TARGET_KEYS, Target, target_of
from millscale.campaign.build import NAME, campaign_name
from millscale.campaign.keys import REQUIRED, SECTIONS, Key
from millscale.campaign.reader import parse_toml, read_section, unknown_word
from millscale.campaign.writer import Tree, toml_text
from millscale.errors import CampaignError, Mistakes
from millscale.runs.digests import text_digest
from millscale.study.file import Setting, base_of, merged, section_of, setting_of

MOST_PARAMETERS, MOST_TARGETS, MOST_EXPERIMENTS = 6, 50, 20
# Runs of the first round and of each later one, for each parameter.
FIRST, LATER = 8, 3
DIGITS = 6

CALIBRATION_KEYS = {
    "name": Key("text", "lower-case letters, digits and hyphens; default: the file's name"),
    "about": Key("text", "one line for the page", ""),
    "base": Key("text", "campaign of the measured mill, from the folder of this file", REQUIRED),
    "samples": Key("integer", "of the first round; default: 8 for each parameter", least=3,
                   most=1000),
    "samples_per_round": Key(
        "integer", "of each later round; default: 3 for each parameter", least=1, most=1000
    ),
    "rounds": Key("integer", "at most; it ends before once it has converged", 4, least=1, most=100),
    "level": Key("number", "probability of the intervals", 0.95, least=0.5, most=0.999),
    "seed": Key("integer", "of the samples", 1, least=0, most=10**9),
}  # fmt: skip
PARAMETER_KEYS = {
    "keys": Key("text", "of the campaign file that get the value", REQUIRED, many=True),
    "name": Key("text", "for the page; default: the first key"),
    "least": Key("number", "least value", REQUIRED),
    "most": Key("number", "largest value", REQUIRED),
    "scale": Key(
        "text", "logarithmic: ranges of several decades", "linear",
        choices=("linear", "logarithmic"),
    ),
}  # fmt: skip
EXPERIMENT_KEYS = {
    "name": Key("text", "lower-case letters, digits and hyphens", REQUIRED),
}
_PARTS = ("calibration", "all", "parameter", "experiment", "target")


@dataclass(frozen=True)
class Experiment:
    """A mill that was measured.

    Attributes:
        name: empty if there is only one.
        tree: content of its campaign file, without values of the parameters.
    """

    name: str
    tree: Tree


@dataclass(frozen=True, eq=False)
class CalibrationFile:
    """A checked calibration file.

    Attributes:
        samples: of the first round.
        later: samples of each later round.
    """

    file: Path
    name: str
    about: str
    parameters: tuple[Parameter, ...]
    experiments: tuple[Experiment, ...]
    targets: tuple[Target, ...]
    samples: int
    later: int
    rounds: int
    level: float
    seed: int

    @property
    def digest(self) -> str:
        """Return the digest of what decides a run of given values: mills and keys."""
        keys = "\n".join(" ".join(parameter.keys) for parameter in self.parameters)
        return text_digest("\n".join([keys, *(toml_text(one.tree) for one in self.experiments)]))

    def settings(self, name: str, about: str, values: Sequence[float]) -> dict[str, Setting]:
        """Return the campaigns of some values of the parameters, by experiment.

        Args:
            name: of the campaigns, with the experiment's after it if there are several.

        Raises:
            CampaignError: a campaign is not accepted with these values.
        """
        made = {}
        for experiment in self.experiments:
            tree = {
                section: dict(content) if isinstance(content, Mapping) else content
                for section, content in experiment.tree.items()
            }
            for parameter, value in zip(self.parameters, values, strict=True):
                for key in parameter.keys:
                    section, _, word = key.partition(".")
                    tree.setdefault(section, {})[word] = rounded(value)
            full = f"{name}-{experiment.name}" if experiment.name else name
            made[experiment.name] = setting_of(self.file, full, (full, about), tree)
        return made


def rounded(value: float) -> float:
    """Return a value as campaign files of samples state it."""
    return float(f"{value:.{DIGITS}g}")


def is_calibration(path: Path) -> bool:
    """Return whether a TOML file is a calibration file, and not a campaign."""
    return "calibration" in parse_toml(path)


def load_calibration(path: str | Path) -> CalibrationFile:
    """Return the calibration of a TOML file; the campaigns at both ends of the ranges are checked.

    Raises:
        CampaignError: the file, its base, a profile or a campaign is not accepted.
    """
    path = Path(path)
    tree = parse_toml(path)
    for word in tree:
        if word not in _PARTS:
            raise unknown_word(path, word, "", dict.fromkeys(_PARTS))
    content = section_of(path, "calibration", tree.get("calibration", {}))
    head = read_section(path, "calibration", content, CALIBRATION_KEYS)
    base = merged(path, "all", base_of(path, "calibration.base", head["base"]), tree.get("all", {}))
    parameters = _parameters(path, _entries(path, tree, "parameter", MOST_PARAMETERS))
    experiments = _experiments(path, base, tree)
    names = [experiment.name for experiment in experiments]
    targets = _targets(path, _entries(path, tree, "target", MOST_TARGETS), names)
    count = len(parameters)
    found = CalibrationFile(
        path,
        campaign_name(path, "calibration.name", head["name"]),
        head["about"],
        parameters,
        experiments,
        targets,
        head["samples"] or FIRST * count,
        head["samples_per_round"] or LATER * count,
        head["rounds"],
        head["level"],
        head["seed"],
    )
    if found.samples < count + 2:
        cause = f"{found.samples} samples for {count} parameters"
        raise CampaignError(path, "calibration.samples", cause, f"at least {count + 2}")
    for end in (0.0, 1.0):
        values = [float(one.value(np.array(end))) for one in parameters]
        for setting in found.settings("calibrated", "", values).values():
            _check_one_mill(path, setting)
    return found


def _entries(path: Path, tree: Tree, word: str, most: int) -> list[Mapping[str, Any]]:
    entries = tree.get(word, [])
    if not isinstance(entries, list) or not 1 <= len(entries) <= most:
        got = f"got {len(entries)}" if isinstance(entries, list) else "got no list"
        raise CampaignError(path, word, got, f"1 to {most}, each written [[{word}]]")
    return [section_of(path, f"{word}[{i}]", entry) for i, entry in enumerate(entries, 1)]


def _parameters(path: Path, entries: Sequence[Mapping[str, Any]]) -> tuple[Parameter, ...]:
    found: list[Parameter] = []
    mistakes = Mistakes()
    for number, entry in enumerate(entries, 1):
        with mistakes.collected():
            found.append(_parameter(path, f"parameter[{number}]", entry))
    mistakes.raise_all()
    keys = [key for parameter in found for key in parameter.keys]
    for i, key in enumerate(keys):
        if key in keys[:i]:
            raise CampaignError(path, "parameter", f"{key} is in two parameters", "one of them")
    return tuple(found)


def _parameter(path: Path, where: str, entry: Mapping[str, Any]) -> Parameter:
    values = read_section(path, where, entry, PARAMETER_KEYS)
    for key in values["keys"]:
        section, _, word = key.partition(".")
        if section not in SECTIONS:
            raise unknown_word(path, section, where, dict.fromkeys(SECTIONS))
        known = {name: x for name, x in SECTIONS[section].items() if x.type == "number"}
        if word not in known:
            raise unknown_word(path, word, f"{where}: {section}", known)
    least, most = values["least"], values["most"]
    logarithmic = values["scale"] == "logarithmic"
    if not least < most or (logarithmic and least <= 0.0):
        accepted = "least < most, and least > 0 on a logarithmic scale"
        raise CampaignError(path, where, f"least = {least:g}, most = {most:g}", accepted)
    name = values["name"] or values["keys"][0].partition(".")[2]
    return Parameter(name, values["keys"], least, most, logarithmic)


def _experiments(path: Path, base: Tree, tree: Tree) -> tuple[Experiment, ...]:
    if "experiment" not in tree:
        return (Experiment("", base),)
    found: list[Experiment] = []
    for number, entry in enumerate(_entries(path, tree, "experiment", MOST_EXPERIMENTS), 1):
        own = {key: value for key, value in entry.items() if key in EXPERIMENT_KEYS}
        name = read_section(path, f"experiment[{number}]", own, EXPERIMENT_KEYS)["name"]
        if not NAME.fullmatch(name) or len(name) > 40:
            accepted = "up to 40 lower-case letters, digits and single hyphens"
            raise CampaignError(path, f"experiment[{number}].name", f'got "{name}"', accepted)
        if name in [experiment.name for experiment in found]:
            cause = f'"{name}" is given twice'
            raise CampaignError(path, f"experiment[{number}].name", cause, "a name of its own")
        changes = {key: value for key, value in entry.items() if key not in EXPERIMENT_KEYS}
        found.append(Experiment(name, merged(path, f'experiment "{name}"', base, changes)))
    return tuple(found)


def _targets(
    path: Path, entries: Sequence[Mapping[str, Any]], experiments: Sequence[str]
) -> tuple[Target, ...]:
    found: list[Target] = []
    mistakes = Mistakes()
    for number, entry in enumerate(entries, 1):
        with mistakes.collected():
            found.append(target_of(path, f"target[{number}]", entry, experiments))
    mistakes.raise_all()
    names = [target.name for target in found]
    for i, name in enumerate(names):
        if name in names[:i]:
            raise CampaignError(path, f"target[{i + 1}]", f"{name} is given twice", "one of them")
    return tuple(found)


def _check_one_mill(path: Path, setting: Setting) -> None:
    mills = {(x.S, x.scheme, x.policy, x.liner_state) for x in setting.cases}
    if len(mills) > 1:
        cause = f"{len(mills)} mills: {', '.join(x.id for x in setting.cases[:3])}, ..."
        accepted = "one mill: state one S, scheme, policy and liner in [all]; seeds may be several"
        raise CampaignError(path, f"campaign {setting.name}", cause, accepted)


__all__ = [
    "CALIBRATION_KEYS",
    "EXPERIMENT_KEYS",
    "PARAMETER_KEYS",
    "TARGET_KEYS",
    "CalibrationFile",
    "Experiment",
    "is_calibration",
    "load_calibration",
    "rounded",
]
