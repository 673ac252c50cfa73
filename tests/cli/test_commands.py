"""Help, version, completion and start of the command line."""

import os
import subprocess
import sys

import pytest
import typer

from in_process import millscale
from millscale import __version__
from millscale.cli.main import app

# Libraries that take long to load: a command loads them when it needs them.
HEAVY = ("gmsh", "matplotlib", "numpy", "pyvista", "scipy", "snakemake", "vtk")


def commands(group, names=()):
    """Yield the names that make up each command below a group."""
    for name, command in group.commands.items():
        if hasattr(command, "commands"):
            yield from commands(command, (*names, name))
        else:
            yield (*names, name)


COMMANDS = list(commands(typer.main.get_command(app)))


def test_every_task_is_a_command():
    assert {" ".join(names) for names in COMMANDS} == {
        *("new", "schema", "plan", "generate", "run", "status", "verify", "report", "study"),
        *("open", "compare", "export"),
        *("predict", "advise", "solve", "calibrate", "wear", "breakage"),
        "bench output-cost",
        *(
            f"analyse {name}"
            for name in ("case", "pair", "groups", "campaigns", "variants", "pictures")
        ),
        *(
            f"validate {name}"
            for name in (
                "experiments",
                "impact-collapse",
                "friction-matched",
                "prediction",
                *("hard-cases", "energy", "time-step", "torque", "sampling"),
                *(
                    "liner-variants",
                    "fidelity",
                    "mixing",
                    "definitions",
                    "averaging",
                    "flowing-layer",
                ),
            )
        ),
    }


@pytest.mark.parametrize("names", [*COMMANDS, ("bench",)], ids=" ".join)
def test_help_of_every_command_has_an_example(names):
    done = millscale(*names, "--help")
    assert done.returncode == 0
    text = " ".join(done.stdout.split())
    assert f"Usage: millscale {' '.join(names)} " in text
    assert f": millscale {' '.join(names)} " in text.replace("│", "")


def test_version_is_that_of_the_package():
    assert millscale("--version").stdout == f"millscale {__version__}\n"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_of_a_shell_names_the_command(shell):
    line = [sys.executable, "-m", "millscale", "--show-completion", shell]
    # Which shell runs the test is not the point.
    environment = {**os.environ, "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"}
    done = subprocess.run(line, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "_MILLSCALE_COMPLETE" in done.stdout


def test_completion_completes_sub_commands():
    environment = {
        **os.environ,
        "_MILLSCALE_COMPLETE": "complete_bash",
        "COMP_WORDS": "millscale analyse p",
        "COMP_CWORD": "2",
    }
    line = [sys.executable, "-m", "millscale"]
    done = subprocess.run(line, env=environment, capture_output=True, text=True)
    assert done.stdout.split() == ["pair", "pictures"]


def test_help_loads_no_large_library():
    program = (
        "import sys, runpy\n"
        "sys.argv = ['millscale', '--help']\n"
        "try:\n    runpy.run_module('millscale', run_name='__main__')\n"
        f"except SystemExit:\n    print(sorted(set({HEAVY}) & set(sys.modules)))\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] == "[]", done.stderr
