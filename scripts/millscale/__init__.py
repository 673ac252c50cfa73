"""Simulation campaigns of ball mills with similarity-scaled models in LIGGGHTS.

The names of `millscale.api`, such as `millscale.predict`, are imported on first use.
"""

from importlib import import_module
from importlib.metadata import version
from typing import Any

__version__ = version("millscale")
_API = ("advise", "predict")


def __getattr__(name: str) -> Any:
    """Return a function of the Python interface."""
    if name not in _API:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module("millscale.api"), name)


def __dir__() -> list[str]:
    return ["__version__", *_API]
