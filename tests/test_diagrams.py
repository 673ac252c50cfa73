"""The diagrams of the documentation are those that their program draws."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "docs/diagrams"


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    spec = importlib.util.spec_from_file_location("draw", FOLDER / "draw.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    folder = tmp_path_factory.mktemp("diagrams")
    module.draw(folder)
    return folder


@pytest.mark.parametrize("file", sorted(FOLDER.glob("*.svg")), ids=lambda file: file.stem)
def test_a_diagram_is_the_one_that_its_program_draws(drawn, file):
    assert (drawn / file.name).read_text() == file.read_text(), "run docs/diagrams/draw.py"
