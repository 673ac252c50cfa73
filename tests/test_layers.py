"""The rule of who may know whom, for both languages (ARCHITECTURE.md)."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from importlib import import_module
from pathlib import Path

import pytest

import millscale

ROOT = Path(__file__).parents[1]

# Packages of millscale from top to bottom. A package imports those of lower rows only.
PYTHON = (
    ("__main__",),
    ("cli", "api"),
    ("validate", "bench"),
    ("calibration",),
    ("study", "prediction"),
    ("workflow",),
    ("report", "exports"),
    ("cases", "analysis"),
    ("engine", "packing"),
    ("campaign", "power_models", "breakage"),
    ("liner",),
    ("runs",),
    ("mesh", "errors"),
    ("formats", "terminal", "_core"),
)
# Folders of liggghts_ext/core from the bottom up. A folder includes those above it in this list.
CORE = (
    "math",
    "similarity",
    "liner",
    "mesh",
    "contact",
    "energy",
    "neighbor",
    "kernels",
    "measure",
)
# Folders of liggghts_ext, and what each may include besides itself.
CPP = {"core": set(), "liggghts": {"core"}, "python": {"core"}}
# Headers of the engine and of MPI have no place in the core.
ENGINE_HEADERS = re.compile(
    r"mpi\.h|lammps\.h|(fix|compute|pair|atom|update|force|modify|comm)(_\w+)?\.h"
)
# The driver starts the engine; nothing else knows it.
DRIVER = "liggghts_ext/liggghts/driver/"


def python_sources() -> Iterator[tuple[str, Path]]:
    """Yield the dotted name and the path of each module."""
    for folder, package in (
        ("scripts/millscale", "millscale"),
        ("meshes/mesh", "millscale.mesh"),
        ("analysis", "millscale.analysis"),
    ):
        for path in sorted((ROOT / folder).rglob("*.py")):
            parts = path.relative_to(ROOT / folder).with_suffix("").parts
            # Decks of other engines, which run without this package.
            if "decks" in parts:
                continue
            name = ".".join((package, *(part for part in parts if part != "__init__")))
            yield name.replace("millscale.analysis.report", "millscale.report"), path


SOURCES = dict(python_sources())


def imported(text: str) -> Iterator[str]:
    """Yield the modules of millscale that a source imports, at its top or inside a function."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (x.name for x in node.names if x.name.startswith("millscale."))
        elif isinstance(node, ast.ImportFrom) and node.module:
            assert node.level == 0, "imports are absolute"
            if node.module == "millscale":
                yield from (f"millscale.{x.name}" for x in node.names if x.name != "__version__")
            elif node.module.startswith("millscale."):
                modules = {f"{node.module}.{x.name}" for x in node.names} & SOURCES.keys()
                yield from modules or {node.module}


IMPORTS = {
    name: {x for x in imported(path.read_text(encoding="utf-8")) if x in SOURCES}
    for name, path in SOURCES.items()
}


def upward(name: str, text: str) -> list[str]:
    """Return the imports of a module that the rule forbids."""
    row = {package: i for i, packages in enumerate(PYTHON) for package in packages}
    own = name.split(".")[1] if "." in name else None
    if own is None:
        return list(imported(text))
    return [
        f"{name} imports {other}"
        for other in imported(text)
        if other.split(".")[1] != own and row[other.split(".")[1]] <= row[own]
    ]


@pytest.mark.parametrize("name", SOURCES)
def test_a_module_imports_lower_packages_only(name):
    assert upward(name, SOURCES[name].read_text(encoding="utf-8")) == []


def test_the_package_names_nothing_but_the_interface():
    """`millscale` itself lies below all others, and yet names functions of `api`: by their names
    alone, imported on first use."""
    for name, module in millscale._API.items():
        assert getattr(import_module(f"millscale.api.{module}"), name) is getattr(millscale, name)
    assert not list(imported(SOURCES["millscale"].read_text(encoding="utf-8")))
    # An imported package would take the place of a function of its name.
    assert not {name.split(".")[1] for name in SOURCES if "." in name} & millscale._API.keys()


def test_no_modules_import_one_another_in_a_circle():
    assert circle(IMPORTS) == []


def parts_of(package: str, graph: dict[str, set[str]]) -> dict[str, set[str]]:
    """Return the imports between the parts of a package, modules and sub-packages alike.

    Args:
        graph: modules that each module imports.
    """
    begin = f"{package}."

    def part(name: str) -> str:
        return begin + name.removeprefix(begin).split(".")[0]

    found: dict[str, set[str]] = {}
    for name, others in graph.items():
        if name.startswith(begin):
            inside = {part(other) for other in others if other.startswith(begin)}
            found.setdefault(part(name), set()).update(inside - {part(name)})
    return found


def circle(graph: dict[str, set[str]]) -> list[str]:
    """Return parts that import one another in a circle; empty if there are none."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return error.args[1]
    return []


PACKAGES = sorted({name.rpartition(".")[0] for name in SOURCES if name.count(".") > 1})


@pytest.mark.parametrize("package", PACKAGES)
def test_no_parts_of_a_package_import_one_another_in_a_circle(package):
    assert circle(parts_of(package, IMPORTS)) == []


def test_a_circle_between_sub_packages_is_found():
    graph = {
        "millscale.analysis.charge.rows": {"millscale.analysis.shapes.shape"},
        "millscale.analysis.shapes.contour": {"millscale.analysis.charge.steady"},
        "millscale.analysis.shapes.shape": set(),
        "millscale.analysis.charge.steady": set(),
    }
    assert circle(graph) == []
    assert circle(parts_of("millscale.analysis", graph)) != []


@pytest.mark.parametrize("name", SOURCES)
def test_a_file_does_not_repeat_the_name_of_its_folder(name):
    folder, _, file = name.rpartition(".")
    assert not file.startswith(f"{folder.rpartition('.')[2]}_")


def test_an_import_upwards_is_found():
    text = "def f():\n    from millscale.workflow.plan import x\n"
    assert upward("millscale.cases.case", text) == [
        "millscale.cases.case imports millscale.workflow.plan"
    ]
    assert upward("millscale.analysis.case", "import millscale.cases.case\n") != []
    assert upward("millscale.analysis.case", "import millscale.runs.series\n") == []


INCLUDE = re.compile(r'^\s*#\s*include\s+["<]([^">]+)[">]', re.M)


def forbidden(path: str, text: str) -> list[str]:
    """Return the includes of a C++ source, path relative to the root, that the rule forbids."""
    own = path.removeprefix("liggghts_ext/").split("/")
    found = []
    for header in INCLUDE.findall(text):
        other = header.split("/")
        wrong = own[0] == "core" and bool(ENGINE_HEADERS.fullmatch(header))
        if other[0] in CPP:
            wrong |= other[0] != own[0] and other[0] not in CPP[own[0]]
            wrong |= header.startswith("liggghts/driver/") and not path.startswith(DRIVER)
            if own[0] == other[0] == "core":
                wrong |= CORE.index(other[1]) > CORE.index(own[1])
        if wrong:
            found.append(f"{path} includes {header}")
    return found


CPP_SOURCES = [
    str(path.relative_to(ROOT))
    for pattern in ("*.h", "*.cpp")
    for path in sorted((ROOT / "liggghts_ext").rglob(pattern))
]


@pytest.mark.parametrize("path", CPP_SOURCES)
def test_a_header_knows_those_above_it_only(path):
    assert path.split("/")[1] in CPP
    assert forbidden(path, (ROOT / path).read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    ("path", "header"),
    [
        ("liggghts_ext/core/math/vector.h", "core/contact/material.h"),
        ("liggghts_ext/core/contact/material.h", "liggghts/common/x.h"),
        ("liggghts_ext/core/contact/material.h", "mpi.h"),
        ("liggghts_ext/core/contact/material.h", "fix_mesh_surface.h"),
        ("liggghts_ext/python/bind.cpp", "liggghts/common/x.h"),
        ("liggghts_ext/liggghts/mill/x.cpp", "liggghts/driver/main.h"),
    ],
)
def test_an_include_against_the_rule_is_found(path, header):
    assert forbidden(path, f'#include "{header}"\n') == [f"{path} includes {header}"]
    assert forbidden(path, "#include <vector>\n") == []
