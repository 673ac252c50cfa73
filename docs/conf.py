"""The site of the documentation: ./scripts/docs builds it into build/site."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path, PurePosixPath

from sphinx.application import Sphinx

ROOT = Path(__file__).resolve().parents[1]

project = "millscale"
release = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
author = "the millscale developers"
extensions = ["myst_parser", "sphinx_copybutton"]
root_doc = "README"
include_patterns = ["*.md", "docs/**"]
exclude_patterns = ["docs/README.md"]  # the README of the project has the same list
myst_heading_anchors = 4
myst_enable_extensions = ["html_image"]
copybutton_prompt_text = "$ "
html_theme = "furo"
html_title = f"millscale {release}"
html_show_copyright = False

LINK = re.compile(r"\]\(([^)\s#:]+\.md)\)")


def add_contents(app: Sphinx, name: str, source: list[str]) -> None:
    """Append a table of contents to the README of a folder: the pages that it links to, in order.

    So the order of the site is that of the READMEs. That of the project gives the folders and the
    pages beside it.
    """
    if PurePosixPath(name).name != "README":
        return
    links = [link.removesuffix(".md") for link in LINK.findall(source[0])]
    below = [link for link in dict.fromkeys(links) if not link.startswith("..")]
    if name == root_doc:
        last = links[links.index("docs/tutorial") :]  # its list "Where to go next"
        below = [link for link in dict.fromkeys(last) if not link.startswith("..")]
    source[0] += "\n```{toctree}\n:hidden:\n\n" + "\n".join(below) + "\n```\n"


def setup(app: Sphinx) -> None:
    app.connect("source-read", add_contents)
