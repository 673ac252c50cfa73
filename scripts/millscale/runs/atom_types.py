"""Atom types of the decks: classes of balls, the liner, and end walls; their properties by pair.

A coefficient of two ball classes is the geometric mean of the coefficients of each, as LAMMPS'
`pair_style granular` mixes them (its documentation, "Mixing of coefficients").
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from msgspec.structs import replace

from millscale.runs.case_file import Case, Material

COEFFICIENTS = ("restitution", "static_friction", "rolling_friction")


@dataclass(frozen=True)
class AtomTypes:
    """Atom types from 1 on: ball classes, liner, ends.

    Attributes:
        balls: materials of the ball classes.
        liner, ends: materials of the walls; their coefficients are those of ball and wall.
    """

    balls: tuple[Material, ...]
    liner: Material
    ends: Material | None = None

    @property
    def liner_type(self) -> int:
        return len(self.balls) + 1

    @property
    def end_type(self) -> int:
        """Type of the end walls; that of the liner if they have no own material."""
        return self.liner_type + (self.ends is not None)

    @property
    def all(self) -> tuple[Material, ...]:
        """Materials of all types."""
        return (*self.balls, self.liner, *([self.ends] if self.ends else []))

    def matrix(self, name: str) -> list[float]:
        """Return a coefficient of each pair of types, the matrix by rows."""
        types = range(len(self.all))
        return [self._pair(name, i, j) for i in types for j in types]

    def _pair(self, name: str, i: int, j: int) -> float:
        i, j = min(i, j), max(i, j)
        walls = len(self.balls)
        if j >= walls:
            wall = self.all[j]
            # A ball class may have a coefficient of its own with every wall; walls do not touch.
            own: float = getattr(self.all[i], f"{name}_pw")
            of_wall: float = getattr(wall, f"{name}_pw")
            return own if i < walls and wall is self.liner else of_wall
        first: float = getattr(self.all[i], f"{name}_pp")
        other: float = getattr(self.all[j], f"{name}_pp")
        return first if first == other else math.sqrt(first * other)


def atom_types(case: Case) -> AtomTypes:
    """Return the atom types of a case."""
    balls = tuple(one.material or case.material for one in case.ball.classes)
    return AtomTypes(balls or (case.material,), case.material, _end_material(case))


def _end_material(case: Case) -> Material | None:
    """Return the material of end walls with their own friction."""
    own = {
        f"{name}_pw": value
        for name in COEFFICIENTS[1:]
        if (value := getattr(case.mill, f"end_{name}")) is not None
    }
    return replace(case.material, **own) if own else None
