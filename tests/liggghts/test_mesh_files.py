"""Meshes of hand-written decks: files the engine reads wrongly are refused before it reads them."""

import string
import struct

import numpy as np
import pytest

from millscale import _core
from scene import HEAD, material, run, write_liner

DRUM = _core.Lifters(0.5, 0.45, 0.05, 0.09, 14)
BOX = "region box block -0.6 0.6 0 0.2 -0.6 0.6 units box\ncreate_box 2 box\n"
WALL = "fix wall all wall/gran model hertz mesh n_meshes 1 meshes liner\nfix i all nve/sphere\n"
BALL = "create_atoms 1 single 0 0.1 0 units box\nset type 1 diameter 0.04 density 2678\n"
READ = "fix liner all mesh/surface file {} type 2\n"


def _deck(file, style="mesh/surface"):
    properties = material(0.1, 1e-4)
    return HEAD + BOX + properties + READ.format(file).replace("mesh/surface", style)


def _binary(text, header):
    """The triangles of a text STL as a binary one."""
    words = [line.split() for line in text.splitlines() if "vertex" in line]
    nodes = np.array([[float(x) for x in w[1:4]] for w in words], np.float32).reshape(-1, 9)
    rows = (struct.pack("<12fH", 0, 0, 0, *row, 0) for row in nodes)
    return header.ljust(80) + struct.pack("<I", len(nodes)) + b"".join(rows)


@pytest.fixture
def stl(tmp_path):
    write_liner(tmp_path, DRUM, 0.2, 1e-3)
    return (tmp_path / "liner.stl").read_text()


@pytest.mark.parametrize("style", ["mesh/surface", "mesh/surface/stress"])
@pytest.mark.parametrize("ranks", [1, 2])
def test_a_file_the_engine_reads_wrongly_is_refused(tmp_path, stl, style, ranks):
    files = {
        "solid.stl": (_binary(stl, b"solid liner"), "is binary with a header that begins with"),
        "upper.stl": (stl.upper().encode(), "is text in upper case (`SOLID`)"),
        "cut.stl": (stl[: int(0.6 * len(stl))].encode(), "is cut short: line "),
        "empty.STL": (b"", "is empty"),
    }
    for name, (content, cause) in files.items():
        (tmp_path / name).write_bytes(content)
        result = run(tmp_path, _deck(name, style), ranks)
        assert result.code != 0
        assert result.error.startswith(f"ERROR: Fix {style} (id liner): file '{name}' {cause}")
        assert "Reading STL" not in result.text


def test_what_the_messages_advise_makes_the_file_good(tmp_path, stl):
    (tmp_path / "binary.stl").write_bytes(_binary(stl, b"STL__ liner"))
    (tmp_path / "zeros.stl").write_bytes(_binary(stl, bytes(80)))
    upper = str.maketrans(string.ascii_uppercase, string.ascii_lowercase)
    (tmp_path / "lower.stl").write_text(stl.upper().translate(upper))
    triangles = stl.count("endfacet")
    for name in ("liner.stl", "binary.stl", "zeros.stl", "lower.stl"):
        result = run(tmp_path, _deck(name) + BALL + WALL + "run 0\n")
        assert result.code == 0
        assert f"containing {triangles} triangle(s) successful" in result.text
