"""Refusals and warnings before the engine runs: speeds, grooves, cores, plans."""

import math
import shlex

import numpy as np
import pytest
from rich.console import Console

from millscale import _core
from millscale.campaign.build import load_campaign
from millscale.engine.machine import CoreWish
from millscale.errors import CampaignError
from millscale.workflow import placement
from millscale.workflow.placement import place
from millscale.workflow.plan import plan_rows
from millscale.workflow.plan_display import render_plan
from paper_campaign import MULTI_BALL, cases, write_campaign
from small_command import small

TRAPEZOID = _core.Lifters(3.9, 3.61, 0.25, 0.635, 25)
# With faces this steep a groove is narrower between the tops than at its foot.
NARROW_MOUTH = _core.Lifters.from_face_angle(1.0, 0.8, 0.1, 0.0, 20)


@pytest.mark.parametrize("liner", [TRAPEZOID, NARROW_MOUTH])
def test_a_groove_is_as_wide_as_its_feet_or_the_corners_of_the_tops(liner):
    nodes, faces = liner.polygon(1e-4)
    # A sector: top, leading face, groove, trailing face; each edge begins at its own node.
    foot = nodes[np.flatnonzero(faces == 0)[0]], nodes[np.flatnonzero(faces == 3)[0]]
    corner = nodes[np.flatnonzero(faces == 1)[0]], nodes[np.flatnonzero(faces == 2)[1]]
    widths = [math.dist(*foot), math.dist(*corner)]
    assert liner.narrowest_width == pytest.approx(min(widths), rel=1e-12)
    assert (widths[1] < widths[0]) == (liner is NARROW_MOUTH)


def test_the_largest_scale_named_fits_and_a_little_more_does_not(tmp_path):
    for policy in ("paper", "corrected"):
        mill = {"scaling__policies": [policy], "single_ball__step_s": "advised"}
        with pytest.raises(CampaignError, match="do not fit the grooves") as refused:
            cases(tmp_path, **mill, scaling__S=[20.0])
        most = float(refused.value.accepted.split()[2].rstrip(","))
        assert cases(tmp_path, **mill, scaling__S=[most])
        with pytest.raises(CampaignError, match="do not fit the grooves"):
            cases(tmp_path, **mill, scaling__S=[most + 0.002])


def test_on_a_mesh_balls_may_lie_on_the_lifters(tmp_path):
    mesh = {"wall__kind": "mesh", "single_ball__step_s": "advised", "scaling__S": [10.0, 20.0]}
    for case in cases(tmp_path, **mesh):
        warned = [text for text in case.warnings if "they lie on the lifters" in text]
        assert bool(warned) == (case.S == 20.0)


def test_balls_that_fit_in_no_scaled_mill_are_refused(tmp_path):
    narrow = {"liner__lifters": 100, "liner__lifter_top_width_m": 0.15}
    with pytest.raises(CampaignError, match="accepted: smaller balls or wider grooves"):
        cases(tmp_path, **narrow, liner__groove_width_m=0.05, ball__radius_m=0.05)


def test_a_speed_in_rpm_typed_as_rad_s_is_refused_with_a_question(tmp_path):
    with pytest.raises(CampaignError, match=r"rpm typed as rad/s\? speed_rpm = 9\.55 would be 62"):
        load_campaign(write_campaign(tmp_path, mill__speed_rad_s=9.55))
    with pytest.raises(CampaignError) as refused:
        load_campaign(write_campaign(tmp_path, mill__speed_rad_s=None, mill__froude=2.0))
    assert "typed as" not in str(refused.value)


@pytest.mark.parametrize(
    ("usual", "notes"),
    [
        (CoreWish(8, None), ["run.ranks = 8 lowered to 2: this machine offers 2 cores"]),
        (
            CoreWish(2, 2),
            ["run.ranks = 2 lowered to 1: this machine offers 2 cores for 2 cases at a time"],
        ),
        (
            CoreWish(1, 9),
            ["run.jobs = 9 lowered to 2: this machine offers 2 cores"],
        ),
        (CoreWish(2, 1), []),
    ],
)
def test_ranks_beyond_the_machine_are_reported_with_the_reason(tmp_path, monkeypatch, usual, notes):
    monkeypatch.setattr(placement, "available_cores", lambda: 2)
    charges = cases(tmp_path, single_ball=None, **MULTI_BALL)
    assert list(place(charges, CoreWish(), usual).notes) == notes
    # An explicit request is used or refused, never lowered.
    assert place(charges, CoreWish(1, 1), usual).notes == ()


def test_plan_and_run_report_that_ranks_are_lowered(tmp_path, monkeypatch):
    monkeypatch.setattr(placement, "available_cores", lambda: 2)
    path = write_campaign(tmp_path, single_ball=None, **MULTI_BALL, run__ranks=8)
    campaign = load_campaign(path)
    console = Console(width=180, record=True, file=(tmp_path / "screen").open("w"))
    console.print(render_plan(campaign, plan_rows(campaign)))
    assert "run.ranks = 8 lowered to 2: this machine offers 2 cores" in console.export_text()
    command = small(tmp_path)
    text = command.file.read_text().replace("[multi_ball]", "[run]\nranks = 8\n[multi_ball]")
    command.file.write_text(text)
    assert "run.ranks = 8 lowered to 2" in command("run").stdout


def test_commands_that_are_printed_can_be_pasted(tmp_path):
    folder = tmp_path / "with a space"
    folder.mkdir()
    command = small(folder)
    printed = command("generate").stdout
    line = next(x for x in printed.splitlines() if "next: millscale run" in x)
    arguments = shlex.split(line.partition("next: ")[2].partition(", or")[0])
    assert arguments == ["millscale", *command.line("run")]
    printed = command("run").stdout
    line = next(x for x in printed.splitlines() if "next: millscale report" in x)
    assert shlex.split(line.partition("next: ")[2]) == ["millscale", *command.line("report")]


def test_a_plan_of_another_mill_does_not_mention_the_paper(tmp_path):
    drum = {"mill__radius_m": 1.0, "liner": None, "single_ball__step_s": "advised"}
    for case in cases(tmp_path, **drum, **MULTI_BALL):
        entries = [entry for side in (case.model.inside, case.model.outside) for entry in side]
        texts = " ".join(entry.what + entry.reason for entry in entries)
        assert "the paper" not in texts and "Eq" not in texts


def test_small_numbers_are_shown_with_their_digits(tmp_path):
    slow = {"mill__gravity_m_s2": 1e-4, "mill__speed_rad_s": 0.0032}
    path = write_campaign(tmp_path, **slow, single_ball__step_s="advised")
    console = Console(width=180, record=True, file=(tmp_path / "screen").open("w"))
    campaign = load_campaign(path)
    console.print(render_plan(campaign, plan_rows(campaign), details=True))
    rows = [line.split() for line in console.export_text().splitlines()]
    row = next(x for x in rows if x[:1] == ["sb-cg-paper-S1.000"])
    assert row[1:4] == ["3.9", "0.0001", "0.0032"]


@pytest.mark.parametrize(("angle", "warned"), [(4.0, True), (10.4, True), (10.6, False)])
def test_a_rotation_that_ends_before_a_charge_is_steady_is_warned_of(tmp_path, angle, warned):
    changes = MULTI_BALL | {"multi_ball__rotation_angle_rad": angle}
    for case in cases(tmp_path, **changes):
        texts = [text for text in case.warnings if "a charge is not steady before" in text]
        assert len(texts) == (warned and case.kind == "multi-ball")
        assert all("rotation_angle_rad = 11 or more" in text for text in texts)
