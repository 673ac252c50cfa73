"""result.json of a case folder."""

import json

import pytest
from numpy.testing import assert_allclose

from millscale.analysis.case import analyse_case
from millscale.analysis.result_file import Thrown
from millscale.analysis.single_ball.result import flight_of
from millscale.runs.typed import as_typed
from millscale.runs.untrusted import RunFolderError
from synthetic_ball import Motion, usual_motion
from synthetic_case import case_document, write_case


def test_result_holds_the_motion_that_was_put_in(folder):
    result = analyse_case(folder)
    assert result["problem"] is None
    assert result["cycles"] == 2
    assert_allclose(result["detach_angle_deg"], 35.5, atol=1e-6)
    assert_allclose(result["detach_angle_mean_deg"], 35.3, atol=1e-6)
    assert_allclose(result["detach_angle_std_deg"], 0.4 / 2**0.5, atol=1e-6)
    assert_allclose(result["liner_off_angle_deg"], 63.9, atol=1e-6)
    assert_allclose(result["throw_energy"]["window_rad"], 0.977)
    assert result["paper_angles"]["in_flight"] is False


def test_throw_reads_back_as_the_flight_it_was(folder):
    result = analyse_case(folder)
    flight = flight_of(as_typed(Thrown, result["throws"][0]))
    release = [s.release for s in usual_motion(read_case(folder)).segments if s.release][3]
    assert_allclose(flight.velocity, release.velocity, rtol=1e-9)
    assert_allclose(flight.length, result["throws"][0]["flight_length_rad"])


def test_case_without_a_throw_has_a_result_with_the_reason(tmp_path):
    case = case_document("single-ball", "constant-gravity", "paper", 1.0)
    motion = Motion(case)
    motion.carry(2.8)
    result = analyse_case(write_case(tmp_path, case, motion.series()))
    assert result["problem"].startswith("no throw: 0 confirmed flights")
    assert result["detach_angle_deg"] is None
    assert result["throws"] == []


def test_scheme_the_paper_has_not_has_no_paper_angles(tmp_path):
    case = case_document("single-ball", "constant-gravity", "paper", 1.0) | {"scheme": "froude"}
    result = analyse_case(write_case(tmp_path, case, usual_motion(case).series()))
    assert result["paper_angles"] is None


def test_short_series_has_no_paper_angles(case, tmp_path):
    series = usual_motion(case).series()
    short = {name: values[series["mill_angle_rad"] < 3.5] for name, values in series.items()}
    result = analyse_case(write_case(tmp_path, case, short))
    assert result["paper_angles"] is None
    assert result["throws"][0]["finished"] is False
    assert result["throw_energy"]["window_rad"] < 0.75


def test_the_analysis_leaves_writing_to_the_stage(folder):
    before = sorted(folder.iterdir())
    analyse_case(folder)
    assert sorted(folder.iterdir()) == before


def test_unknown_kind_is_refused(folder):
    case = read_case(folder) | {"kind": "two-ball"}
    (folder / "case.json").write_text(json.dumps(case))
    with pytest.raises(RunFolderError, match="kind: got 'two-ball', accepted: multi-ball, single"):
        analyse_case(folder)


def read_case(folder) -> dict:
    return json.loads((folder / "case.json").read_text())
