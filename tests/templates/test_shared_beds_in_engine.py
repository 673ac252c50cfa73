"""A bed settled for one scheme gives the results of one settled for another scheme."""

import shutil

import pytest

from millscale.cases.decks import copy_decks
from millscale.cases.parameters import write_parameters
from millscale.packing.charge import write_charge
from millscale.workflow.shared_settling import settling_key
from paper_campaign import cases
from scene import run_file

pytestmark = pytest.mark.engine

CHARGE = {
    "S": [1.0],
    "count": [4000],
    "slice_diameters": 2.5,
    "settle_s": 0.11,
    "rotation_angle_rad": 0.05,
    "step_s": 1e-4,
}


def prepared(folder, case):
    folder.mkdir()
    copy_decks(("settle.in", "mill.in"), folder)
    write_parameters(case, folder)
    write_charge(case, folder)
    (folder / "dump").mkdir()
    return folder


def run(folder, deck):
    done = run_file(folder, deck)
    assert done.code == 0, done.text[-2000:]


@pytest.mark.parametrize(
    ("scheme", "policies"), [("constant-speed", ["paper"]), ("constant-gravity", ["corrected"])]
)
def test_the_bed_of_another_case_leads_to_the_same_series(tmp_path, scheme, policies):
    def case_of(scheme, policies):
        return cases(
            tmp_path,
            single_ball=None,
            multi_ball=CHARGE,
            scaling__schemes=[scheme],
            scaling__policies=policies,
        )[0]

    one, other = case_of("constant-gravity", ["paper"]), case_of(scheme, policies)
    assert one.id != other.id
    giver, taker, own = (
        prepared(tmp_path / name, case)
        for name, case in (("giver", one), ("taker", other), ("own", other))
    )
    assert settling_key(one, giver) == settling_key(other, taker)
    run(giver, "settle.in")
    run(own, "settle.in")
    shutil.copy(giver / "settled.restart", taker)
    run(taker, "mill.in")
    run(own, "mill.in")
    # The restart file does not hold the scheme, so that the results are bit-identical.
    assert (taker / "series.csv").read_text() == (own / "series.csv").read_text()
    assert len((own / "series.csv").read_text().splitlines()) > 2
