"""The keys of results.json and speed-against-error.json are those that the reference describes."""

from millscale.analysis.finished_campaign import load_campaign
from millscale.analysis.measures import NUMBERS
from reference_tables import documented
from synthetic_rows import row

RESULTS = "report/results.json"


def test_results_and_rows_of_single_balls_are_documented(runs):
    results = load_campaign(runs).results()
    assert set(results) == set(documented(RESULTS))
    keys = set(documented(RESULTS, 1))
    assert all(set(row) == keys for row in results["single_ball"])


def test_rows_of_charges_are_documented(throws):
    comparison = load_campaign(throws).comparison
    keys = set(documented(RESULTS, 2))
    assert all(set(row.document()) == keys for row in comparison.rows)
    numbers = documented(RESULTS, 3)
    assert numbers == [number.name for number in NUMBERS]
    assert all(set(row.numbers) == set(numbers) for row in comparison.rows)


def test_rows_of_parameter_studies_are_documented():
    keys = set(documented("study.json, speed-against-error.json"))
    assert {"study", *row("a", 1.0, 0.1).document()} == keys
