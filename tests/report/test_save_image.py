"""Images of the report."""

import base64
from io import BytesIO

import pytest
from matplotlib.figure import Figure
from PIL import Image

from millscale.report.images import DPI, save_image


@pytest.mark.parametrize("layout", ["constrained", "tight", None])
def test_an_image_has_the_pixels_of_savefig(tmp_path, layout):
    def drawn():
        figure = Figure(figsize=(3.0, 2.5), layout=layout)
        upper, lower = figure.subplots(2, 1, sharex=True)
        upper.plot([0.0, 1.0], [0.0, 1e6], label="a line")
        upper.set_ylabel("a long label")
        lower.set(xlabel="x", yscale="log", ylim=(1e-3, 10.0))
        figure.legend(loc="outside upper center" if layout == "constrained" else "center")
        return figure

    drawn().savefig(tmp_path / "usual.png", dpi=DPI)
    image = save_image(drawn(), tmp_path / "ours.png", "a caption")
    ours, usual = (Image.open(path).convert("RGB") for path in (image.path, tmp_path / "usual.png"))
    assert ours.size == usual.size and ours.tobytes() == usual.tobytes()
    with Image.open(BytesIO(base64.b64decode(image.data.partition(",")[2]))) as small:
        assert (small.format, small.size) == ("WEBP", usual.size)
