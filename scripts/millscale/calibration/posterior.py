"""Particles of a probability density over the unit cube, by a sequential Monte Carlo sampler.

Particles begin evenly over the cube. The likelihood enters in steps, as powers beta from 0 to 1.
Each step weights the particles, resamples them, and moves each by a random walk that keeps the
density. So several separate regions are found too (Del Moral, Doucet, Jasra, J. R. Statist. Soc. B
68 (2006) 411-436; steps of equal effective sample size: Jasra and others, Scand. J. Statist. 38
(2011) 1-22).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq
from scipy.stats import qmc

# Particles; moves of each after a step; effective share that a step leaves.
COUNT, MOVES, SHARE = 2048, 8, 0.5

LogLikelihood = Callable[[np.ndarray], np.ndarray]


def particles_of(log_likelihood: LogLikelihood, dimensions: int, seed: int) -> np.ndarray:
    """Return particles of the density that is proportional to a likelihood, (COUNT, d) float.

    Args:
        log_likelihood: of (n, d) float in [0, 1], returns (n,) float.
    """
    generator = np.random.default_rng(seed)
    places = qmc.Sobol(dimensions, rng=generator).random(COUNT)
    logs = log_likelihood(places)
    beta, width = 0.0, 2.38 / np.sqrt(dimensions)
    while beta < 1.0:
        step = _step(logs, 1.0 - beta)
        beta += step
        chosen = _resampled(step * logs, generator)
        places, logs = places[chosen], logs[chosen]
        root = _root(np.cov(places.T).reshape(dimensions, dimensions))
        for _ in range(MOVES):
            moved = _reflected(places + width * generator.normal(size=places.shape) @ root.T)
            its_logs = log_likelihood(moved)
            takes = np.log(generator.random(COUNT)) < beta * (its_logs - logs)
            places[takes], logs[takes] = moved[takes], its_logs[takes]
            # An acceptance near a quarter explores fastest (Roberts, Gelman, Gilks 1997).
            width *= np.exp(0.5 * (takes.mean() - 0.25))
            width = min(width, 4.0)
    return places


def _step(logs: np.ndarray, left: float) -> float:
    """Return the largest step of beta that leaves the effective share of the particles."""

    def excess(step: float) -> float:
        weights = np.exp(step * (logs - logs.max()))
        return float(weights.sum() ** 2 / (weights**2).sum()) - SHARE * len(logs)

    return left if excess(left) >= 0.0 else float(brentq(excess, 0.0, left, rtol=1e-3))


def _resampled(logs: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Return the numbers of particles drawn by their weights, evenly spaced, (n,) int."""
    weights = np.exp(logs - logs.max())
    edges = np.cumsum(weights / weights.sum())
    points = (generator.random() + np.arange(len(logs))) / len(logs)
    return np.minimum(np.searchsorted(edges, points), len(logs) - 1)


def _root(covariance: np.ndarray) -> np.ndarray:
    """Return a root of a covariance that may be singular, (d, d) float."""
    values, vectors = np.linalg.eigh(covariance)
    return vectors * np.sqrt(np.maximum(values, 1e-12))


def _reflected(places: np.ndarray) -> np.ndarray:
    """Return places mirrored at the faces of the cube into it."""
    folded = np.mod(places, 2.0)
    return np.where(folded > 1.0, 2.0 - folded, folded)
