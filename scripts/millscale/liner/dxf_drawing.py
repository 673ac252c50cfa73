"""The outline of a liner in a DXF drawing: lines, arcs, polylines; splines and ellipses fitted."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from millscale.errors import CampaignError, nearest
from millscale.liner.lengths import ACCEPTED, LENGTHS
from millscale.liner.outline import Outline, joined, reversed_outline, without_repeats
from millscale.liner.simplify import simplified
from millscale.runs.untrusted import RunFolderError, read_bytes

LARGEST_FILE_BYTES = 1 << 26
MOST_ENTITIES = 20_000
MOST_POINTS = 100_000
# Relative to the size of the drawing: ends that are as near are one point, ...
JOINT = 1e-5
# ... and a spline or ellipse is not farther from the arcs and lines that replace it.
FITTED = 1e-4
# $INSUNITS of the header.
UNITS = {1: "in", 2: "ft", 4: "mm", 5: "cm", 6: "m"}
CURVES = ("LINE", "ARC", "CIRCLE", "LWPOLYLINE", "POLYLINE", "SPLINE", "ELLIPSE")
_A_DRAWING = "a DXF drawing with " + ", ".join(CURVES)


@dataclass(frozen=True)
class Chain:
    """One entity as a chain of pieces.

    Attributes:
        name: such as `LINE #2F`.
        layer: of the entity.
        points: (n, 2) float, in the unit of the drawing.
        bulges: (n,) float, as in Outline.
        closed: ends where it begins.
        exact: not a spline or ellipse.
    """

    name: str
    layer: str
    points: np.ndarray
    bulges: np.ndarray
    closed: bool
    exact: bool = True


def read_dxf(path: Path, layer: str | None, unit: str | None) -> tuple[Outline, tuple[str, ...]]:
    """Return the only outline of a drawing, or of one of its layers, and warnings.

    Args:
        layer: entities of other layers are left out; None: all entities.
        unit: of the drawing; None: as its header states.

    Raises:
        CampaignError: not a drawing, no unit, no outline or several; names the entity.
    """
    drawing = _drawing(path)
    metres, notes = _unit(path, drawing, unit)
    try:
        found = list(_chains(path, drawing.modelspace()))
    except CampaignError:
        raise
    except Exception as problem:  # the library fails anywhere in a damaged drawing
        raise _damaged(path, problem) from None
    chains = _of_layer(path, found, layer)
    for chain in chains:
        if not np.isfinite(chain.points).all() or np.abs(chain.points).max() > 1e9:
            cause = "coordinates that are no finite numbers below 1e9"
            raise CampaignError(path, chain.name, cause, "coordinates of a drawing")
    size = max(float(np.abs(chain.points).max()) for chain in chains)
    outlines = [_outline(path, chain, metres, size) for chain in chains]
    outline = _one(path, _assembled(outlines, JOINT * size * metres), found, layer, metres)
    if any(not chain.exact for chain in chains):
        error = FITTED * size * metres
        notes += (f"liner: splines and ellipses are arcs and lines within {error:.3g} m",)
    return outline, notes


def _drawing(path: Path) -> Any:
    import ezdxf

    try:
        content = read_bytes(path, LARGEST_FILE_BYTES, "", follow=True)
    except RunFolderError as error:
        raise CampaignError(path, "", error.cause, _A_DRAWING) from None
    if not content.strip():
        raise CampaignError(path, "", "empty", _A_DRAWING)
    if not content.rstrip(b"\0\r\n \t\x1a").endswith(b"EOF"):
        line = content.count(b"\n") + 1
        is_dxf = b"SECTION" in content[:4096]
        cause = f"cut short: no EOF after line {line:,}" if is_dxf else "not a DXF drawing"
        raise CampaignError(path, "", cause, _A_DRAWING + "; export it again")
    try:
        return ezdxf.readfile(path)
    except Exception as cause:  # the library fails anywhere in a damaged drawing
        raise _damaged(path, cause) from None


def _damaged(path: Path, cause: Exception) -> CampaignError:
    said = f"{type(cause).__name__}: {cause}" if str(cause) else type(cause).__name__
    return CampaignError(
        path, "", f"a damaged drawing: {said[:120]}", _A_DRAWING + "; export it again"
    )


def _unit(path: Path, drawing: Any, given: str | None) -> tuple[float, tuple[str, ...]]:
    """Return metres of a unit of the drawing, and a warning if the campaign overrules it."""
    try:
        code = int(drawing.header.get("$INSUNITS", 0))
    except (TypeError, ValueError):
        code = 0
    stated = UNITS.get(code)
    if given is not None:
        if stated not in (None, given):
            note = f"liner: {path.name} states its unit as {stated}; liner.unit = {given} is used"
            return LENGTHS[given], (note,)
        return LENGTHS[given], ()
    if stated is None:
        what = "states no unit" if code == 0 else f"states the unit number {code}"
        raise CampaignError(
            path, "$INSUNITS", f"the drawing {what}", f"liner.unit, one of {ACCEPTED}"
        )
    return LENGTHS[stated], ()


def _chains(path: Path, entities: Iterable[Any], depth: int = 0) -> Iterator[Chain]:
    """Yield the curves among entities, also those of inserted blocks."""
    for count, entity in enumerate(entities):
        if count == MOST_ENTITIES:
            accepted = f"<= {MOST_ENTITIES:,} entities"
            raise CampaignError(path, "", f"more than {MOST_ENTITIES:,} entities", accepted)
        kind = entity.dxftype()
        if kind == "INSERT" and depth < 4:
            yield from _chains(path, entity.virtual_entities(), depth + 1)
        elif kind in CURVES:
            chain = _chain(entity, kind)
            if chain is not None:
                yield chain


def _chain(entity: Any, kind: str) -> Chain | None:
    """Return a curve; None for a polyline that is a mesh, or of fewer than two points."""
    handle = entity.dxf.handle
    name = f"{kind} #{handle}" if handle else kind
    below = float(entity.dxf.get("extrusion", (0.0, 0.0, 1.0))[2]) < 0.0
    closed, exact = False, True
    if kind == "LINE":
        points, bulges = [entity.dxf.start, entity.dxf.end], [0.0, 0.0]
    elif kind == "ARC":
        angle = math.radians((entity.dxf.end_angle - entity.dxf.start_angle) % 360.0) or math.tau
        if angle == math.tau:
            return None
        points, bulges = [entity.start_point, entity.end_point], [math.tan(angle / 4.0), 0.0]
    elif kind == "CIRCLE":
        # Two halves.
        centre = entity.ocs().to_wcs(entity.dxf.center)
        x, y = centre.x, centre.y
        r = entity.dxf.radius
        points, bulges, closed = [(x + r, y), (x - r, y)], [1.0, 1.0], True
    elif kind == "LWPOLYLINE":
        points = list(entity.vertices_in_wcs())
        bulges = [float(row[-1]) for row in entity.get_points("xyb")]
        closed = bool(entity.closed)
    elif kind == "POLYLINE":
        if not (entity.is_2d_polyline or entity.is_3d_polyline):
            return None
        points = list(entity.points_in_wcs())
        bulges = [float(v.dxf.get("bulge", 0.0)) for v in entity.vertices]
        closed = bool(entity.is_closed)
    else:
        points, bulges, exact = _flattened(entity), [], False
    array = np.array([(p[0], p[1]) for p in points], dtype=float).reshape(-1, 2)
    if len(array) < 2 or len(array) > MOST_POINTS:
        return None
    curved = np.array(bulges, dtype=float) if exact else np.zeros(len(array))
    return Chain(name, entity.dxf.layer, array, -curved if below else curved, closed, exact)


def _flattened(entity: Any) -> list[Any]:
    """Return points of a spline or ellipse, within a quarter of `FITTED` of its own size."""
    rough = np.array([tuple(p)[:2] for p in entity.flattening(1e9, 8)], dtype=float)
    size = float(np.ptp(rough, axis=0).max()) if len(rough) else 0.0
    if not (math.isfinite(size) and size > 0.0):
        return []
    points = []
    for point in entity.flattening(0.25 * FITTED * size, 8):
        points.append(point)
        if len(points) > MOST_POINTS:
            break
    return points


def _of_layer(path: Path, chains: list[Chain], layer: str | None) -> list[Chain]:
    counts = Counter(chain.layer for chain in chains)
    listed = ", ".join(f'"{name}" ({count})' for name, count in sorted(counts.items())[:20])
    if not chains:
        raise CampaignError(path, "", "no line, arc or curve in the model space", _A_DRAWING)
    if layer is None:
        return chains
    kept = [chain for chain in chains if chain.layer.lower() == layer.lower()]
    if not kept:
        lower = {name.lower(): name for name in counts}
        near = lower.get(nearest(layer.lower(), lower), "")
        cause = f'no curve on the layer "{layer}"' + (f', nearest is "{near}"' if near else "")
        raise CampaignError(path, "", cause, f"a layer with curves: {listed}")
    return kept


def _outline(path: Path, chain: Chain, metres: float, size: float) -> Outline:
    """Return a chain in metres; of a spline or ellipse, lines and arcs that fit it."""
    outline = without_repeats(
        Outline(
            file=path,
            points=metres * chain.points,
            bulges=chain.bulges,
            names=(chain.name,) * len(chain.points),
            closed=chain.closed,
            unit=metres,
        )
    )
    if chain.exact or outline.pieces < 3:
        return outline
    return simplified(outline, 0.75 * FITTED * size * metres)


def _assembled(outlines: list[Outline], near: float) -> list[Outline]:
    """Return the outlines joined at common ends, longest first.

    Args:
        near: largest distance of ends that are one point [m].

    Raises:
        CampaignError: more than two pieces have a common end.
    """
    closed = [one for one in outlines if one.closed]
    chains = _without_twins([one for one in outlines if not one.closed and one.pieces], near)
    if chains:
        ends = np.concatenate([[one.points[0], one.points[-1]] for one in chains])
        tree = cKDTree(ends)
        partner: dict[int, int] = {}
        for i, found in enumerate(tree.query_ball_point(ends, near)):
            others = [j for j in found if j != i]
            if len(others) > 1:
                one = chains[i // 2]
                names = ", ".join(chains[j // 2].names[0] for j in others[:3])
                raise one.refused(
                    one.place(0 if i % 2 == 0 else len(one.points) - 1),
                    f"more than two lines meet: also {names}",
                    "an outline without branches; liner.layer selects the layer of the outline",
                )
            if others:
                partner[i] = others[0]
        closed += _followed(chains, partner)
    return sorted(closed, key=lambda one: -one.pieces)


def _without_twins(chains: list[Outline], near: float) -> list[Outline]:
    """Return the chains without those drawn twice."""
    kept: dict[tuple[Any, ...], Outline] = {}
    for one in chains:
        cells = [tuple(np.round(point / (4.0 * near)).astype(int)) for point in one.points]
        bulge = round(float(np.abs(one.bulges).sum()), 4)
        kept.setdefault((min(tuple(cells), tuple(cells[::-1])), bulge), one)
    return list(kept.values())


def _followed(chains: list[Outline], partner: dict[int, int]) -> list[Outline]:
    """Return the chains joined, end 2 i being the first and 2 i + 1 the last point of chain i."""
    left = set(range(len(chains)))
    starts = [i for i in range(2 * len(chains)) if i not in partner] + list(range(2 * len(chains)))
    found = []
    for start in starts:
        if start // 2 not in left:
            continue
        run, end = [], start
        while end // 2 in left:
            left.remove(end // 2)
            one = chains[end // 2]
            run.append(one if end % 2 == 0 else reversed_outline(one))
            far = end ^ 1
            if far not in partner:
                break
            end = partner[far]
        whole = joined(run)
        if partner.get(far) == start:
            points, bulges, names = whole.points[:-1], whole.bulges[:-1], whole.names[:-1]
            whole = replace(whole, points=points, bulges=bulges, names=names, closed=True)
        found.append(whole)
    return found


def _one(
    path: Path, outlines: list[Outline], chains: list[Chain], layer: str | None, metres: float
) -> Outline:
    """Return the only outline; refuse several, with the gap between them or their layers."""
    if len(outlines) == 1:
        return outlines[0]
    layers = sorted({chain.layer for chain in chains})
    ends = [(one, k) for one in outlines if not one.closed for k in (0, len(one.points) - 1)]
    if len(ends) > 2:
        places = np.array([one.points[k] for one, k in ends])
        distance, which = cKDTree(places).query(places, 2)
        first = int(distance[:, 1].argmin())
        gap = float(distance[first, 1])
        extent = float(np.ptp(places, axis=0).max())
        if gap < 0.02 * extent:
            (one, k), (other, j) = ends[first], ends[int(which[first, 1])]
            raise CampaignError(
                path,
                one.place(k),
                f"the outline is open: {gap / metres:.4g} in the drawing's unit to the nearest "
                f"end, {other.place(j)}",
                "ends that meet; join the lines in the drawing",
            )
    shown = "; ".join(
        f"{one.pieces} pieces from {one.place(0)}{'' if one.closed else ', open'}"
        for one in outlines[:3]
    )
    helps = "a drawing of the outline alone"
    if layer is None and len(layers) > 1:
        names = ", ".join(f'"{name}"' for name in layers[:20])
        helps += f", or liner.layer, one of {names}"
    raise CampaignError(path, "", f"{len(outlines)} separate outlines: {shown}", helps)
