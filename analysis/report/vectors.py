"""Figures of a report as SVG and PDF for papers: text stays text, fonts are TrueType."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.layout_engine import LayoutEngine
from matplotlib.text import Text

from millscale.runs.untrusted import RunFolderError
from millscale.runs.writing import write_json, writing_folder

RECORD = "figures.json"
# Width of two columns of a journal of Elsevier; one column has 90 mm.
WIDTH_MM, NARROWEST_MM, WIDEST_MM = 190.0, 60.0, 500.0
FORMATS = ("svg", "pdf")
_MM_PER_INCH = 25.4
# Text shrinks with a figure down to this share: 9.5 pt become 7.6 pt.
_SMALLEST_TEXT = 0.8
_FONTS = {"svg.fonttype": "none", "pdf.fonttype": 42, "svg.hashsalt": "millscale"}


@dataclass(frozen=True)
class Wanted:
    """Where figures are written, and their width."""

    folder: Path
    width_mm: float


# Figures are drawn deep inside the making of a page, in processes that inherit this.
_wanted: ContextVar[Wanted | None] = ContextVar("wanted", default=None)


@contextmanager
def figures_written(folder: Path, width_mm: float = WIDTH_MM) -> Iterator[None]:
    """Write every figure that is drawn in this block into a folder, as NAME.svg and NAME.pdf.

    The folder replaces an earlier one at the end.

    Raises:
        RunFolderError: the folder is there, and holds no figures of an earlier call.
    """
    if (folder.exists() or folder.is_symlink()) and not (folder / RECORD).is_file():
        cause = "is there, and holds no figures of an earlier report"
        raise RunFolderError(folder, cause, "name a new folder: --figures")
    folder.absolute().parent.mkdir(parents=True, exist_ok=True)
    with writing_folder(folder) as part:
        token = _wanted.set(Wanted(part, width_mm))
        try:
            yield
        finally:
            _wanted.reset(token)
        names = sorted(path.name for path in part.iterdir())
        write_json(part / RECORD, {"schema": 1, "width_mm": width_mm, "files": names})


def write_vectors(figure: Figure, layout: LayoutEngine | None, name: str, caption: str) -> None:
    """Write a figure that has been drawn, if figures are wanted; the figure gets another size.

    Args:
        layout: of the figure before it was drawn.
        caption: becomes the title in the metadata of the files.
    """
    wanted = _wanted.get()
    if wanted is None:
        return
    width, height = figure.get_size_inches()
    scale = wanted.width_mm / _MM_PER_INCH / width
    of_text = min(1.0, max(_SMALLEST_TEXT, scale))
    for text in figure.findobj(Text):
        text.set_fontsize(of_text * text.get_fontsize())
    figure.set_size_inches(scale * width, scale * height)
    figure.set_layout_engine(layout)
    dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with rc_context(_FONTS):
        for kind in FORMATS:
            path = wanted.folder / f"{name}.{kind}"
            figure.savefig(path, format=kind, metadata={"Title": caption, **dates[kind]})
