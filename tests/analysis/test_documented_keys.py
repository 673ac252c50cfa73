"""The keys of results.json and speed-against-error.json are those that the reference describes."""

from dataclasses import fields

from millscale.analysis.case import analyse_case
from millscale.analysis.finished_campaign import load_campaign
from millscale.analysis.measures import NUMBERS
from millscale.analysis.result_file import ChargeResult
from reference_tables import documented
from synthetic_rows import row

RESULTS = "report/results.json"
# Of result.json, where a campaign asks for it.
ABSENT = {"ledger", "ends", "segregation", "liner_loads", "impacts"}


def top_level(*tables):
    """Return the keys of result.json that some of its tables describe, without those inside."""
    names = [name.split()[0] for table in tables for name in documented("result.json", table)]
    return {name for name in names if not name.startswith(".")}


def test_result_files_are_documented(folder, runs):
    assert set(analyse_case(folder)) == top_level(0, 1)
    charge = load_campaign(runs).charges[0]
    assert set(analyse_case(charge.folder)) == top_level(0, 2) - ABSENT
    assert {field.name for field in fields(ChargeResult)} <= top_level(0, 2)


def test_results_and_rows_of_single_balls_are_documented(runs):
    results = load_campaign(runs).results()
    assert set(results) == set(documented(RESULTS))
    keys = set(documented(RESULTS, 1))
    assert all(set(row) == keys for row in results["single_ball"])


def test_rows_of_charges_are_documented(throws):
    comparison = load_campaign(throws).comparison
    keys = set(documented(RESULTS, 2)) - {"state"}  # of a campaign of several states alone
    assert all(set(row.document()) == keys for row in comparison.rows)
    numbers = documented(RESULTS, 3)
    assert numbers == [number.name for number in NUMBERS]
    assert all(set(row.numbers) == set(numbers) for row in comparison.rows)


def test_rows_of_parameter_studies_are_documented():
    keys = set(documented("study.json, speed-against-error.json"))
    assert {"study", *row("a", 1.0, 0.1).document()} == keys
