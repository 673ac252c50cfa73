"""Charges of several classes, by the radii and shares by mass of their balls."""

from __future__ import annotations

from collections.abc import Sequence

from millscale.campaign.campaign import Ball, BallClass


def charge_of(sizes: Sequence[tuple[float, float]]) -> Ball:
    """Return the ball sizes of a charge of classes of one density.

    Args:
        sizes: radius [m] and share by mass of each class.
    """
    numbers = [mass / radius**3 for radius, mass in sizes]
    classes = tuple(
        BallClass(radius, 1.0, n / sum(numbers))
        for (radius, _), n in zip(sizes, numbers, strict=True)
    )
    return Ball(sum(a * m for a, m in sizes), 1.0, 0.0, 2.0, classes)
