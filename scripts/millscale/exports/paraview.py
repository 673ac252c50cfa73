"""A charge for ParaView: charge.pvsm shows the balls as spheres inside the turning liner.

Beside it are two collections over the simulated time, balls.pvd and liner.pvd, and their files.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from millscale.analysis.finished import Charge
from millscale.exports.paraview_state import Scene, state_text
from millscale.exports.snapshots import moments
from millscale.runs.case_folder import LINER
from millscale.runs.writing import write_text, writing_by_name

STATE, BALLS, WALL = "charge.pvsm", "balls", "liner"
_COLOUR = "speed"


def write_paraview(charge: Charge, to: Path, final: Path, every: int) -> Path:
    """Write every so many dumps of a charge, each with the liner turned to its mill angle.

    Args:
        to: folder to write into.
        final: its name in the end: ParaView finds the files of a state by absolute paths.

    Returns:
        The state to open, charge.pvsm.

    Raises:
        RunFolderError: no dumps, no series, no liner, or a damaged one.
    """
    # Imported here: a case without dumps is refused without the drawing library.
    from millscale.exports.geometry import ball_points, turned_liner

    times: list[float] = []
    fastest = 0.0
    for number, moment in enumerate(moments(charge, every)):
        balls = ball_points(moment.dump, moment.rising)
        liner = turned_liner(charge.folder / LINER, moment.mill_angle)
        for name, mesh in ((BALLS, balls), (WALL, liner)):
            with writing_by_name(to / _file(name, number)) as part:
                mesh.save(part)
        times.append(moment.time)
        if _COLOUR in balls.array_names:
            fastest = max(fastest, float(balls[_COLOUR].max()))
    for name in (BALLS, WALL):
        _write_collection(to / f"{name}.pvd", name, times)
    mill, folder = charge.case.mill, final.absolute()
    scene = Scene(
        balls=folder / f"{BALLS}.pvd",
        liner=folder / f"{WALL}.pvd",
        times=times,
        colour=_COLOUR if fastest else "",
        largest=fastest or 1.0,
        radius=mill.radius_m,
        length=mill.simulated_length_m,
    )
    write_text(to / STATE, state_text(scene))
    return to / STATE


def _file(name: str, number: int) -> str:
    return f"{name}.{number:05d}.vtp"


def _write_collection(path: Path, name: str, times: Sequence[float]) -> None:
    entries = [
        f'  <DataSet timestep="{time:.9g}" part="0" name="{name}" file="{_file(name, number)}"/>'
        for number, time in enumerate(times)
    ]
    text = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n <Collection>\n'
    write_text(path, text + "\n".join(entries) + "\n </Collection>\n</VTKFile>\n")
