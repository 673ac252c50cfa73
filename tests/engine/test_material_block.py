"""The material properties of decks that are not templates."""

import re

import pytest

from millscale.cases.decks import template_folder
from millscale.engine.material_block import ball_and_wall, material_block

# Of one class of balls and the liner; matrices by rows.
VALUES = {
    "types": 2,
    "youngs_moduli": "5.98e7 5.98e7",
    "poisson_ratios": "0.3 0.3",
    "restitutions": "0.1 0.2 0.2 0.2",
    "static_frictions": "0.5 0.4 0.4 0.4",
    "rolling_frictions": "0.02 0.01 0.01 0.01",
    "soft_particles": "no",
    "hard_particles": "no",
}


def properties(deck):
    """Kind and values of each property that a deck defines, by its name."""
    lines = re.sub(r"\s*&\n\s*", " ", deck)
    found = re.findall(r"property/global (\w+) (\w+) (.*)", lines)
    return {name: (kind, [float(x) for x in values.split()]) for name, kind, values in found}


def test_the_block_defines_what_the_template_defines():
    template = (template_folder() / "material.in").read_text()
    for name, value in VALUES.items():
        template = template.replace(f"${{{name}}}", str(value))
    block = material_block(
        [5.98e7] * 2,
        [0.3] * 2,
        restitution=ball_and_wall(0.1, 0.2),
        friction=ball_and_wall(0.5, 0.4),
        rolling_friction=ball_and_wall(0.02, 0.01),
    )
    assert properties(block) == properties(template)
    assert len(properties(block)) == 5


@pytest.mark.parametrize(
    ("moduli", "soft", "hard"),
    [((5.98e7, 5.98e7), "no", "no"), ((4e6, 1e8), "yes", "no"), ((1e7, 2e9), "no", "yes")],
)
def test_moduli_outside_the_engines_range_are_confirmed(moduli, soft, hard):
    block = material_block(moduli, [0.3] * 2, restitution=[0.5] * 4, friction=[0.5] * 4)
    assert f"soft_particles {soft}\nhard_particles {hard}\n" in block
    assert "coefficientRollingFriction" not in block


def test_three_types_have_nine_pairs():
    block = material_block([1e7] * 3, [0.3] * 3, restitution=range(9), friction=[0.5] * 9)
    assert properties(block)["coefficientRestitution"][1] == [3, *range(9)]
