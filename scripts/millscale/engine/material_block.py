"""Writes the material properties of a deck, for decks that are not templates."""

from __future__ import annotations

from collections.abc import Sequence

# The engine refuses a Young's modulus [Pa] beyond these, unless the deck says that it is meant.
SOFT_BELOW = 5e6
HARD_ABOVE = 1e9


def material_block(
    youngs_modulus: Sequence[float],
    poisson_ratio: Sequence[float],
    *,
    restitution: Sequence[float],
    friction: Sequence[float],
    rolling_friction: Sequence[float] | None = None,
) -> str:
    """Return the lines that define the properties of n types.

    Args:
        youngs_modulus: of each type, n values [Pa].
        poisson_ratio: of each type, n values.
        restitution, friction, rolling_friction: of each pair of types, the n x n matrix by rows.
    """
    types = len(youngs_modulus)
    blocks = [
        ("youngsModulus", "peratomtype", youngs_modulus),
        ("poissonsRatio", "peratomtype", poisson_ratio),
        ("coefficientRestitution", f"peratomtypepair {types}", restitution),
        ("coefficientFriction", f"peratomtypepair {types}", friction),
    ]
    if rolling_friction is not None:
        pairs = f"peratomtypepair {types}"
        blocks.append(("coefficientRollingFriction", pairs, rolling_friction))
    lines = [
        f"soft_particles {yes_or_no(min(youngs_modulus) < SOFT_BELOW)}",
        f"hard_particles {yes_or_no(max(youngs_modulus) > HARD_ABOVE)}",
    ]
    for name, kind, values in blocks:
        numbers = " ".join(repr(float(x)) for x in values)
        lines.append(f"fix {name} all property/global {name} {kind} {numbers}")
    return "\n".join(lines) + "\n"


def ball_and_wall(balls: float, wall: float) -> tuple[float, float, float, float]:
    """Return the matrix of a coefficient for types 1, balls, and 2, the wall."""
    return balls, wall, wall, wall


def yes_or_no(value: bool) -> str:
    """Return a flag as the engine reads it."""
    return "yes" if value else "no"
