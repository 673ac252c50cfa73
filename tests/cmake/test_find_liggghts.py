"""cmake/FindLIGGGHTS.cmake on small stand-ins for a LIGGGHTS prefix and a source tree."""

import shutil
import subprocess
from pathlib import Path

import pytest

MODULES = Path(__file__).parents[2] / "cmake"
PROJECT = f"""\
cmake_minimum_required(VERSION 3.25)
project(test LANGUAGES CXX)
list(APPEND CMAKE_MODULE_PATH "{MODULES}")
find_package(MPI REQUIRED COMPONENTS CXX)
find_package(LIGGGHTS REQUIRED)
message(STATUS "library: ${{LIGGGHTS_LIBRARY}}")
message(STATUS "headers: ${{LIGGGHTS_INCLUDE_DIR}}")
"""
HEADER = """\
#include <mpi.h>
namespace LAMMPS_NS {
struct LAMMPS { LAMMPS(int narg, char** arg, MPI_Comm world); };
struct AtomVecSuperquadric { void grow(); };
}
"""
CONSTRUCTOR = '#include "lammps.h"\nLAMMPS_NS::LAMMPS::LAMMPS(int, char**, MPI_Comm) {}\n'
SUPERQUADRIC = CONSTRUCTOR + "void LAMMPS_NS::AtomVecSuperquadric::grow() {}\n"
# As of a library that was built with another MPI: its communicators are of another type.
OTHER_MPI = """\
namespace LAMMPS_NS {
struct LAMMPS { LAMMPS(int narg, char** arg, int world); };
LAMMPS::LAMMPS(int, char**, int) {}
}
"""

pytestmark = pytest.mark.skipif(
    not (shutil.which("cmake") and shutil.which("mpicxx")), reason="no cmake or no mpicxx"
)


def tree(folder, headers="src", libraries="src", source=CONSTRUCTOR):
    """Make a prefix or a source tree; without libraries if `libraries` is None."""
    (folder / headers).mkdir(parents=True)
    (folder / headers / "lammps.h").write_text(HEADER)
    if libraries:
        (folder / libraries).mkdir(parents=True, exist_ok=True)
        code = folder / "lammps.cpp"
        code.write_text(source)
        library = folder / libraries / "libliggghts.so"
        include = f"-I{folder / headers}"
        subprocess.run(["mpicxx", "-shared", "-fPIC", include, code, "-o", library], check=True)
    return folder


@pytest.fixture
def configure(tmp_path):
    (tmp_path / "project").mkdir()
    (tmp_path / "project" / "CMakeLists.txt").write_text(PROJECT)

    def run(root):
        folders = ["-S", tmp_path / "project", "-B", tmp_path / "build"]
        line = ["cmake", *folders, f"-DLIGGGHTS_ROOT={root}"]
        done = subprocess.run(line, capture_output=True, text=True)
        return done.returncode, " ".join((done.stdout + done.stderr).split())

    return run


def test_a_prefix_and_a_source_tree_are_found_and_nothing_else_is_searched(configure, tmp_path):
    for headers, libraries in [("src", "src"), ("include/liggghts", "lib")]:
        root = tree(tmp_path / headers / libraries, headers, libraries)
        # In one build folder: the cache names what was found before.
        code, output = configure(root)
        assert code == 0, output
        assert f"library: {root / libraries / 'libliggghts.so'}" in output
        assert f"headers: {root / headers} " in output


def test_the_error_states_what_is_wrong_with_a_root(configure, tmp_path):
    code, output = configure(tmp_path)
    assert code and f"LIGGGHTS_ROOT={tmp_path} has no src/lammps.h" in output
    # Debian's library, if it is there, does not fit these headers.
    code, output = configure(tree(tmp_path / "unbuilt", libraries=None))
    assert code and "has headers and no libliggghts.so in src or lib" in output


@pytest.mark.parametrize(
    ("source", "problem"),
    [(SUPERQUADRIC, "superquadric particles: build it with"), (OTHER_MPI, "does not link. Was it")],
)
def test_a_library_that_does_not_fit_is_refused(configure, tmp_path, source, problem):
    root = tree(tmp_path / "root", source=source)
    code, output = configure(root)
    assert code and problem in output, output
    # Once it is built as it should be, the same build folder accepts it.
    shutil.rmtree(root)
    code, output = configure(tree(root))
    assert code == 0, output
