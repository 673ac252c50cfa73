"""A state of ParaView (.pvsm) that shows balls and liner: the properties that differ from default.

Names of proxies and properties are those of ParaView 5.11, where it was tried.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

_VERSION = "5.11.0"
# Colours of the speed, from slow to fast: places from 0 to 1 of matplotlib's viridis.
_VIRIDIS = (
    (0.00, 0.267004, 0.004874, 0.329415),
    (0.25, 0.229739, 0.322361, 0.545706),
    (0.50, 0.127568, 0.566949, 0.550556),
    (0.75, 0.369214, 0.788888, 0.382914),
    (1.00, 0.993248, 0.906157, 0.143936),
)
_GREY = (0.60, 0.64, 0.68)
_OPACITY = 0.25  # of the liner
_CLIENT, _DATA, _RENDER = 16, 1, 21  # servers on which ParaView has a proxy
# Camera over the mill radius, from the middle: before the mill, to the left and above.
_CAMERA = (-1.1, -4.2, 1.1)


@dataclass(frozen=True)
class Scene:
    """What a state shows.

    Attributes:
        balls, liner: collections of files over time, absolute paths.
        times: simulated times of the files [s].
        colour: array that colours the balls; empty for one colour.
        largest: of this array, at the end of the colours.
        radius, length: of the mill, which has its end at y = 0 [m].
    """

    balls: Path
    liner: Path
    times: Sequence[float]
    colour: str
    largest: float
    radius: float
    length: float


def state_text(scene: Scene) -> str:
    """Return the content of a .pvsm file that shows a scene at its last time."""
    root = ET.Element("ParaView")
    state = ET.SubElement(root, "ServerManagerState", version=_VERSION)
    ids = {name: str(1000 + i) for i, name in enumerate(_NAMES)}
    for name, properties in _properties(scene, ids).items():
        group, kind, servers = _NAMES[name]
        proxy = ET.SubElement(
            state, "Proxy", group=group, type=kind, id=ids[name], servers=str(servers)
        )
        for key, values in properties.items():
            _add_property(proxy, ids[name], key, values)
        if name == "layout":
            item = ET.SubElement(proxy, "Layout", number_of_elements="1")
            ET.SubElement(item, "Item", direction="0", fraction="0.5", view=ids["view"])
    for collection, items in _COLLECTIONS.items():
        element = ET.SubElement(state, "ProxyCollection", name=collection)
        for name, shown in items.items():
            ET.SubElement(element, "Item", id=ids[name], name=shown)
    ET.indent(root)
    return '<?xml version="1.0"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


# Group, type and servers of each proxy.
_NAMES = {
    "scene": ("animation", "AnimationScene", _CLIENT),
    "cue": ("animation", "TimeAnimationCue", _CLIENT),
    "time": ("misc", "TimeKeeper", _CLIENT),
    "layout": ("misc", "ViewLayout", _CLIENT + 4),
    "balls": ("sources", "PVDReader", _DATA),
    "liner": ("sources", "PVDReader", _DATA),
    "colours": ("lookup_tables", "PVLookupTable", _RENDER),
    "spheres": ("representations", "GeometryRepresentation", _RENDER),
    "wall": ("representations", "GeometryRepresentation", _RENDER),
    "view": ("views", "RenderView", _RENDER),
}
_COLLECTIONS = {
    "animation": {"scene": "AnimationScene1", "cue": "TimeAnimationCue1"},
    "timekeeper": {"time": "TimeKeeper1"},
    "layouts": {"layout": "Layout #1"},
    "sources": {"balls": "balls", "liner": "liner"},
    "lookup_tables": {"colours": "speed.PVLookupTable"},
    "representations": {"spheres": "balls", "wall": "liner"},
    "views": {"view": "RenderView1"},
}


@dataclass(frozen=True)
class _Proxy:
    """A property value that refers to another proxy."""

    id: str


def _properties(scene: Scene, ids: dict[str, str]) -> dict[str, dict[str, Any]]:
    """Return the properties of each proxy; a value is a tuple, an element of it a `_Proxy`."""
    to = {name: _Proxy(number) for name, number in ids.items()}
    first, last = (float(scene.times[0]), float(scene.times[-1]))
    middle = (0.0, 0.5 * scene.length, 0.0)
    colour = ("", "", "", "0", scene.colour) if scene.colour else ("", "", "", "", "")
    points = [(scene.largest * place, *rgb) for place, *rgb in _VIRIDIS]
    return {
        "time": {
            "TimeSources": (to["balls"], to["liner"]),
            "Time": (last,),
            "TimeRange": (first, last),
            "TimestepValues": tuple(scene.times),
            "Views": (to["view"],),
        },
        "cue": {"AnimatedPropertyName": ("Time",), "AnimatedProxy": (to["time"],)},
        "scene": {
            "AnimationTime": (last,),
            "StartTime": (first,),
            "EndTime": (last,),
            "PlayMode": (2,),  # snap to time steps
            "Cues": (to["cue"],),
            "TimeKeeper": (to["time"],),
            "ViewModules": (to["view"],),
        },
        "balls": {"FileName": (str(scene.balls),)},
        "liner": {"FileName": (str(scene.liner),)},
        "colours": {
            "RGBPoints": tuple(x for point in points for x in point),
            "ColorSpace": (0,),  # RGB
            "ScalarRangeInitialized": (1,),
            "AutomaticRescaleRangeMode": (-1,),  # never
        },
        "spheres": {
            "Input": (to["balls"],),
            "Representation": ("Point Gaussian",),
            "GaussianRadius": (1,),
            "ScaleByArray": (1,),
            "SetScaleArray": ("", "", "", "0", "radius"),
            "UseScaleFunction": (0,),
            "ShaderPreset": (1,),  # sphere
            "ColorArrayName": colour,
            "LookupTable": (to["colours"],),
        },
        "wall": {
            "Input": (to["liner"],),
            "Representation": ("Surface",),
            "Opacity": (_OPACITY,),
            "AmbientColor": _GREY,
            "DiffuseColor": _GREY,
        },
        "view": {
            "Representations": (to["spheres"], to["wall"]),
            "ViewTime": (last,),
            "UseColorPaletteForBackground": (0,),
            "Background": (1, 1, 1),
            "CameraFocalPoint": middle,
            "CameraPosition": tuple(
                x + scene.radius * y for x, y in zip(middle, _CAMERA, strict=True)
            ),
            "CameraViewUp": (0, 0, 1),
        },
        "layout": {},
    }


def _add_property(proxy: ET.Element, owner: str, key: str, values: tuple[Any, ...]) -> None:
    element = ET.SubElement(
        proxy,
        "Property",
        name=key,
        id=f"{owner}.{key}",
        number_of_elements=str(len(values)),
    )
    for index, value in enumerate(values):
        if isinstance(value, _Proxy):
            reference = ET.SubElement(element, "Proxy", value=value.id)
            if key == "Input":
                reference.set("output_port", "0")
        else:
            text = f"{value:.9g}" if isinstance(value, float | int) else value
            ET.SubElement(element, "Element", index=str(index), value=text)
