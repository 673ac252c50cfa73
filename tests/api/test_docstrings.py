"""The examples in the docstrings of the Python interface run and give what they show."""

import doctest
import re
import shutil
from importlib import import_module
from pathlib import Path

import pytest

import millscale.api
from millscale.api.case_folder import CaseFolder
from millscale.api.comparing import Comparison
from millscale.api.curtain_profiles import CurtainProfiles
from millscale.api.planning import Plan
from millscale.api.runs_folder import RunsFolder
from millscale.api.scaling import ScaledMill
from paper_campaign import REPOSITORY

MODULES = sorted(path.stem for path in Path(millscale.api.__path__[0]).glob("[!_]*.py"))
CASE = "mb-cg-paper-S2.600-fixed-seed1"


@pytest.mark.parametrize("name", MODULES)
def test_examples_of_a_module_run(name, throws, tmp_path):
    module = import_module(f"millscale.api.{name}")
    runs = RunsFolder(throws)
    found = {"runs": runs, "case": runs[CASE], "new_folder": tmp_path / "new"}
    if name == "comparing":
        found["other"] = RunsFolder(shutil.copytree(throws, tmp_path / "other"))
    failed, _ = doctest.testmod(module, extraglobs=found, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert failed == 0


def test_every_function_has_an_example_or_needs_the_engine():
    """Other tests run `run`, and `predict` and `advise`, which need mills of several S."""
    for name, module in millscale._API.items():
        function = getattr(import_module(f"millscale.api.{module}"), name)
        assert function.__doc__
        if name not in ("run", "predict", "advise"):
            assert ">>> " in function.__doc__, name


def test_properties_state_their_unit_or_meaning():
    for kind in (RunsFolder, CaseFolder, Comparison):
        for name, member in vars(kind).items():
            if not name.startswith("_"):
                assert getattr(member, "__doc__", None), f"{kind.__name__}.{name}"


def test_the_reference_lists_functions_and_members():
    text = (REPOSITORY / "docs/reference/api.md").read_text(encoding="utf-8")
    for name in millscale._API:
        assert f"`ms.{name}(" in text
    kinds = (RunsFolder, CaseFolder, Comparison, CurtainProfiles, Plan, ScaledMill)
    names = {name for kind in kinds for name in vars(kind) if not name.startswith("_")}
    missing = [name for name in names if not re.search(rf"[`.]{name}\b", text)]
    assert names and not missing
