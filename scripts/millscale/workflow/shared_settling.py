"""Settled beds that several cases share, in DIR/settled/KEY/.

Only gravity and size of the similarity law act on a mill at rest, so all schemes and policies with
the same values share a bed. The folder holds copies and can be deleted at any time.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from millscale.cases.decks import PARAMETERS_FILE, deck_text, with_included
from millscale.cases.parameters import LINER_FILE, parameters, parameters_text
from millscale.engine.restart_file import NotWholeError, read_restart
from millscale.packing.charge import FILE as CHARGE_FILE
from millscale.runs.case_file import Case
from millscale.runs.digests import digest_of, json_digest
from millscale.runs.layout import CAMPAIGN_FILE, CASES_FOLDER, PROFILE_FILE
from millscale.runs.lock import hold
from millscale.runs.provenance import PROVENANCE_FILE, read_provenance, write_provenance
from millscale.runs.writing import write_copy

FOLDER = "settled"
STAGE = "settle"
_KEY_DIGITS = 16
DECK = "settle.in"
# The deck of the rotation. At rest only its gravity and radius act.
DRIVE_DECK = "mill_drive.in"
# Intervals of output, which change no result.
OUTPUT = {"thermo_steps", "restart_steps"}
_USED = re.compile(r"\$\{(\w+)\}|\bv_(\w+)")


def settling_key(case: Case, folder: Path) -> str | None:
    """Return a hash of all that decides how a charge settles; None if parameters.in was edited.

    Args:
        folder: case folder, with decks, charge.data and liner.stl.
    """
    if deck_text(folder / PARAMETERS_FILE) != parameters_text(case):
        return None
    decks = {name: deck_text(folder / name) for name in with_included((DECK,), folder)}
    used = {
        name
        for deck, text in decks.items()
        if deck != DRIVE_DECK
        for match in _USED.findall(text)
        for name in match
    }
    values = {k: v for k, v in parameters(case).items() if k in used and k not in OUTPUT}
    files = [CHARGE_FILE, *([LINER_FILE] if case.wall.kind == "mesh" else [])]
    files += [PROFILE_FILE] if case.mill.profile else []
    content = {
        "decks": decks,
        "values": values,
        "gravity_m_s2": case.mill.gravity_m_s2,
        "radius_m": case.mill.radius_m,
        "liner": parameters(case)["liner_shape"],
        "files": {x: digest_of(folder / x) for x in files},
    }
    return json_digest(content)


@dataclass(frozen=True)
class SharedBed:
    """The shared folder of a bed, and its key."""

    folder: Path
    key: str


@contextmanager
def shared_bed(case: Case, folder: Path) -> Iterator[SharedBed | None]:
    """Yield the locked shared folder of a case's bed; None if the bed cannot be shared.

    If another case settles the same bed, wait for it.
    """
    runs = folder.resolve().parent.parent
    in_campaign = folder.resolve().parent.name == CASES_FOLDER and (runs / CAMPAIGN_FILE).exists()
    key = settling_key(case, folder) if in_campaign else None
    if key is None:
        yield None
        return
    bed = SharedBed(runs / FOLDER / key[:_KEY_DIGITS], key)
    with hold(bed.folder, wait=True):
        yield bed


def take(bed: SharedBed, part: Path, products: tuple[str, ...]) -> bool:
    """Copy a bed out of its shared folder; return false if there is none.

    A bed that does not match its digests is deleted, and the reason is printed.
    """
    names = (*products, PROVENANCE_FILE)
    if not any((bed.folder / name).exists() for name in names):
        return False
    if problem := why_unusable(bed.folder, products, bed.key):
        print(f"bed not taken from {bed.folder}: {problem}", flush=True)
        for name in names:
            (bed.folder / name).unlink(missing_ok=True)
        return False
    for name in products:
        write_copy(bed.folder / name, part / name)
    return True


def give(
    bed: SharedBed, part: Path, products: tuple[str, ...], provenance: Mapping[str, Any]
) -> None:
    """Copy a bed into its shared folder; provenance.json, which completes it, comes last.

    Args:
        provenance: record of the stage, with digests of the products.
    """
    for name in products:
        write_copy(part / name, bed.folder / name)
    write_provenance(bed.folder, {STAGE: {**provenance, "key": bed.key}})


def why_unusable(folder: Path, products: tuple[str, ...], key: str = "") -> str:
    """Return why a shared bed cannot be used; empty if it can.

    Args:
        key: of the bed; empty for any key that fits the name of the folder.
    """
    record = read_provenance(folder).get(STAGE)
    if record is None:
        return f"{PROVENANCE_FILE} has no record of it"
    recorded = record.get("key")
    if not isinstance(recorded, str) or recorded[:_KEY_DIGITS] != folder.name:
        return "it was settled for another key"
    if key and recorded != key:
        return "it was settled from other inputs"
    for name in products:
        if not (folder / name).is_file():
            return f"{name} is missing"
        if digest_of(folder / name) != record["products"].get(name):
            return f"{name} does not match its digest"
    try:
        read_restart(folder / products[0])
    except (NotWholeError, OSError) as error:
        return str(error)
    return ""
