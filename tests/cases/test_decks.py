"""Which deck files a case needs."""

from millscale.cases.decks import copy_decks, template_folder, with_included
from millscale.runs.layout import STAGES


def test_included_decks_are_found_through_each_other(tmp_path):
    (tmp_path / "a.in").write_text("include parameters.in\ninclude b.in\n# include no.in\n")
    (tmp_path / "b.in").write_text("run 1\n  include   c.in # why\n")
    (tmp_path / "c.in").write_text("include b.in\n")
    assert with_included(("a.in",), tmp_path) == ["a.in", "b.in", "c.in"]


def test_the_decks_of_every_stage_are_among_the_templates(tmp_path):
    decks = tuple(stage.deck for stages in STAGES.values() for stage in stages if stage.deck)
    copy_decks(decks, tmp_path)
    assert set(decks) <= {path.name for path in tmp_path.iterdir()}
    for path in tmp_path.iterdir():
        assert path.read_text() == (template_folder() / path.name).read_text()
