"""Limits of a power model: between which values of a mill it holds."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from millscale.power_models.mill import STANDARD_GRAVITY, Mill


@dataclass(frozen=True)
class Limit:
    """Range of a property of the mill.

    Attributes:
        what: its name and symbol.
        value: returns it.
        unit: "" for a ratio.
    """

    what: str
    value: Callable[[Mill], float]
    least: float
    most: float
    unit: str = ""

    def passed_by(self, mill: Mill) -> str | None:
        """Return how a mill lies outside, such as "diameter D 1.2 m, below 2.4 m"; else None."""
        value, unit = self.value(mill), f" {self.unit}" if self.unit else ""
        if value < self.least:
            return f"{self.what} {value:.3g}{unit}, below {self.least:g}{unit}"
        if value > self.most:
            return f"{self.what} {value:.3g}{unit}, above {self.most:g}{unit}"
        return None


def diameter(least: float, most: float) -> Limit:
    """Return a range of D [m]."""
    return Limit("diameter D", lambda mill: mill.diameter, least, most, "m")


def filling(least: float, most: float) -> Limit:
    """Return a range of J."""
    return Limit("filling J", lambda mill: mill.filling, least, most)


def speed(least: float, most: float) -> Limit:
    """Return a range of phi."""
    return Limit("share of the critical speed", lambda mill: mill.fraction_of_critical, least, most)


# Of models whose constants hold gravity: rounding of 9.81 is accepted.
ON_EARTH = Limit(
    "gravity", lambda mill: mill.gravity, STANDARD_GRAVITY - 0.05, STANDARD_GRAVITY + 0.05, "m/s^2"
)


def outside(limits: Iterable[Limit], mill: Mill) -> tuple[str, ...]:
    """Return how a mill lies outside of limits; empty if it is within all."""
    return tuple(text for limit in limits if (text := limit.passed_by(mill)))
