"""Number of inputs tried for a strategy, and the errors a reader may raise."""

import shutil
import warnings

import pytest
from attempts import Tally, attempt
from hypothesis import HealthCheck, given, settings

from millscale.errors import CampaignError
from millscale.runs.untrusted import RunFolderError

FULL, FEW = 1000, 40
REFUSALS = (CampaignError, RunFolderError, OSError)
NUMBERS = [pytest.param(FEW, id="few"), pytest.param(FULL, id="full", marks=pytest.mark.validate)]


def run(tallies, name, number, strategy, act, folder, refusals=REFUSALS):
    """Try `number` inputs of a strategy."""
    tally = Tally()

    @settings(
        max_examples=number, deadline=None, database=None, derandomize=True,
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    @given(strategy)
    def each(data):
        inside = folder / "inside"
        shutil.rmtree(inside, ignore_errors=True)
        inside.mkdir()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            attempt(tally, inside, data, lambda: act(inside, data), refusals)

    each()
    tallies[name] = tally
    if tally.faults:
        pytest.fail(f"{len(tally.faults)} faults, the first:\n{tally.faults[0]}", pytrace=False)
    # Hypothesis tries some inputs once only, however often they come.
    assert tally.inputs_tried >= 0.9 * number
