"""Energy budget of a revolution from ledger.csv, impacts per revolution from impacts.csv."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.analysis.case import analyse_case
from millscale.analysis.charge.energy_budget import energy_budget, impact_spectrum
from millscale.analysis.finished import Charge
from millscale.analysis.result_file import PAIRINGS, ImpactSpectrum
from millscale.report.figures.energy_budget import energy_budget_figure
from millscale.report.images import charge_images
from millscale.runs.case_folder import load_finished
from millscale.runs.series import REQUIRED
from millscale.runs.untrusted import RunFolderError
from synthetic_case import finish_case, write_series
from synthetic_charge import write_charge

HEAD = "mill_angle_from_rad,mill_angle_to_rad,pairing,energy_low_J,energy_high_J,impacts,energy_J\n"


@pytest.fixture
def ledger():
    """Every column grows with the mill's angle at a rate of its own, after a wild start."""
    angle = np.linspace(0.0, 9.0, 901)
    columns = {name: 0.1 * (k + 1) * angle for k, name in enumerate(REQUIRED["ledger"])}
    columns |= {"step": np.arange(901.0) + 1, "time_s": angle / 1.6, "mill_angle_rad": angle}
    spent = sum(
        columns[name]
        for name in columns
        if name in ("kinetic_translation_J", "kinetic_rotation_J", "potential_J")
        or "_elastic_" in name
        or "_dissipated_" in name
    )
    # One part in a hundred is lost, of which the springs lose what their columns say.
    columns["mill_work_J"] = spent / 0.99
    for column in columns.values():
        column[angle < 2.0] *= 1.0 if column is columns["mill_angle_rad"] else 0.5
    columns["step"] = np.arange(901.0) + 1
    return columns


def test_terms_are_those_of_the_last_revolution(ledger):
    found = energy_budget(ledger)
    turned = found.to_rad - found.from_rad
    assert_allclose(turned, math.tau, atol=0.01)
    assert found.to_rad == 9.0
    for name in ("kinetic_translation_J", "potential_J"):
        rate = 0.1 * (REQUIRED["ledger"].index(name) + 1)
        assert_allclose(getattr(found, name), rate * turned)
    for pairing in PAIRINGS:
        rate = 0.1 * (REQUIRED["ledger"].index(f"{pairing}_dissipated_rolling_J") + 1)
        assert_allclose(found.pairings[pairing].dissipated_rolling_J, rate * turned)
    assert_allclose(found.duration_s, turned / 1.6)


def test_what_no_term_accounts_for_is_the_closure(ledger):
    found = energy_budget(ledger)
    assert_allclose(found.closure, 0.01, rtol=1e-9)
    error = found.spring_error_J / found.mill_work_J
    assert error > 0.0
    assert_allclose(found.closure_of_forces, 0.01 - error, rtol=1e-9)
    parts = found.ball_ball
    assert_allclose(
        parts.tangential_spring_J + parts.tangential_dashpot_J + parts.tangential_slip_J,
        parts.dissipated_tangential_J,
    )
    assert_allclose(
        found.dissipated_J, sum(found.pairings[pairing].dissipated_J for pairing in PAIRINGS)
    )


def test_a_shorter_rotation_counts_whole(ledger):
    short = {name: values[:300] for name, values in ledger.items()}
    assert energy_budget(short).from_rad == 0.0


def test_a_mill_at_rest_has_no_closure(ledger):
    for name, why in (("mill_angle_rad", "does not turn"), ("mill_work_J", "does no work")):
        with pytest.raises(ValueError, match=why):
            energy_budget(ledger | {name: np.zeros(901)})


def _impacts(path, rows):
    path.write_text(HEAD + "".join(f"{row}\n" for row in rows))


ROWS = ("1,3,ball_ball,0.1,1,0,0", "1,3,ball_ball,1,10,4,8", "1,3,ball_wall,1,10,6,9")


def test_impacts_are_those_of_a_revolution(tmp_path):
    _impacts(tmp_path / "impacts.csv", ROWS)
    found = impact_spectrum(tmp_path / "impacts.csv")
    assert found["ball_ball"].energy_low_J == (1.0,)
    assert_allclose(found["ball_ball"].impacts, [4.0 * math.pi])
    assert_allclose(found["ball_wall"].energy_J, [9.0 * math.pi])


@pytest.mark.parametrize(
    ("rows", "cause"),
    [
        (ROWS[:2], "holds no turned angle"),
        ((*ROWS[:2], "1,3,ball_wall,1,10,6"), "a row is not whole"),
        ((*ROWS[:2], "3,3,ball_wall,1,10,6,9"), "holds no turned angle"),
    ],
    ids=["missing", "cut", "no angle"],
)
def test_impacts_that_are_not_whole_are_refused(tmp_path, rows, cause):
    _impacts(tmp_path / "impacts.csv", rows)
    with pytest.raises(RunFolderError, match=cause):
        impact_spectrum(tmp_path / "impacts.csv")


def test_a_case_with_an_account_has_it_in_its_result(tmp_path, ledger):
    folder = write_charge(tmp_path, "constant-gravity")
    assert "ledger" not in analyse_case(folder)
    case = json.loads((folder / "case.json").read_text())
    (folder / "case.json").write_text(json.dumps(case | {"deck": case["deck"] | {"ledger": "on"}}))
    with pytest.raises(RunFolderError, match=r"ledger\.csv"):
        analyse_case(folder)
    write_series(folder / "ledger.csv", ledger)
    _impacts(folder / "impacts.csv", ROWS)
    result = analyse_case(folder)["ledger"]
    assert result["closure"] == pytest.approx(0.01, rel=1e-6)
    assert set(result["impacts"]) == set(PAIRINGS)


def test_the_figure_shows_every_cause_as_a_share_of_the_work(ledger, tmp_path):
    _impacts(tmp_path / "impacts.csv", ROWS)
    found = replace(energy_budget(ledger), impacts=impact_spectrum(tmp_path / "impacts.csv"))
    causes, spectrum = energy_budget_figure(found).axes
    drawn = sum(bar.get_width() for bar in causes.patches)
    # The dissipation by cause is the dissipation by direction.
    assert drawn == pytest.approx(100.0 * found.dissipated_J / found.mill_work_J)
    assert [line.get_ydata().tolist() for line in spectrum.lines] == [
        list(found.impacts[pairing].energy_J) for pairing in PAIRINGS
    ]


def test_the_figure_without_impacts_has_a_note(ledger):
    impacts = dict.fromkeys(PAIRINGS, ImpactSpectrum((), (), (), ()))
    found = replace(energy_budget(ledger), impacts=impacts)
    assert [text.get_text() for text in energy_budget_figure(found).axes[1].texts] == ["no impacts"]


def test_the_report_of_a_case_with_an_account_has_the_figure(tmp_path, ledger):
    folder = write_charge(tmp_path, "constant-gravity")
    case = json.loads((folder / "case.json").read_text())
    (folder / "case.json").write_text(json.dumps(case | {"deck": case["deck"] | {"ledger": "on"}}))
    write_series(folder / "ledger.csv", ledger)
    _impacts(folder / "impacts.csv", ROWS)
    finish_case(folder)
    images = charge_images(Charge(load_finished(folder), ""), tmp_path)
    assert [image.path.name for image in images.series][-1] == f"{folder.name}-ledger.png"
