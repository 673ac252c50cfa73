"""Study file: settings of one campaign, one of which is the reference.

A setting is a campaign: the base file with the changes of [all] and then its own changes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from millscale.campaign.build import NAME, campaign_name, campaign_of
from millscale.campaign.campaign import Campaign
from millscale.campaign.keys import REQUIRED, SECTIONS, Key
from millscale.campaign.reader import (
    campaign_tree,
    canonical_tree,
    parse_toml,
    read_section,
    unknown_word,
)
from millscale.campaign.writer import Tree, toml_text
from millscale.cases.case import cases_of
from millscale.errors import CampaignError, nearest
from millscale.runs.case_file import Case

MOST_SETTINGS = 1000
# A study compares shape and power of charges, which single balls do not have.
LEFT_OUT = "single_ball"

STUDY_KEYS = {
    "name": Key("text", "lower-case letters, digits and hyphens; default: the file's name"),
    "about": Key("text", "one line for the page", ""),
    "base": Key("text", "campaign file, from the folder of the study file", REQUIRED),
    "reference": Key("text", "name of the setting that is taken for the truth", REQUIRED),
    "default": Key("text", "name of the setting that is compared with stock", REQUIRED),
}
SETTING_KEYS = {
    "name": Key("text", "of the setting, lower-case letters, digits and hyphens", REQUIRED),
    "about": Key("text", "what it is for, a line for the page", ""),
}
WITHOUT = "without"
WITHOUT_KEYS = {
    WITHOUT: Key("text", "keys of the base that are left out, as multi_ball.count", (), many=True)
}
_PARTS = ("study", "all", "setting")


@dataclass(frozen=True)
class Setting:
    """One setting of a parameter study.

    Attributes:
        tree: content of its campaign file.
        campaign: that campaign, checked and resolved.
    """

    name: str
    about: str
    tree: Tree
    campaign: Campaign
    cases: tuple[Case, ...]

    def text(self) -> str:
        """Return its campaign file."""
        return toml_text(self.tree)


@dataclass(frozen=True)
class StudyFile:
    """A checked study file; `reference` and `default` are names of settings."""

    file: Path
    name: str
    about: str
    reference: str
    default: str
    settings: tuple[Setting, ...]


def load_study(path: str | Path) -> StudyFile:
    """Return the study of a TOML file; every setting is checked as a campaign.

    Raises:
        CampaignError: the study file, its base or a setting is not accepted.
    """
    path = Path(path)
    tree = parse_toml(path)
    for word in tree:
        if word not in _PARTS:
            raise unknown_word(path, word, "", dict.fromkeys(_PARTS))
    head = read_section(path, "study", section_of(path, "study", tree.get("study", {})), STUDY_KEYS)
    entries = tree.get("setting", [])
    if not isinstance(entries, list) or not 2 <= len(entries) <= MOST_SETTINGS:
        got = f"got {len(entries)}" if isinstance(entries, list) else "got no list"
        accepted = f"2 to {MOST_SETTINGS} settings, each written [[setting]]"
        raise CampaignError(path, "setting", got, accepted)
    base = base_of(path, "study.base", head["base"])
    changed = merged(path, "all", base, tree.get("all", {}))
    settings = [_setting(path, entry, i, changed) for i, entry in enumerate(entries)]
    _check_names(path, head, [setting.name for setting in settings])
    return StudyFile(
        path,
        campaign_name(path, "study.name", head["name"]),
        head["about"],
        head["reference"],
        head["default"],
        tuple(settings),
    )


def base_of(path: Path, key: str, name: str) -> Tree:
    """Return the content of a base campaign, without its single balls.

    Args:
        path: of the file that names it, with the key.

    Raises:
        CampaignError: not a campaign of a charge.
    """
    base = campaign_tree(path.parent / name)
    if "multi_ball" not in base:
        cause = f"got {name}, which has no [multi_ball]"
        raise CampaignError(path, key, cause, "the campaign of a charge")
    return {section: content for section, content in base.items() if section != LEFT_OUT}


def merged(path: Path, where: str, base: Tree, changes: Any) -> Tree:
    """Return a campaign with some keys left out and some changed; the arguments stay as they are.

    Raises:
        CampaignError: the changes are not sections of keys, or a key to leave out is not there.
    """
    result = {name: dict(c) if isinstance(c, Mapping) else c for name, c in base.items()}
    changes = dict(section_of(path, where, changes))
    left_out = {key: value for key, value in changes.items() if key == WITHOUT}
    for key in read_section(path, where, left_out, WITHOUT_KEYS)[WITHOUT]:
        section, _, name = key.partition(".")
        if name not in result.get(section, {}):
            cause = f'got "{key}", which the base does not have'
            raise CampaignError(path, f"{where}.{WITHOUT}", cause, "SECTION.KEY of the base")
        del result[section][name]
    changes.pop(WITHOUT, None)
    for name, content in canonical_tree(path, changes, f"{where}: ").items():
        if name not in SECTIONS or name == LEFT_OUT:
            known = {key: None for key in SECTIONS if key != LEFT_OUT}
            raise unknown_word(path, name, where, known)
        if not isinstance(content, Mapping):
            cause = f"got {content!r:.60}"
            raise CampaignError(path, f"{where}.{name}", cause, f"a key of it, {name}.KEY = ...")
        result[name] = {**result.get(name, {}), **content}
    return result


def _setting(path: Path, entry: Any, index: int, base: Tree) -> Setting:
    entry = section_of(path, f"setting {index + 1}", entry)
    own = {key: value for key, value in entry.items() if key in SETTING_KEYS}
    about = read_section(path, f"setting {index + 1}", own, SETTING_KEYS)
    name = about["name"]
    if not NAME.fullmatch(name) or len(name) > 64:
        accepted = "up to 64 lower-case letters, digits and single hyphens, such as step-1e-4"
        raise CampaignError(path, f"setting {index + 1}.name", f'got "{name}"', accepted)
    where = f'setting "{name}"'
    changes = {key: value for key, value in entry.items() if key not in SETTING_KEYS}
    return setting_of(path, where, (name, about["about"]), merged(path, where, base, changes))


def setting_of(path: Path, where: str, about: tuple[str, str], tree: Tree) -> Setting:
    """Return the setting of a campaign.

    Args:
        where: the setting, for messages.
        about: its name and what it is for.
        tree: content of its campaign file; [campaign] is replaced.

    Raises:
        CampaignError: the campaign is not accepted.
    """
    name, text = about
    tree = tree | {"campaign": {"name": name, "about": text}}
    try:
        campaign = campaign_of(path, tree)
        cases = tuple(cases_of(campaign))
    except CampaignError as error:

        def of_setting(mistake: CampaignError) -> CampaignError:
            key = f"{where}: {mistake.key}".rstrip(": ")
            return CampaignError(path, key, mistake.cause, mistake.accepted)

        raise error.each(of_setting) from None
    return Setting(name, text, tree, campaign, cases)


def _check_names(path: Path, head: Mapping[str, str], names: list[str]) -> None:
    for i, name in enumerate(names):
        if name in names[:i]:
            raise CampaignError(
                path, f"setting {i + 1}.name", f'"{name}" is given twice', "a name of its own"
            )
    for role in ("reference", "default"):
        if head[role] not in names:
            near = nearest(head[role], names)
            cause = f'got "{head[role]}"' + (f', nearest is "{near}"' if near else "")
            raise CampaignError(path, f"study.{role}", cause, "a setting: " + ", ".join(names))


def section_of(path: Path, where: str, content: Any) -> Mapping[str, Any]:
    """Return the content of a section or an entry.

    Raises:
        CampaignError: it is something else.
    """
    if not isinstance(content, Mapping):
        raise CampaignError(path, where, f"got {content!r:.60}", "keys, a line each")
    return content
