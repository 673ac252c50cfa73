"""`millscale new`: a commented campaign file that is planned without warnings."""

import os
import pty
import subprocess
import sys
import tomllib

import jsonschema
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from millscale.campaign.build import campaign_of_text, load_campaign
from millscale.campaign.schema import campaign_schema
from millscale.cases.new_campaign import NewMill, checked_text, suggested
from millscale.errors import CampaignError
from millscale.workflow.plan import plan_rows

COMMAND = (sys.executable, "-m", "millscale", "new")


def new(*arguments, **options):
    options = {"capture_output": True, "text": True, "stdin": subprocess.DEVNULL} | options
    return subprocess.run([*COMMAND, *map(str, arguments)], check=False, **options)


def usual(diameter):
    """Return the mill of a diameter [m] with usual values for the rest."""
    mill = NewMill(diameter_m=diameter)
    for name in NewMill.__dataclass_fields__:
        value = diameter if name == "diameter_m" else suggested(name, mill)
        mill = NewMill(**{**mill.__dict__, name: value})
    return mill


def test_options_are_written_and_nothing_is_asked(tmp_path):
    path = tmp_path / "my-mill.toml"
    options = ("--diameter-m", 4.7, "--length-m", 7.2, "--ball-diameter-mm", 60, "--lifters", 24)
    done = new(path, *options, "--filling-percent", 35)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"{path}: 2 cases, about ")
    assert done.stdout.endswith(f"; next: millscale plan {path}\n")
    campaign = load_campaign(path)
    assert (campaign.mill.radius, campaign.mill.length) == (2.35, 7.2)
    assert (campaign.ball.radius, campaign.liner.lifters) == (0.03, 24)
    assert campaign.parts[0].charge.filling == pytest.approx(0.35, rel=1e-15)
    assert campaign.name == "my-mill"
    assert path.read_text().count("#") > 8


def test_an_existing_file_is_kept(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("mine")
    done = new(path)
    assert done.returncode == 2
    assert done.stderr == f"error: millscale new: {path}: exists already; accepted: a new file\n"
    assert path.read_text() == "mine"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (
            ("--ball-diameter-mm", -5),
            "ball.diameter_mm: twice a, mean ball radius; or classes, sizes, a top-up size: got -5",
        ),
        (("--percent-of-critical", 150), "the mill centrifuges"),
        (("--lifters", 1000), "impossible liner"),
        (("--ball-diameter-mm", 300), "do not fit the grooves"),
    ],
)
def test_what_no_plan_accepts_is_refused_and_nothing_is_written(tmp_path, options, said):
    path = tmp_path / "none.toml"
    done = new(path, *options)
    assert done.returncode == 2 and said in done.stderr, done.stderr
    assert "Traceback" not in done.stderr and not path.exists()


def test_a_terminal_is_asked_and_may_take_what_is_usual(tmp_path):
    path = tmp_path / "asked.toml"
    leader, follower = pty.openpty()
    process = subprocess.Popen(
        [*COMMAND, path], stdin=follower, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    # A plain drum of 3 m: no question about lifters follows.
    os.write(leader, b"3\n\n\n\n\n\n0\n")
    text = process.communicate(timeout=120)[0].decode()
    os.close(leader), os.close(follower)
    assert process.returncode == 0, text
    assert "Diameter inside the liner [m] [5]: " in text
    assert "Ball diameter [mm] [30]: " in text and "Lifter height" not in text
    campaign = load_campaign(path)
    assert campaign.mill.radius == 1.5 and campaign.liner.lifters == 0


@settings(max_examples=8, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.floats(0.3, 12.0), st.floats(20.0, 45.0), st.floats(50.0, 90.0), st.booleans())
def test_a_usual_mill_of_any_size_is_planned_without_warnings(
    tmp_path, diameter, filling, speed, lifters
):
    mill = usual(round(diameter, 2))
    changes = {"filling_percent": filling, "percent_of_critical": speed}
    mill = NewMill(**{**mill.__dict__, **changes, "lifters": mill.lifters if lifters else 0})
    path = tmp_path / "mill.toml"
    text, cases = checked_text(path, mill)
    assert not list(jsonschema.Draft7Validator(campaign_schema()).iter_errors(tomllib.loads(text)))
    rows = plan_rows(campaign_of_text(path, text))
    assert [row["id"] for row in rows] == [case.id for case in cases]
    assert [text for row in rows for text in row["warnings"]] == []


numbers = st.floats(allow_nan=True) | st.floats(1e-3, 1e3)


@settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_any_numbers_are_written_or_refused(tmp_path, data):
    changes = {
        name: data.draw(st.integers(-5, 2000) if name == "lifters" else numbers)
        for name in data.draw(st.sets(st.sampled_from(sorted(NewMill.__dataclass_fields__))))
    }
    try:
        text, _ = checked_text(tmp_path / "any.toml", NewMill(**changes))
    except CampaignError:
        return
    assume(text)
    tomllib.loads(text)
