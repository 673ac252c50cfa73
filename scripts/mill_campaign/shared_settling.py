"""Settled beds that several cases share: DIR/settled/<key>/, by what decides the settling.

A mill at rest knows of the similarity law only its gravity and its size, so a bed serves every
scheme and policy that agrees in those. The folder holds copies: it may be deleted at any time.
"""

from __future__ import annotations

import hashlib
import json
import re
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from mill_campaign.charge import FILE as CHARGE_FILE
from mill_campaign.decks import PARAMETERS_FILE, with_included
from mill_campaign.folder_lock import hold
from mill_campaign.parameters import LINER_FILE, parameters, parameters_text
from mill_runs.layout import CAMPAIGN_FILE, CASES_FOLDER

FOLDER = "settled"
DECK = "settle.in"
# Says how the mill turns. At rest nothing of it matters but gravity and radius.
DRIVE_DECK = "mill_drive.in"
# When it prints a line and writes a restart file.
OUTPUT = {"thermo_steps", "restart_steps"}
_USED = re.compile(r"\$\{(\w+)\}|\bv_(\w+)")


def settling_key(case: Mapping[str, Any], folder: Path) -> str | None:
    """Hash of what decides how a charge settles; None if parameters.in was edited by hand.

    Args:
        case: content of case.json.
        folder: case folder, with decks, charge.data and liner.stl.
    """
    if (folder / PARAMETERS_FILE).read_text() != parameters_text(case):
        return None
    decks = {name: (folder / name).read_text() for name in with_included((DECK,), folder)}
    used = {
        name
        for deck, text in decks.items()
        if deck != DRIVE_DECK
        for match in _USED.findall(text)
        for name in match
    }
    values = {k: v for k, v in parameters(case).items() if k in used and k not in OUTPUT}
    files = [CHARGE_FILE, *([LINER_FILE] if case["wall"]["kind"] == "mesh" else [])]
    content = {
        "decks": decks,
        "values": values,
        "gravity_m_s2": case["mill"]["gravity_m_s2"],
        "radius_m": case["mill"]["radius_m"],
        "files": {x: hashlib.sha256((folder / x).read_bytes()).hexdigest() for x in files},
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


@contextmanager
def shared_bed(case: Mapping[str, Any], folder: Path) -> Iterator[Path | None]:
    """The shared folder of a case's bed, held by this process; None where there is none to share.

    Another case that settles the same bed is waited for.
    """
    runs = folder.resolve().parent.parent
    in_campaign = folder.resolve().parent.name == CASES_FOLDER and (runs / CAMPAIGN_FILE).exists()
    key = settling_key(case, folder) if in_campaign else None
    if key is None:
        yield None
        return
    shared = runs / FOLDER / key[:16]
    with hold(shared, wait=True):
        yield shared


def take(shared: Path, part: Path, products: tuple[str, ...]) -> bool:
    """Copy a bed out of its shared folder; False if it is not there yet."""
    if not all((shared / name).exists() for name in products):
        return False
    _copy(shared, part, products)
    return True


def give(shared: Path, part: Path, products: tuple[str, ...]) -> None:
    """Copy a bed into its shared folder; the last product, which completes it, comes last."""
    _copy(part, shared, products)


def _copy(source: Path, destination: Path, products: tuple[str, ...]) -> None:
    for name in products:
        copy = destination / f"{name}.part"
        shutil.copyfile(source / name, copy)
        copy.replace(destination / name)
