"""Window of the means of a charge: the steady part of its rotation, chosen from its series.

The lifters make every quantity of a charge periodic in the lifter pitch, 2 pi / n of mill rotation.
So a window holds whole pitches, which begin at the same phase in every mill of n lifters.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from millscale.runs.case_file import Mill
from millscale.runs.liner import liner_of

# Stands for the pitch of a plain drum [rad]: near that of the paper's 25 lifters.
DRUM_PITCH = 0.25
# Fewer pitches do not show whether a charge is steady.
FEWEST_PITCHES = 8
# Largest share of the pitches that may be left out: the rest must be enough for a scatter.
MOST_CUT = 2.0 / 3.0
# Largest drift of the centre of mass over the window, and largest share of the torque that changes
# the angular momentum: about the difference between two seeds.
MOST_DRIFT = 0.01


@dataclass(frozen=True)
class Window:
    """Mill angles between which the means of a charge are taken.

    Attributes:
        begin, end: [rad].
        edges: (n + 1,) float, of the whole pitches in it [rad]; begin and end alone where the
            rotation has fewer than `FEWEST_PITCHES`.
    """

    begin: float
    end: float
    edges: np.ndarray

    @property
    def pitches(self) -> int:
        return len(self.edges) - 1

    def mean(self, mill_angle: np.ndarray, values: np.ndarray) -> float:
        """Return the mean over mill angle of a quantity sampled at (n,) angles [rad], by
        trapezoids."""
        return float(_means(mill_angle, values, np.array([self.begin, self.end]))[0])

    def pitch_means(self, mill_angle: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Return the mean over each pitch, (pitches,) float."""
        return _means(mill_angle, values, self.edges)

    def change(self, mill_angle: np.ndarray, total: np.ndarray) -> float:
        """Return the change of a quantity over the window, its values interpolated at begin and
        end."""
        begin, end = np.interp([self.begin, self.end], mill_angle, total)
        return float(end - begin)


@dataclass(frozen=True)
class Trend:
    """A straight line through the means of the pitches.

    Attributes:
        change: over the whole window, in the unit of the values.
        error: its standard error, increased for pitches that correlate with the one before.
    """

    change: float
    error: float


def lifter_pitch(lifters: int) -> float:
    """Return the mill rotation after which the liner looks the same [rad]."""
    return 2.0 * math.pi / lifters if lifters else DRUM_PITCH


def pitch_of(mill: Mill) -> float:
    """Return the same of a mill; of a liner in one sector with lifters, such as a scan, the mean
    angle from lifter to lifter [rad]."""
    if mill.profile is not None and mill.lifters == 1:
        return lifter_pitch(len(liner_of(mill).lifter_angles))
    return lifter_pitch(mill.lifters)


def choose_window(
    mill_angle: np.ndarray, quantities: list[np.ndarray], pitch: float, turning_from: float = 0.0
) -> Window:
    """Return the window of a charge: the whole pitches at its end that give the steadiest means.

    For each quantity, the number of pitches left out at the start minimises the squared standard
    error of the mean over the rest, sum (y - mean)^2 / n^2 over n pitches (marginal standard error
    rule, White, Simulation 69 (1997) 323, doi 10.1177/003754979706900601). At most `MOST_CUT` of
    the pitches are left out, and at least `FEWEST_PITCHES` are kept. The window begins at the
    latest of these starts. For a rotation of fewer pitches it is the second half.

    Args:
        mill_angle: (n,) float, increasing [rad].
        quantities: (n,) float each.
        pitch: [rad].
        turning_from: mill angle from which on the speed is constant [rad]; no pitch before it is
            in the window, unless the rotation ends before.
    """
    turning_from = turning_from if turning_from < mill_angle[-1] else 0.0
    # 1e-9: the last sample of a rotation of whole pitches may fall short by rounding.
    first = math.ceil(max(float(mill_angle[0]), turning_from) / pitch - 1e-9)
    last = math.floor(mill_angle[-1] / pitch + 1e-9)
    edges = pitch * np.arange(first, last + 1)
    if len(edges) <= FEWEST_PITCHES:
        end = float(mill_angle[-1])
        begin = turning_from + 0.5 * (end - turning_from)
        return Window(begin, end, np.array([begin, end]))
    cut = max(_least_error_cut(_means(mill_angle, values, edges)) for values in quantities)
    return Window(float(edges[cut]), float(edges[-1]), edges[cut:])


def trend(values: np.ndarray) -> Trend:
    """Return the least-squares line through (n,) values at equal distances, n of 3 or more.

    A correlation r of neighbouring residuals increases the error by sqrt((1 + r) / (1 - r)).
    """
    n = len(values)
    at = np.arange(n) - 0.5 * (n - 1)
    slope = float(at @ values / (at @ at))
    left = values - values.mean() - slope * at
    variance = float(left @ left) / (n - 2) if n > 2 else math.nan
    error = math.sqrt(variance / float(at @ at)) * _correlation_factor(left)
    return Trend(n * slope, n * error)


def standard_error(values: np.ndarray) -> float:
    """Return the standard error of the mean of (n,) values in a row, correlated as in `trend`."""
    left = values - values.mean()
    n = len(values)
    return (
        math.sqrt(float(left @ left) / (n * (n - 1))) * _correlation_factor(left)
        if n > 1
        else math.nan
    )


def _correlation_factor(left: np.ndarray) -> float:
    square = float(left @ left)
    correlation = float(left[1:] @ left[:-1]) / square if square > 0.0 else 0.0
    correlation = min(max(correlation, 0.0), 0.9)
    return math.sqrt((1.0 + correlation) / (1.0 - correlation))


def _most_cut(pitches: int) -> int:
    """Return the largest number of pitches that may be left out at the start."""
    return min(int(MOST_CUT * pitches), pitches - FEWEST_PITCHES)


def _least_error_cut(means: np.ndarray) -> int:
    """Return the number of pitches to leave out at the start."""
    n = len(means)
    errors = [np.var(means[cut:]) / (n - cut) for cut in range(_most_cut(n) + 1)]
    return int(np.argmin(errors))


def _means(mill_angle: np.ndarray, values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the means over mill angle between the edges, (len(edges) - 1,) float."""
    steps = 0.5 * (values[1:] + values[:-1]) * np.diff(mill_angle)
    integral = np.concatenate([[0.0], np.cumsum(steps)])
    return np.diff(_integral_at(edges, mill_angle, values, integral)) / np.diff(edges)


def _integral_at(
    edges: np.ndarray, mill_angle: np.ndarray, values: np.ndarray, integral: np.ndarray
) -> np.ndarray:
    """Return the integral up to each edge, with straight lines between the samples."""
    left = np.clip(np.searchsorted(mill_angle, edges, side="right") - 1, 0, len(mill_angle) - 2)
    way = edges - mill_angle[left]
    slope = (values[left + 1] - values[left]) / (mill_angle[left + 1] - mill_angle[left])
    return integral[left] + way * (values[left] + 0.5 * way * slope)
