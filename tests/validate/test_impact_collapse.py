"""Impact spectra of several S: ratios by decade, their spread over seeds, and the page."""

import json
import math

import numpy as np
import pytest

from in_process import millscale
from millscale.runs.untrusted import RunFolderError
from millscale.validate.impact_collapse import collapse
from synthetic_case import finish_case, write_campaign, write_case
from synthetic_impacts import DURATION, write_spectra
from synthetic_mills import charge_case, columns_of

# Share of the contacts with the higher energy that a charge has, by S and seed.
STRONG = {(1.0, 1): 1.0, (1.696, 1): 1.0, (2.6, 1): 0.5, (2.6, 2): 0.4, (2.6, 3): 0.6}


def counted(S):
    """Return the contacts of a decade that a charge of S records, a share of 1."""
    return 5.0 * round(20_000 / S**3) * DURATION * math.sqrt(S) / math.tau


def write_charges(runs, strong=None, scheme="constant-gravity"):
    """Write a runs folder of charges with spectra; return it."""
    names = []
    for (S, seed), share in (strong or STRONG).items():
        case = charge_case(S, seed, scheme)
        case["deck"]["impacts"] = "on"
        folder = write_case(runs, case, columns_of(case, torque=lambda S, seed: 0.36))
        write_spectra(folder, case, 5.0 * case["ball"]["count"], share)
        finish_case(folder)
        names.append(folder.name)
    write_campaign(runs, names)
    return runs


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    return write_charges(tmp_path_factory.mktemp("runs"))


def test_ratios_by_decade_have_the_error_of_the_seeds(runs):
    found = collapse([runs])
    assert [mill["S"] for mill in found["mills"]] == [1.0, 1.696, 2.6]
    assert found["mills"][2]["seeds"] == [1, 2, 3]
    assert len(found["spectra"]) == 6
    for spectrum in (x for x in found["spectra"] if x["per"] == "ball"):
        weak, strong = spectrum["decades"]
        assert (weak["low"], strong["low"]) == pytest.approx((1e-4, 1e-3))
        assert (weak["share"], strong["share"]) == pytest.approx((1 / 11, 10 / 11))
        like, unlike = strong["mills"]
        assert like["alike"] and like["ratio"] == pytest.approx(1.0)
        # A single seed has the error of its count, as the reference has.
        of_count = [1.0 / counted(S) for S in (1.0, 1.696)]
        assert like["error"] == pytest.approx(math.sqrt(sum(of_count)))
        assert not unlike["alike"] and unlike["ratio"] == pytest.approx(0.5)
        expected = math.hypot(0.1 / math.sqrt(3), 0.5 * math.sqrt(of_count[0]))
        assert unlike["error"] == pytest.approx(expected)
        assert weak["mills"][1]["alike"]
        assert spectrum["alike_shares"] == pytest.approx([1.0, 1 / 11])
        assert spectrum["all"][1]["ratio"] == pytest.approx((1 + 10 * 0.5) / 11)
        curve = spectrum["curves"][2]
        for name, share in (("mean", 0.5), ("least", 0.4), ("most", 0.6)):
            assert curve[name][1] == pytest.approx(share * spectrum["curves"][0]["mean"][1])


def test_contacts_with_the_liner_are_compared_per_area_as_well(runs):
    found = collapse([runs])["spectra"]
    per_ball, per_area = ([x for x in found if x["per"] == per] for per in ("ball", "area"))
    assert {x["pairing"] for x in per_area} == {"ball_wall"}
    for one in per_area:
        (other,) = (x for x in per_ball if x["pairing"] == "ball_wall"
                    and x["quantity"] == one["quantity"])  # fmt: skip
        for a, b in zip(one["all"], other["all"], strict=True):
            assert a["ratio"] == pytest.approx(b["ratio"] / a["S"])


def test_a_wide_scatter_of_the_seeds_hides_a_difference(tmp_path):
    strong = {(1.0, 1): 1.0, (2.6, 1): 0.5, (2.6, 2): 1.1}
    found = collapse([write_charges(tmp_path, strong)])
    (of,) = found["spectra"][0]["decades"][1]["mills"]
    assert of["ratio"] == pytest.approx(0.8) and of["alike"]


def test_few_contacts_are_not_compared(tmp_path):
    strong = {(1.0, 1): 1.0, (2.6, 1): 99.0 / counted(2.6)}
    found = collapse([write_charges(tmp_path, strong)])
    (of,) = found["spectra"][0]["decades"][1]["mills"]
    assert of["ratio"] is None and not of["alike"]


def test_the_command_writes_page_numbers_and_figure(runs, tmp_path):
    done = millscale("validate", "impact-collapse", runs, "--docs", tmp_path)
    assert done.returncode == 0, done.stderr
    results = tmp_path / "results"
    page = (results / "impact-collapse.md").read_text()
    assert done.stdout.strip() == page.strip()
    document = json.loads((results / "impact-collapse.json").read_text())
    assert str(runs) not in json.dumps(document)
    assert (results / "impact-collapse.png").stat().st_size > 1000
    unit = document["mills"][0]["energy_unit_J"]
    row = f"| 1e-03 | {1e-3 * document['mills'][0]['froude']:.1e} | {1e-3 * unit:.1e} | 90.9 |"
    assert page.count(row) == 6
    assert page.count("| **1.00 ± 0.0") >= 8 and "| 0.50 ± 0.06 |" in page
    assert "| dissipated | ball on ball | 100 | **1.00 ± 0.01** | 9 | 0.55 ± 0.05 |" in page
    assert np.isclose(document["mills"][2]["froude"], document["mills"][0]["froude"], rtol=1e-2)


def test_mills_that_cannot_be_compared_are_refused(runs, tmp_path):
    one = write_charges(tmp_path / "one", {(2.6, 1): 1.0})
    with pytest.raises(RunFolderError, match="fewer than two S"):
        collapse([one])
    other = write_charges(tmp_path / "other", {(2.6, 1): 1.0}, "constant-speed")
    with pytest.raises(RunFolderError, match="several kinds"):
        collapse([runs, other])
    with pytest.raises(RunFolderError, match="given twice"):
        collapse([runs, runs])
