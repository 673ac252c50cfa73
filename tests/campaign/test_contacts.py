"""Options of ball-ball contacts, and the keywords of the pair style they become."""

import pytest

from millscale.campaign.build import load_campaign
from millscale.campaign.contacts import ContactOptions
from millscale.errors import CampaignError
from paper_campaign import write_campaign


@pytest.mark.parametrize(
    ("options", "keywords"),
    [
        (ContactOptions("stock", "plain"), ""),
        (ContactOptions(), "surface fast tangential_damping bounded"),
        (ContactOptions(damping="plain", kernel=3), "surface fast tangential_damping on kernel 3"),
        (
            ContactOptions(precision="mixed", stock_history=True),
            "surface fast tangential_damping bounded memory stock precision mixed",
        ),
    ],
)
def test_options_become_keywords_of_the_pair_style(options, keywords):
    assert options.pair_style_words() == keywords


@pytest.mark.parametrize(
    ("model", "options"),
    [
        ({}, ContactOptions("fast", "bounded", "double")),
        ({"tangential_damping": "plain"}, ContactOptions("fast", "plain")),
        ({"precision": "mixed"}, ContactOptions(precision="mixed")),
        ({"contacts": "stock"}, ContactOptions("stock", "plain")),
        (
            {"contacts": "stock", "tangential_damping": "plain", "precision": "double"},
            ContactOptions("stock", "plain"),
        ),
    ],
)
def test_a_campaign_file_names_options(tmp_path, model, options):
    assert load_campaign(write_campaign(tmp_path, model=model)).contacts == options


@pytest.mark.parametrize(
    ("key", "value", "accepted"),
    [("tangential_damping", "bounded", "plain"), ("precision", "mixed", "double")],
)
def test_options_of_our_kernels_are_refused_with_those_of_liggghts(tmp_path, key, value, accepted):
    file = write_campaign(tmp_path, model={"contacts": "stock", key: value})
    with pytest.raises(CampaignError) as refused:
        load_campaign(file)
    assert refused.value.key == f"model.{key}"
    assert refused.value.cause == f'got "{value}" with contacts = "stock"'
    assert refused.value.accepted == f'"{accepted}", or contacts = "fast"'
