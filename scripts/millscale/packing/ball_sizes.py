"""Radii of the balls: classes, or normal, cut symmetrically at a number of standard deviations."""

from __future__ import annotations

import math

import numpy as np

from millscale.campaign.campaign import Ball


def mean_volume(ball: Ball) -> float:
    """Return the mean volume of a ball [m^3], 4/3 pi (a^3 + 3 a s^2), s^2 the variance of the cut
    normal; of classes their mean by number.

    The cut is symmetric, so the third central moment vanishes. With t = `truncation`, f the density
    and F the distribution of the unit normal, s^2 = sigma^2 (1 - 2 t f(t) / (2 F(t) - 1)).
    Derived here.
    """
    if ball.classes:
        return sum(one.share * one.volume for one in ball.classes)
    t = ball.truncation
    density = math.exp(-0.5 * t * t) / math.sqrt(math.tau)
    inside = math.erf(t / math.sqrt(2.0))
    variance = ball.radius_std**2 * (1.0 - 2.0 * t * density / inside)
    return 4.0 / 3.0 * math.pi * (ball.radius**3 + 3.0 * ball.radius * variance)


def class_counts(ball: Ball, count: int) -> list[int]:
    """Return the balls of each class among `count`, by largest remainder."""
    exact = [count * one.share for one in ball.classes]
    counts = [math.floor(x) for x in exact]
    missing = sorted(range(len(exact)), key=lambda k: counts[k] - exact[k])
    for k in missing[: count - sum(counts)]:
        counts[k] += 1
    return counts


def draw_kinds(ball: Ball, count: int, random: np.random.Generator) -> np.ndarray:
    """Return the class of each ball from 0 on, in random order, (count,) int."""
    if not ball.classes:
        return np.zeros(count, int)
    kinds = np.repeat(np.arange(len(ball.classes)), class_counts(ball, count))
    return random.permutation(kinds)


def draw_radii(ball: Ball, count: int, random: np.random.Generator) -> np.ndarray:
    """Return ball radii [m], (count,) float; all equal without a standard deviation.

    One radius is drawn from each of `count` equally likely ranges, in random order, so that even a
    few balls have the mean mass of the distribution.
    """
    if ball.radius_std == 0.0:
        return np.full(count, ball.radius)
    # Half a second, which a plan has no need of.
    from scipy.special import ndtr, ndtri

    share = (random.permutation(count) + random.uniform(0.0, 1.0, count)) / count
    below = ndtr(-ball.truncation)
    deviations = ndtri(below + (1.0 - 2.0 * below) * share)
    return ball.radius + ball.radius_std * np.clip(deviations, -ball.truncation, ball.truncation)


def mean_by_mass(radii: np.ndarray) -> float:
    """Return the mean radius by volume [m], sum a^4 / sum a^3."""
    if np.ptp(radii) == 0.0:
        return float(radii[0])
    cubes = radii**3
    return float((cubes * radii).sum() / cubes.sum())
