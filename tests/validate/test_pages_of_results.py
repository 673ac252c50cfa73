"""The pages of docs/results are those that the present code makes of their JSON files."""

import json
from pathlib import Path

import pytest

import contact_table
from millscale.validate import hard_cases_page, time_step_page, torque

RESULTS = Path(__file__).parents[2] / "docs/results"


def of(file):
    return json.loads((RESULTS / file).read_text(encoding="utf-8"))


PAGES = {
    "contact-tests.md": lambda: contact_table.page(of("contact-tests.json")),
    "hard-cases.md": lambda: hard_cases_page.page(of("hard-cases.json")),
    "time-step.md": lambda: time_step_page.page(of("time-step.json")),
    "torque.md": lambda: torque.page(of("torque.json"), of("sampling.json")),
}


@pytest.mark.parametrize("name", PAGES)
def test_a_page_is_the_one_its_json_file_gives(name):
    assert (RESULTS / name).read_text(encoding="utf-8") == PAGES[name]()
