"""Simulation campaigns of ball mills with similarity-scaled models in LIGGGHTS."""

from importlib.metadata import version

__version__ = version("millscale")
