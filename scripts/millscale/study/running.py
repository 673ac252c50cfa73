"""Runs settings: the cases that are finished nowhere, one setting after the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rich.console import Console

from millscale.engine.machine import CoreWish
from millscale.formats import counted, duration
from millscale.study.file import Setting
from millscale.study.folders import Places, found_cases, write_setting
from millscale.workflow.placement import campaign_time
from millscale.workflow.run_command import Request, check_free_disk, request, run_campaign


@dataclass(frozen=True)
class RunOptions:
    """How settings are run.

    Attributes:
        noun: what a setting is called on the console.
    """

    cores: CoreWish
    ignore_disk: bool
    console: Console
    noun: str = "setting"


def run_settings(
    settings: Sequence[Setting], chosen: Sequence[Setting], places: Places, how: RunOptions
) -> bool:
    """Run the cases of some settings that are not finished anywhere; return whether all have
    results.

    A case that fails does not stop the others.

    Args:
        settings: every setting of the runs folder.
        chosen: those to run.
    """
    done = True
    for number, setting in enumerate(chosen, 1):
        # Searched before each setting: an earlier one may have run the same case.
        asked = _request(settings, setting, places, how.cores)
        title = f"{how.noun} {number} of {len(chosen)}, {setting.name}"
        if asked is None:
            how.console.print(f"{title}: done", markup=False, highlight=False)
            continue
        time = duration(campaign_time(asked.cases, asked.allocation, asked.rates))
        text = f"{title}: {len(asked.cases)} of {counted(len(setting.cases), 'case')}, about {time}"
        how.console.print(text, markup=False, highlight=False)
        if not how.ignore_disk:
            check_free_disk(asked)
        done &= run_campaign(asked, how.console)
    return done


def _request(
    settings: Sequence[Setting], setting: Setting, places: Places, cores: CoreWish
) -> Request | None:
    """Return the request for the cases of a setting that still have to run; None if none have."""
    found = found_cases(settings, setting, places)
    left = [case.id for case in setting.cases if case.id not in found]
    file = write_setting(setting, places.of(setting))
    return request(file, places.of(setting), left, cores) if left else None
