"""Simulation campaigns of ball mills with similarity-scaled models in LIGGGHTS.

    import millscale as ms

    runs = ms.open("runs/quick")            # a runs folder of `millscale run`
    runs.cases                              # a table of its finished cases
    runs["mb-cg-paper-S2.600"].power()      # kW of the physical mill

`help(ms.open)` and docs/reference/api.md describe the functions, which are imported on first use.
"""

from importlib import import_module
from importlib.metadata import version
from typing import Any

__version__ = version("millscale")
# Functions of the Python interface, and the modules of `millscale.api` that hold them.
_API = {
    "advise": "predicting",
    "compare": "comparing",
    "export": "runs_folder",
    "open": "runs_folder",
    "plan": "planning",
    "predict": "predicting",
    "run": "running",
    "scale": "scaling",
}
__all__ = ["__version__", *_API]


def __getattr__(name: str) -> Any:
    """Return a function of the Python interface."""
    if name not in _API:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"millscale.api.{_API[name]}"), name)


def __dir__() -> list[str]:
    return __all__
