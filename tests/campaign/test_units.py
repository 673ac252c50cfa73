import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from millscale.campaign.units import AGREEMENT, resolve, speed_forms, split_unit
from millscale.errors import CampaignError

WHERE = ("mill.toml", "mill")
FORMS = speed_forms(radius=3.9, ball_radius=0.02, gravity=9.81)


def spoken(omega: float) -> dict[str, float]:
    """Return a speed in every unit, computed independently of the code under test."""
    return {
        "speed_rad_s": omega,
        "speed_rpm": omega * 30.0 / math.pi,
        "period_s": 2.0 * math.pi / omega,
        "percent_of_critical": 100.0 * omega * math.sqrt((3.9 - 0.02) / 9.81),
        "froude": omega**2 * 3.9 / 9.81,
    }


def only(values: dict[str, float], keys: set[str]) -> dict[str, float | None]:
    return {key: values[key] if key in keys else None for key in FORMS}


speeds = st.floats(0.01, 100.0)
key_sets = st.sets(st.sampled_from(sorted(FORMS)), min_size=1)


@given(speeds, key_sets)
def test_every_unit_of_a_speed_gives_the_same_rad_s(omega, keys):
    found = resolve(only(spoken(omega), keys), FORMS, "rad/s", WHERE)
    assert found == pytest.approx(omega, rel=1e-12)


@given(
    speeds,
    st.sampled_from(sorted(FORMS)),
    st.sampled_from(sorted(FORMS)),
    st.floats(0.997, 1.003) | st.floats(0.5, 2.0),
)
def test_two_speeds_that_differ_by_more_than_the_agreement_are_refused(omega, one, other, factor):
    assume(one != other)
    values = only(spoken(omega), {one}) | {other: spoken(omega * factor)[other]}
    # The second is compared relative to the first in the table's order.
    first = next(key for key in FORMS if key in (one, other))
    difference = abs(factor - 1.0) if first == one else abs(1.0 / factor - 1.0)
    assume(abs(difference - AGREEMENT) > 1e-9)
    if difference < AGREEMENT:
        resolve(values, FORMS, "rad/s", WHERE)
    else:
        with pytest.raises(CampaignError, match="contradicts"):
            resolve(values, FORMS, "rad/s", WHERE)


def test_a_quantity_that_is_not_given_is_none():
    assert resolve(dict.fromkeys(FORMS), FORMS, "rad/s", WHERE) is None


@pytest.mark.parametrize(
    ("key", "parts"),
    [
        ("radius_mm", ("radius", "_mm")),
        ("density_kg_m3", ("density", "_kg_m3")),
        ("speed_rad_s", ("speed", "_rad_s")),
        ("rotation_angle_rad", ("rotation_angle", "_rad")),
        ("lifters", ("lifters", "")),
        ("_m", ("_m", "")),
    ],
)
def test_a_key_splits_into_quantity_and_unit(key, parts):
    assert split_unit(key) == parts
