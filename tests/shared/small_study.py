"""A study of the small campaign's charge: three settings, of which two hold the same case."""

from pathlib import Path

import small_campaign

BASE = small_campaign.TEXT.replace("count = [50]", "count = [200]")
TEXT = """
[study]
about = "a study for tests"
base = "small.toml"
reference = "reference"
default = "default"

[all]
run.ranks = 1

[[setting]]
name = "reference"
about = "half the step"
model.tangential_damping = "plain"
multi_ball.step_s = 5e-5
multi_ball.seeds = [1, 2]

[[setting]]
name = "default"

[[setting]]
name = "same"
about = "as the default"
"""


def write_study(folder: Path, text: str = TEXT) -> Path:
    """The study and its base in a folder; returns the study file."""
    (folder / "small.toml").write_text(BASE)
    file = folder / "small-study.toml"
    file.write_text(text)
    return file
