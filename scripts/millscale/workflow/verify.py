"""`millscale verify`: compare the files of a runs folder with their digests, campaign and version.

Products, decks, inputs and shared beds are compared with the digests in provenance.json. If this
version wrote the decks of a case, its case.json is compared with the campaign too, parameters.in
with case.json, and the decks with the templates. The comparison finds damage and mix-ups, not
forgery: digests can be written too.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.cases.decks import MOST_DECK_BYTES, PARAMETERS_FILE, template_folder
from millscale.cases.generate import CAMPAIGN_COPY, read_summary
from millscale.cases.parameters import parameters_text
from millscale.engine.code_version import code
from millscale.errors import CampaignError
from millscale.formats import counted
from millscale.runs.case_digest import MISSING, differing_keys
from millscale.runs.case_file import Case, is_outdated, load_case
from millscale.runs.digests import digest_of, files_of
from millscale.runs.layout import CASE_FILE, CASES_FOLDER, STAGES, stage_of
from millscale.runs.provenance import read_provenance
from millscale.runs.untrusted import RunFolderError, read_bytes
from millscale.terminal import one_line
from millscale.workflow.by_hand import is_there
from millscale.workflow.shared_settling import FOLDER, STAGE, why_unusable

_MOST_KEYS = 3


@dataclass(frozen=True)
class Difference:
    """A file that differs from what it should be; `case` is empty for files of the campaign."""

    case: str
    file: str
    what: str

    def __str__(self) -> str:
        return one_line(f"{f'{self.case}/' if self.case else ''}{self.file}: {self.what}")


@dataclass(frozen=True)
class Verified:
    """The outcome for a runs folder; `note` states what was compared with digests only."""

    cases: int
    files: int
    differences: tuple[Difference, ...]
    note: str = ""


def verify(runs: Path) -> Verified:
    """Compare every file of a runs folder that has a digest or can be derived.

    Raises:
        CampaignError: the folder holds no generated campaign.
    """
    summary = read_summary(runs)
    derived, found = _derived(runs, summary)
    files, versions = 0, []
    for case_id in summary["cases"]:
        folder = runs / CASES_FOLDER / case_id
        versions.append(_other_version(folder))
        seen = list(_case(folder, summary, derived))
        files += len(seen)
        found += [x for x in seen if x.what]
    beds = list(_beds(runs))
    found += [x for x in beds if x.what]
    return Verified(len(summary["cases"]), files + len(beds), tuple(found), _note(versions))


def _other_version(folder: Path) -> str:
    """Return the version that wrote the decks of a case; empty if this one did, or none did."""
    record = read_provenance(folder).get("deck")
    if record is None:
        return ""
    version, commit = record.get("millscale"), record.get("commit")
    if (version, commit) == (code()["millscale"], code()["commit"]):
        return ""
    return f"millscale {version!s:.20} ({f'commit {commit!s:.12}' if commit else 'no commit'})"


def _note(versions: list[str]) -> str:
    other = [version for version in versions if version]
    if not other:
        return ""
    more = len(set(other)) - 1
    makers = other[0] + f" and {counted(more, 'other version')}" * (more > 0)
    what = "case.json and decks are compared with their digests only"
    return one_line(f"{counted(len(other), 'case')} made by {makers}: {what}")


def _beds(runs: Path) -> Iterator[Difference]:
    """Yield the settled beds that cases share."""
    stage = stage_of("multi-ball", STAGE)
    for folder in sorted((runs / FOLDER).glob("*")):
        name = f"{FOLDER}/{folder.name}/{stage.products[0]}"
        yield Difference("", name, why_unusable(folder, stage.products))


def _derived(
    runs: Path, summary: Mapping[str, Any]
) -> tuple[dict[str, Case] | None, list[Difference]]:
    """Return the cases of the campaign's copy, by id, or None and the reason."""
    copy = runs / CAMPAIGN_COPY
    if not copy.exists():
        return None, [Difference("", CAMPAIGN_COPY, "missing: case.json cannot be derived")]
    try:
        campaign = replace(load_campaign(copy), name=summary["name"])
        cases = {case.id: case for case in cases_of(campaign)}
    except CampaignError as error:
        return None, [Difference("", CAMPAIGN_COPY, error.cause)]
    found = []
    if lost := sorted(set(cases) ^ set(summary["cases"])):
        what = f"names other cases than campaign.json: {', '.join(lost[:_MOST_KEYS])}"
        found.append(Difference("", CAMPAIGN_COPY, what))
    if summary.get("copy") not in (None, digest_of(copy, follow=True)):
        found.append(Difference("", CAMPAIGN_COPY, "changed since campaign.json was written"))
    return cases, found


def _case(
    folder: Path, summary: Mapping[str, Any], derived: Mapping[str, Case] | None
) -> Iterator[Difference]:
    """Yield every file of a case that was compared; `what` is empty if it does not differ."""
    case_id = folder.name
    try:
        case = load_case(folder)
    except RunFolderError as error:
        yield Difference(case_id, CASE_FILE, error.cause)
        return
    what = ""
    if _other_version(folder):
        what = "is not the one that campaign.json records" if is_outdated(summary, case) else ""
    elif derived is not None and case_id in derived:
        what = _from_campaign(derived[case_id], case)
    yield Difference(case_id, CASE_FILE, what)
    yield from _products(folder, case)
    yield from _decks(folder, case)


def _from_campaign(derived: Case, found: Case) -> str:
    """Return in which keys a case differs from the campaign; empty if it does not."""
    keys = [_pair(*difference) for difference in differing_keys(derived.document, found.document)]
    if not keys:
        return ""
    more = len(keys) - _MOST_KEYS
    return f"differs from the campaign in {', '.join(keys[:_MOST_KEYS])}" + (
        f" and {more} more" * (more > 0)
    )


def _pair(path: str, wanted: Any, found: Any) -> str:
    if MISSING in (wanted, found):
        return f"{path} ({'missing' if found is MISSING else 'unknown'})"
    return f"{path} (campaign {_short(wanted)}, file {_short(found)})"


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


def _products(folder: Path, case: Case) -> Iterator[Difference]:
    recorded = read_provenance(folder)
    for stage in STAGES.get(case.kind, ()):
        made = recorded.get(stage.name)
        if made is None:
            there = [x for x in stage.products if (folder / x).exists()]
            if there:
                what = f"stage {stage.name} has no provenance"
                if is_there(folder, stage):
                    what = "made by hand: millscale run or report checks it and takes it over"
                yield Difference(folder.name, there[0], what)
            continue
        for name, digest in made["products"].items():
            yield Difference(folder.name, name, _compared(folder, name, digest))
        for name, digest in made["inputs"].items():
            if name == CASE_FILE and made.get("case") == case.digest:
                continue
            if _found(folder, recorded, name) not in (None, digest):
                what = f"stage {stage.name} has read another {name}"
                yield Difference(folder.name, stage.products[-1], what)


def _found(folder: Path, recorded: Mapping[str, Any], name: str) -> str | None:
    """Return the digest of an input: the recorded one of a product, which its own stage compares
    with the file, or that of the file itself, such as a deck, which may be edited."""
    made = next((x["products"][name] for x in recorded.values() if name in x["products"]), None)
    if made and not name.endswith(".in"):
        return made
    return digest_of(folder / name) if (folder / name).is_file() else made


def _compared(folder: Path, name: str, digest: str) -> str:
    if not any(True for _ in files_of(folder, [name])):
        return "missing, or no regular file"
    try:
        found = digest_of(folder / name)
    except OSError as error:
        return f"cannot be read: {error.strerror}"
    return "" if found == digest else f"SHA-256 is {found[:12]}..., recorded {digest[:12]}..."


def _decks(folder: Path, case: Case) -> Iterator[Difference]:
    """Yield the decks, which are programs of the engine, that this version would not write so.

    Templates are compared without comment lines. The decks of another version are only compared
    with their digests, as products of stage deck; a deck without a digest is a difference.
    """
    templates = template_folder()
    recorded = read_provenance(folder).get("deck", {"products": {}})["products"]
    of_other_version = _other_version(folder)
    for name in files_of(folder, (x.name for x in folder.glob("*.in"))):
        deck = folder / name
        if of_other_version:
            if name not in recorded:
                yield Difference(folder.name, name, "no digest recorded: not made by stage deck")
            continue
        if deck.name == PARAMETERS_FILE:
            same = _bytes(deck) == parameters_text(case).encode()
            yield Difference(folder.name, deck.name, "" if same else "not what case.json says")
            continue
        template = templates / deck.name
        same = template.exists() and _commands(template.read_bytes()) == _commands(_bytes(deck))
        what = "" if same else "not the deck of this version: edited by hand, or of another version"
        yield Difference(folder.name, deck.name, what)


def _commands(deck: bytes | None) -> list[bytes] | None:
    """Return the lines of a deck without comment lines."""
    if deck is None:
        return None
    return [line for line in deck.splitlines() if not line.startswith(b"#")]


def _bytes(deck: Path) -> bytes | None:
    try:
        return read_bytes(deck, MOST_DECK_BYTES, "")
    except RunFolderError:
        return None
