"""The table of stages is one chain."""

import pytest

from millscale.runs.layout import CASE_FILE, STAGES


@pytest.fixture(params=sorted(STAGES))
def kind(request):
    return request.param


def test_every_stage_reads_a_product_of_the_one_before(kind):
    for before, stage in zip(STAGES[kind], STAGES[kind][1:], strict=False):
        assert set(before.products) & set(stage.inputs), stage.name


def test_every_input_is_made_before_it_is_read(kind):
    made = {CASE_FILE}
    for stage in STAGES[kind]:
        assert set(stage.inputs) <= made, stage.name
        made.update(stage.products)
