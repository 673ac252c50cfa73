"""STL files. The engine reads text and binary; text is written, as binary has single precision."""

import struct
from pathlib import Path

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from millscale.mesh.engine_limits import NODE_PRECISION_M
from millscale.mesh.liner_mesh import UNKNOWN, LinerMesh, normals

_BINARY_HEADER = 84
_LARGEST_BYTES = 1 << 28
# Corners of a mesh that are one node but differ in the last digits, on average.
_MOST_NEAR = 50
_BINARY_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def write_stl(path, mesh):
    """Writes a text STL file with coordinates that read back to the same doubles.

    Args:
        path: file to write; the engine asks for the ending .stl.
        mesh: LinerMesh.
    """
    path = Path(path)
    if path.suffix not in (".stl", ".STL"):
        raise ValueError(f"{path}: the engine reads files ending in .stl or .STL only")
    lines = ["solid liner"]
    for normal, corners in zip(normals(mesh).tolist(), mesh.corners.tolist(), strict=True):
        lines.append("facet normal {!r} {!r} {!r}".format(*normal))
        lines.append(" outer loop")
        lines += ["  vertex {!r} {!r} {!r}".format(*corner) for corner in corners]
        lines += [" endloop", "endfacet"]
    lines.append("endsolid liner")
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def read_stl(path, precision=NODE_PRECISION_M):
    """Reads a text or binary STL file; corners closer than `precision` [m] become one node.

    Returns:
        LinerMesh with unknown faces (-1).
    """
    path = Path(path)
    with path.open("rb") as file:
        data = file.read(_LARGEST_BYTES + 1)
    if len(data) > _LARGEST_BYTES:
        raise ValueError(
            f"{path}: larger than {_LARGEST_BYTES} bytes, no liner has so many triangles"
        )
    corners = _text_corners(path, data) if _is_text(data) else _binary_corners(path, data)
    if len(corners) == 0:
        raise ValueError(f"{path}: no triangle in it")
    if not np.isfinite(corners).all():
        raise ValueError(f"{path}: coordinates must be finite numbers")
    if _crowded(corners, precision):
        raise ValueError(f"{path}: too many different corners closer than {precision:g} m")
    nodes, triangles = _merged(corners, precision)
    return LinerMesh(nodes, triangles, np.full(len(triangles), UNKNOWN, dtype=np.int64))


def _is_text(data):
    # Some binary files also begin with "solid": their size follows from their number of triangles.
    if len(data) >= _BINARY_HEADER and len(data) == _binary_bytes(data):
        return False
    return data[:5].lower() == b"solid" and b"facet" in data[:1024].lower()


def _binary_bytes(data):
    """Size of a binary file by the number of triangles in its header [bytes]."""
    count = struct.unpack_from("<I", data, _BINARY_HEADER - 4)[0]
    return _BINARY_HEADER + count * _BINARY_RECORD.itemsize


def _text_corners(path, data):
    words = data.lower().split()
    at = [i for i, word in enumerate(words) if word == b"vertex"]
    if len(at) % 3 or (at and at[-1] + 3 >= len(words)):
        raise ValueError(f"{path}: {len(at)} vertices, a multiple of 3 is needed; file cut short?")
    if b"endsolid" not in words[at[-1] if at else 0 :]:
        line = data.count(b"\n") + 1
        raise ValueError(f"{path}: cut short: no endsolid after line {line:,}")
    try:
        values = [float(word) for i in at for word in words[i + 1 : i + 4]]
    except ValueError as error:
        raise ValueError(f"{path}: a vertex is three numbers: {error}") from error
    return np.array(values).reshape(-1, 3, 3)


def _binary_corners(path, data):
    needed = _binary_bytes(data) if len(data) >= _BINARY_HEADER else _BINARY_HEADER
    count = (needed - _BINARY_HEADER) // _BINARY_RECORD.itemsize
    if count == 0 or len(data) < needed:
        raise ValueError(
            f"{path}: neither text STL nor binary STL with {count} triangles ({needed} bytes), "
            f"got {len(data)} bytes"
        )
    records = np.frombuffer(data, _BINARY_RECORD, count, _BINARY_HEADER)
    return records["corners"].astype(float)


def _crowded(corners, precision):
    """Whether merging would take more memory than a mesh is worth: pairs grow with the square."""
    exact = np.unique(corners.reshape(-1, 3), axis=0)
    tree = cKDTree(exact)
    return tree.count_neighbors(tree, precision, p=np.inf) > _MOST_NEAR * len(exact)


def _merged(corners, precision):
    """Nodes (n, 3) and triangles (m, 3) of corners (m, 3, 3); the first corner is the node."""
    points = corners.reshape(-1, 3)
    exact, inverse = np.unique(points, axis=0, return_inverse=True)
    pairs = cKDTree(exact).query_pairs(precision, p=np.inf, output_type="ndarray")
    links = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(exact), len(exact)))
    _, group = connected_components(links, directed=False)
    _, first, triangles = np.unique(group[inverse.ravel()], return_index=True, return_inverse=True)
    return points[first], triangles.reshape(-1, 3)
