"""Checks whether the products of a case are those of its case.json, by digests, not by dates.

A stage is done if provenance.json has its record, its products have the digests recorded there, and
so have its inputs. Decks may be edited by hand: the stage that wrote them stays done, the stages
that read them are to run again.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from millscale.runs.case_digest import case_digest
from millscale.runs.digests import Digests
from millscale.runs.layout import CASE_FILE, STAGES, Stage
from millscale.runs.provenance import read_provenance
from millscale.runs.untrusted import RunFolderError, read_object


def unfinished(folder: Path, kind: str, case_changed: bool = False) -> list[tuple[Stage, str]]:
    """Return the stages that have to run, in order, each with the reason.

    Args:
        folder: the case folder; need not exist.
        case_changed: take case.json as another one than every stage has read.
    """
    made, waiting = _Made(folder), []
    remade = {CASE_FILE} if case_changed else set()
    for stage in STAGES[kind]:
        reason = next((f"no {x}" for x in stage.products if made.digest(x) is None), "")
        reason = reason or next((f"new {x}" for x in stage.inputs if x in remade), "")
        if reason := reason or made.reason(stage):
            waiting.append((stage, reason))
            remade.update(stage.products)
    return waiting


def why_stale(folder: Path, kind: str, upto: str = "result") -> str:
    """Return why products were not made from this case.json; empty if they were.

    A product that was removed since, such as a large restart file, counts as it was recorded.

    Args:
        upto: the last stage whose products are to be used.
    """
    made = _Made(folder)
    for stage in STAGES[kind]:
        if reason := made.reason(stage):
            return reason
        if stage.name == upto:
            break
    return ""


def is_as_made(folder: Path, name: str) -> bool:
    """Return whether a file that accompanies the products of a stage, such as a dump, is the one
    that the stage made; true if nothing of its folder is recorded."""
    products = [record["products"] for record in read_provenance(folder).values()]
    digest = next((x[name] for x in products if name in x), None)
    if digest is None:
        inside = f"{name.rpartition('/')[0]}/"
        return not any(other.startswith(inside) for x in products for other in x)
    return bool(Digests(folder).of(name) == digest)


class _Made:
    """What was made in a case folder, and from what."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._digests = Digests(folder)
        self._stages = read_provenance(folder)

    def digest(self, name: str) -> str | None:
        """Return the digest of a file; None if it is not there."""
        return self._digests.of(name)

    def reason(self, stage: Stage) -> str:
        """Return why a stage is not done, as far as its files are there; empty if it is."""
        record = self._stages.get(stage.name)
        if record is None:
            return f"stage {stage.name} has no record in provenance.json"
        for name in stage.products:
            if name not in record["products"]:
                return f"provenance.json does not know {name}"
            edited = name.endswith(".in")
            if not edited and self.digest(name) not in (None, record["products"][name]):
                return f"{name} is not what stage {stage.name} made"
        unknown = next((x for x in stage.inputs if x not in record["inputs"]), None)
        if unknown:
            return f"provenance.json does not know from which {unknown} stage {stage.name} was made"
        for name, digest in record["inputs"].items():
            if digest != (self.digest(name) or self._recorded(name)) and not (
                name == CASE_FILE and self._is_case_of(record)
            ):
                return f"{name} has changed since stage {stage.name} read it"
        return ""

    def _recorded(self, name: str) -> str | None:
        """Return the digest of a file when it was made."""
        makers = (x["products"] for x in self._stages.values())
        return next((products[name] for products in makers if name in products), None)

    def _is_case_of(self, record: Mapping[str, Any]) -> bool:
        """Return whether case.json differs from the one that was read only in keys that inform."""
        try:
            case = read_object(self._folder / CASE_FILE, "")
        except RunFolderError:
            return False
        return case_digest(case) == record.get("case")
