"""From an outline to the sectors of a mill: pitch, direction of rotation, lifters and grooves."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from millscale import _core
from millscale.liner.lengths import LENGTHS, unit_that_fits
from millscale.liner.outline import (
    Outline,
    arc_middle,
    arc_radii,
    check_no_crossing,
    in_halves,
    joined,
    mirrored_outline,
    reversed_outline,
    without_flat_arcs,
    without_repeats,
)

# Relative to the radius: rounding of coordinates in a drawing, which is corrected silently.
ROUNDING = 1e-3
MOST_PITCHES = 1000
# A case.json holds every piece of a pitch.
MOST_PIECES = 2000
# Chords that stand for arcs when crossings are looked for, relative to the radius.
CHORD_ERROR = 1e-4
# Piece that leans by more than this from the circle around the axis: the face of a lifter [rad].
LEAST_FACE = math.radians(20.0)
# Relative to the radius: a liner that is nowhere higher, or within its tolerance, is a drum.
LEAST_HEIGHT = 1e-6
GROOVE, LEADING, TOP, TRAILING = range(4)
CLOCKWISE, COUNTER = "clockwise", "counter-clockwise"


@dataclass(frozen=True)
class Placing:
    """What a campaign states about an outline.

    Attributes:
        radius: R of the mill [m].
        phase: angle of groove 0 from the bottom at rest [rad].
        turns: direction of rotation in the drawing, x to the right and y up; None: not stated.
        lifters: number of lifters, or of pitches; None: not stated.
        tolerance: how far the outline may be from what was measured [m].
    """

    radius: float
    phase: float = 0.0
    turns: str | None = None
    lifters: int | None = None
    tolerance: float = 0.0


def profile_of(outline: Outline, placing: Placing) -> tuple[_core.Profile, tuple[str, ...]]:
    """Return the liner of an outline around the axis at (0, 0), and warnings.

    The outline is one pitch, repeated around the mill, or goes all around.

    Raises:
        CampaignError: the outline is no liner of this mill; states what and where.
    """
    outline = in_halves(without_flat_arcs(without_repeats(outline)))
    _check_points(outline)
    check_no_crossing(outline, CHORD_ERROR * placing.radius)
    outline = _around_left(outline)
    _check_size(outline, placing)
    pitch, pitches, notes = _one_pitch(outline, placing)
    if pitch.pieces > MOST_PIECES:
        raise outline.refused(
            "",
            f"{pitch.pieces:,} lines and arcs in a pitch",
            f"<= {MOST_PIECES:,}; tolerance_mm fits lines and arcs to points",
        )
    pitch, note = _scaled_to(pitch, placing)
    notes += note
    turns = placing.turns
    if turns is None and not _is_symmetric(pitch, pitches, placing.radius):
        raise outline.refused(
            "",
            "leading and trailing faces differ, so the direction of rotation matters",
            f'liner.turns = "{CLOCKWISE}" or "{COUNTER}", as the mill turns in the drawing, x to '
            "the right and y up",
        )
    if turns == CLOCKWISE:
        pitch = _turned_over(pitch, pitches)
    return _profile(pitch, pitches, placing), notes


def _check_points(outline: Outline) -> None:
    """Refuse an outline of too few pieces, or through the axis."""
    if outline.pieces < 1 or (outline.closed and outline.pieces < 2):
        raise outline.refused(
            "", f"{outline.pieces} lines and arcs of any length", "the outline of a liner"
        )
    distance = np.linalg.norm(outline.points, axis=1)
    nearest = int(distance.argmin())
    if distance[nearest] <= 1e-6 * distance.max():
        raise outline.refused(
            outline.place(nearest), "on the axis of the mill", "an outline around x = 0, y = 0"
        )


def _sweeps(outline: Outline) -> np.ndarray:
    """Return the angle around the axis of each piece, (pieces,) float [rad]."""
    begin, end = outline.points[: outline.pieces], outline.ends
    angles: np.ndarray = np.arctan2(
        begin[:, 0] * end[:, 1] - begin[:, 1] * end[:, 0], (begin * end).sum(axis=1)
    )
    return angles


def _closed_if_around(outline: Outline) -> Outline:
    """Return an open outline that ends less than its longest piece before its beginning, closed by
    a line: a table all around does not state its first point twice."""
    if outline.closed or outline.pieces < 2:
        return outline
    closed = replace(outline, closed=True, bulges=np.append(outline.bulges[:-1], 0.0))
    lengths = np.linalg.norm(closed.ends - closed.points, axis=1)
    around = abs(abs(float(_sweeps(closed).sum())) - math.tau) < 1e-6
    return closed if around and lengths[-1] <= lengths[:-1].max() * 1.01 else outline


def _around_left(outline: Outline) -> Outline:
    """Return the outline in the order that has the axis on its left."""
    outline = _closed_if_around(outline)
    sweep = float(_sweeps(outline).sum())
    if outline.closed and abs(abs(sweep) - math.tau) > 1e-6:
        x, y = (0.5 * (outline.points.min(axis=0) + outline.points.max(axis=0))).tolist()
        unit = outline.unit
        raise outline.refused(
            outline.place(0),
            "the closed outline does not go around the axis at x = 0, y = 0; its middle is at "
            f"x = {x / unit:.6g}, y = {y / unit:.6g}",
            "the inner surface of the liner around the axis, or one pitch of it, open",
        )
    if abs(sweep) < math.tau / (2 * MOST_PITCHES):
        raise outline.refused(
            outline.place(0),
            f"the outline spans {math.degrees(abs(sweep)):.3g} degrees around the axis at x = 0, "
            "y = 0",
            f"one pitch, 360 degrees over 1 to {MOST_PITCHES} pitches, or all around",
        )
    return outline if sweep > 0.0 else reversed_outline(outline)


def reach(outline: Outline) -> tuple[float, float]:
    """Return the smallest and the largest distance from the axis [m]."""
    points, radii = outline.points, np.abs(arc_radii(outline))
    distance = np.linalg.norm(points, axis=1)
    low, high = float(distance.min()), float(distance.max())
    for begin, end, bulge, radius in zip(
        points, outline.ends, outline.bulges.tolist(), radii.tolist(), strict=False
    ):
        chord = end - begin
        if bulge == 0.0:
            share = -float(begin @ chord) / float(chord @ chord)
            if 0.0 < share < 1.0:
                low = min(low, float(np.linalg.norm(begin + share * chord)))
            continue
        middle = arc_middle(begin, end, bulge)
        outward = middle - 0.5 * (begin + end)
        outward /= np.linalg.norm(outward)
        centre = middle - radius * outward
        off = float(np.linalg.norm(centre))
        away = centre / off if off > 1e-9 * radius else outward
        cosine = math.cos(2.0 * math.atan(abs(bulge)))
        if float(away @ outward) >= cosine:
            high = max(high, off + radius)
        if float(-away @ outward) >= cosine:
            low = min(low, abs(off - radius))
    return low, high


def _check_size(outline: Outline, placing: Placing) -> None:
    """Refuse an outline whose largest distance from the axis is not R, with the likely reason."""
    low, high = reach(outline)
    allowed = _allowed(placing)
    if abs(high - placing.radius) <= allowed:
        return
    R, raw = placing.radius, high / outline.unit
    unit = unit_that_fits(raw, R, 3e-2)
    name = next((n for n, metres in LENGTHS.items() if metres == outline.unit), "m")
    helps = ""
    if unit is not None and LENGTHS[unit] != outline.unit:
        helps = f"the numbers fit if their unit is {unit}"
    elif abs(low - R) <= max(allowed, 1e-2 * R):
        helps = (
            "the outline is inside out: its smallest distance is R, so its lifters point away from "
            "the axis"
        )
    elif abs(0.5 * high - R) <= max(allowed, 1e-2 * R):
        helps = "it would fit as half of it: are the numbers diameters?"
    elif not outline.closed:
        helps = "is the axis at x = 0, y = 0? liner.centre_x_m and centre_y_m state another place"
    far = int(np.linalg.norm(outline.points, axis=1).argmax())
    raise outline.refused(
        outline.place(far),
        f"the outline reaches {raw:.6g} {name} = {high:.6g} m from the axis, mill.radius_m is {R:g}"
        + (f"; {helps}" if helps else ""),
        f"{R - allowed:.6g} to {R + allowed:.6g} m: R is the largest distance of the liner from "
        "the axis",
    )


def _allowed(placing: Placing) -> float:
    return max(ROUNDING * placing.radius, 2.0 * placing.tolerance)


def rotated(points: np.ndarray, angle: float) -> np.ndarray:
    """Return points (n, 2) turned to the left about the axis by an angle [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    x, y = points.T
    return np.column_stack([c * x - s * y, s * x + c * y])


def _one_pitch(outline: Outline, placing: Placing) -> tuple[Outline, int, tuple[str, ...]]:
    """Return one pitch as an open outline without its last point's own place, and their number.

    The last point is the first one, turned by the pitch.
    """
    if outline.closed:
        return _of_all_around(outline, placing)
    sweep = float(_sweeps(outline).sum())
    pitches = round(math.tau / sweep)
    given = placing.lifters
    if given and given % max(pitches, 1) and abs(math.tau / given - sweep) < 0.1 * sweep:
        pitches = given
    if pitches < 1 or pitches > MOST_PITCHES:
        raise outline.refused(
            "",
            f"the outline spans {math.degrees(sweep):.5g} degrees around the axis",
            "one pitch, 360 degrees over a whole number of pitches, or a closed outline",
        )
    pitch = math.tau / pitches
    end = rotated(outline.points[:1], pitch)[0]
    gap = float(np.linalg.norm(outline.points[-1] - end))
    allowed = _allowed(placing)
    last = len(outline.points) - 1
    if gap > allowed:
        r_first, r_last = (float(np.linalg.norm(outline.points[i])) for i in (0, last))
        if abs(r_first - r_last) > allowed:
            cause = (
                f"the ends of the pitch do not meet: {r_first:.6g} m from the axis at "
                f"{outline.place(0)} and {r_last:.6g} m here"
            )
            helps = "a pitch that ends as it begins, one pitch further"
        else:
            cause = (
                f"the outline spans {math.degrees(sweep):.6g} degrees around the axis, and "
                f"{pitches} pitches of 360 degrees are {math.degrees(pitch):.6g} each: open by "
                f"{gap:.3g} m"
            )
            helps = "a closed outline, or a pitch of 360 degrees over a whole number"
        raise outline.refused(
            outline.place(last),
            cause,
            f"{helps}; the axis at x = 0, y = 0 or centre_x_m, centre_y_m",
        )
    if given is not None and (given % pitches or given // pitches > 20):
        raise outline.refused(
            "",
            f"the outline spans {math.degrees(sweep):.5g} degrees, {pitches} of them around the "
            f"mill, and liner.lifters is {given}",
            f"lifters = {pitches}, or a multiple if a pitch has several lifters",
        )
    points = outline.points.copy()
    # The gap is shared by both ends.
    points[0] = 0.5 * (points[0] + rotated(points[-1:], -pitch)[0])
    points[-1] = rotated(points[:1], pitch)[0]
    closed = replace(outline, points=points)
    if pitches > 1:
        onwards = replace(closed, points=rotated(points, pitch))
        check_no_crossing(joined([closed, onwards]), CHORD_ERROR * placing.radius)
    return closed, pitches, _gap_note(gap, placing)


def _gap_note(gap: float, placing: Placing) -> tuple[str, ...]:
    if gap <= 1e-5 * placing.radius:
        return ()
    return (f"liner: the ends of a pitch were {gap:.3g} m apart and have been joined",)


def _of_all_around(outline: Outline, placing: Placing) -> tuple[Outline, int, tuple[str, ...]]:
    """Return the pitch that a closed outline repeats, or all of it as one pitch."""
    n = outline.pieces
    allowed = 1e-4 * placing.radius
    for pitches in range(min(n, MOST_PITCHES), 1, -1):
        if n % pitches:
            continue
        step = n // pitches
        turned = rotated(outline.points, math.tau / pitches)
        apart = np.linalg.norm(np.roll(outline.points, -step, axis=0) - turned, axis=1).max()
        bent = np.abs(np.roll(outline.bulges, -step) - outline.bulges).max()
        if apart <= allowed and bent <= 1e-3:
            points = np.vstack(
                [outline.points[:step], rotated(outline.points[:1], math.tau / pitches)]
            )
            pitch = replace(
                outline,
                points=points,
                bulges=np.append(outline.bulges[:step], 0.0),
                names=(*outline.names[:step], outline.names[step]),
                closed=False,
            )
            return pitch, pitches, ()
    points = np.vstack([outline.points, outline.points[:1]])
    whole = replace(
        outline,
        points=points,
        bulges=np.append(outline.bulges, 0.0),
        names=(*outline.names, outline.names[0]),
        closed=False,
    )
    return whole, 1, ()


def _scaled_to(pitch: Outline, placing: Placing) -> tuple[Outline, tuple[str, ...]]:
    """Return the pitch with R as its largest distance from the axis, exactly."""
    _, high = reach(pitch)
    by = placing.radius / high
    note: tuple[str, ...] = ()
    if abs(by - 1.0) > 1e-4:
        note = (f"liner: the outline is scaled by {by:.6g} to the radius of the mill",)
    return replace(pitch, points=by * pitch.points), note


def _turned_over(pitch: Outline, pitches: int) -> Outline:
    """Return a pitch as it is seen from the other end of the mill."""
    return reversed_outline(mirrored_outline(pitch))


def _is_symmetric(pitch: Outline, pitches: int, radius: float) -> bool:
    """Return whether the liner is its own mirror image: the same pieces in reversed order."""
    chords = np.linalg.norm(np.diff(pitch.points, axis=0), axis=1)
    bulges = pitch.bulges[:-1]
    distance = np.linalg.norm(pitch.points[:-1], axis=1)
    n = len(chords)
    ends = np.roll(distance, -1)
    own = np.column_stack([chords / radius, bulges, distance / radius, ends / radius])
    mirrored = np.column_stack([chords / radius, bulges, ends / radius, distance / radius])[::-1]
    return any(np.abs(np.roll(mirrored, k, axis=0) - own).max() < ROUNDING for k in range(n))


def _profile(pitch: Outline, pitches: int, placing: Placing) -> _core.Profile:
    """Return the profile of a pitch that runs in the direction of rotation."""
    radii = arc_radii(pitch)
    low, high = reach(pitch)
    if high - low <= max(LEAST_HEIGHT * high, placing.tolerance):
        return _core.Lifters(placing.radius, 0.0, 0.0, 0.0, 0, placing.phase)
    faces = _faces(pitch, high)
    first, centre = _first_piece(pitch, faces, pitches)
    turn = math.tau / pitches
    # Pieces before the first one belong to the next pitch.
    points = np.vstack([pitch.points[first:-1], rotated(pitch.points[:first], turn)])
    order = [*range(first, pitch.pieces), *range(first)]
    local = rotated(points, -centre)
    last_groove = max((i for i, k in enumerate(order) if faces[k] == GROOVE), default=-1)
    nodes = [
        (
            float(local[i, 0]),
            float(local[i, 1]),
            float(radii[k]),
            faces[k],
            int(i > last_groove and last_groove >= 0 and faces[k] != GROOVE),
        )
        for i, k in enumerate(order)
    ]
    try:
        return _with_radius(nodes, pitches, placing)
    except ValueError as cause:
        raise pitch.refused("", str(cause), "the outline of a liner around the axis") from None


def _with_radius(
    nodes: list[tuple[float, float, float, int, int]], pitches: int, placing: Placing
) -> _core.Profile:
    """Return the profile, scaled until rounding has left its radius."""
    for _ in range(3):
        profile = _core.Profile(nodes, pitches, placing.phase)
        by = placing.radius / profile.radius
        if abs(by - 1.0) < 1e-14:
            break
        nodes = [(by * r, by * t, by * a, face, ahead) for r, t, a, face, ahead in nodes]
    return profile


def _faces(pitch: Outline, high: float) -> list[int]:
    """Return the face of each piece.

    A piece that leans by more than `LEAST_FACE` from the circle around the axis is a face: leading
    if its distance from the axis grows in the direction of rotation, trailing if it falls. Of the
    others those behind a trailing face and before a leading one are tops; the rest is groove.
    """
    begin, end = pitch.points[:-1], pitch.points[1:]
    rise = np.linalg.norm(end, axis=1) - np.linalg.norm(begin, axis=1)
    sweep = _sweeps(pitch) * 0.5 * (np.linalg.norm(end, axis=1) + np.linalg.norm(begin, axis=1))
    lean = np.arctan2(rise, np.abs(sweep))
    n = len(lean)
    kinds = [LEADING if a > LEAST_FACE else TRAILING if a < -LEAST_FACE else None for a in lean]
    if all(kind is None for kind in kinds):
        return [GROOVE] * n
    found = list(kinds)
    for i in range(n):
        if kinds[i] is not None:
            continue
        before = next(k for j in range(1, n + 1) if (k := kinds[(i - j) % n]) is not None)
        after = next(k for j in range(1, n + 1) if (k := kinds[(i + j) % n]) is not None)
        found[i] = TOP if (before, after) == (TRAILING, LEADING) else GROOVE
    return [GROOVE if face is None else face for face in found]


def _first_piece(pitch: Outline, faces: list[int], pitches: int) -> tuple[int, float]:
    """Return the piece that a sector begins with, and the polar angle of the sector's middle.

    A sector begins with the top of its highest lifter, whose middle is half a pitch behind the
    middle of the sector; without tops, with the piece nearest to the axis.
    """
    n, half = len(faces), math.pi / pitches
    distance = np.linalg.norm(pitch.points[:-1], axis=1)
    angles = np.unwrap(np.arctan2(pitch.points[:, 1], pitch.points[:, 0]))
    tops = [i for i in range(n) if faces[i] == TOP and faces[i - 1] != TOP]
    if not tops:
        leading = [i for i in range(n) if faces[i] == LEADING and faces[i - 1] != LEADING]
        first = min(leading or range(n), key=lambda i: distance[i])
        return first, float(angles[first]) + half
    first = min(tops, key=lambda i: min(distance[i], distance[(i + 1) % n]))
    last = first
    while faces[(last + 1) % n] == TOP and (last + 1) % n != first:
        last += 1
    end = last + 1
    behind = float(angles[end]) if end <= n else float(angles[end - n]) + 2.0 * half
    return first, 0.5 * (float(angles[first]) + behind) + half
