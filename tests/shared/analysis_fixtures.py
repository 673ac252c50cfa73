"""Synthetic run folders, made once for all tests that only read them."""

from pathlib import Path

import pytest

from synthetic_ball import usual_motion
from synthetic_case import (
    MODELS,
    POLICIES,
    SCHEMES,
    case_document,
    finish_case,
    write_campaign,
    write_case,
)
from synthetic_charge import write_charge
from synthetic_throw import write_throws


@pytest.fixture
def case() -> dict:
    """Return case.json of the physical mill with a single ball."""
    return case_document("single-ball", "constant-gravity", "paper", 1.0)


@pytest.fixture
def folder(case, tmp_path) -> Path:
    """Return its case folder, whose engine stage is done."""
    return write_case(tmp_path, case, usual_motion(case).series())


@pytest.fixture(scope="session")
def runs(tmp_path_factory) -> Path:
    """Return a finished campaign: three S, two schemes, three policies, two charges. Read only."""
    runs = tmp_path_factory.mktemp("runs")
    folders = []
    for scheme in SCHEMES:
        for policy in POLICIES:
            for S in MODELS:
                case = case_document("single-ball", scheme, policy, S, sample_angle=0.02)
                folders.append(write_case(runs, case, usual_motion(case).series()))
        folders.append(write_charge(runs, scheme))
    for folder in folders:
        finish_case(folder)
    write_campaign(runs, [folder.name for folder in folders])
    return runs


@pytest.fixture(scope="session")
def classes(tmp_path_factory) -> Path:
    """Return a finished campaign of a charge of three classes and one of equal balls. Read only."""
    runs = tmp_path_factory.mktemp("classes")
    folders = [
        write_charge(runs, "constant-gravity", radii=(0.1, 0.04, 0.06)),
        write_charge(runs, "constant-speed"),
    ]
    for folder in folders:
        finish_case(folder)
    write_campaign(runs, [folder.name for folder in folders])
    return runs


@pytest.fixture(scope="session")
def throws(tmp_path_factory) -> Path:
    """Return a finished campaign of four charges with curtains. Read only."""
    return write_throws(tmp_path_factory.mktemp("throws"))
