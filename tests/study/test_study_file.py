"""Study files: what they come to, and the errors of those that are not accepted."""

import shutil
import tomllib

import pytest

from millscale.campaign.build import load_campaign
from millscale.errors import CampaignError
from millscale.study.file import SETTING_KEYS, STUDY_KEYS, WITHOUT, load_study, toml_text
from millscale.study.plan import study_plan
from paper_campaign import CAMPAIGNS, REPOSITORY
from small_study import BASE, TEXT, write_study

STUDIES = sorted(CAMPAIGNS.glob("study-*.toml"))


def test_a_setting_is_the_base_with_what_it_changes(tmp_path):
    study = load_study(write_study(tmp_path))
    reference, default, same = study.settings
    assert study.name == "small-study"
    assert [setting.name for setting in study.settings] == ["reference", "default", "same"]
    assert (
        reference.campaign.contacts.damping == "plain"
        and default.campaign.contacts.damping == "bounded"
    )
    assert [case.time.step_s for case in reference.cases] == [5e-5, 5e-5]
    assert [case.time.step_s for case in default.cases] == [1e-4]
    assert {case.kind for setting in study.settings for case in setting.cases} == {"multi-ball"}
    assert same.campaign.ranks == 1 and same.about == "as the default"
    base = load_campaign(tmp_path / "small.toml")
    assert default.campaign.material == base.material


def test_the_file_of_a_setting_is_the_campaign_it_was_checked_as(tmp_path):
    for setting in load_study(write_study(tmp_path)).settings:
        file = tmp_path / f"{setting.name}.toml"
        file.write_text(setting.text())
        assert tomllib.loads(setting.text()) == setting.tree
        read = load_campaign(file)
        assert read.name == setting.name
        assert (read.parts, read.wall, read.contacts) == (
            setting.campaign.parts,
            setting.campaign.wall,
            setting.campaign.contacts,
        )


def test_text_of_every_kind_of_value_reads_back():
    tree = {
        "a": {"t": 'a "quoted" \\ µ', "n": 2.5e-05, "i": 3, "f": True, "l": [1.0, 2.0]},
        "b": {},
    }
    assert tomllib.loads(toml_text(tree)) == tree


def test_a_key_of_the_base_can_be_left_out(tmp_path):
    change = '\nwithout = ["multi_ball.count"]\nmulti_ball.filling = 0.1\n'
    study = load_study(write_study(tmp_path, TEXT + change))
    assert study.settings[2].campaign.parts[0].charge.filling == 0.1
    assert study.settings[1].campaign.parts[0].charge.counts == (200,)


ERRORS = {
    "no base": (
        ('base = "small.toml"', ""),
        "study.base: missing; accepted: a text (campaign file, from the folder of the study file)",
    ),
    "base that is not there": (
        ("small.toml", "absent.toml"),
        "absent.toml: no such file; accepted: a TOML file",
    ),
    "unknown part": (("[all]", "[every]"), "every: unknown section; accepted: all, setting, study"),
    "unknown key": (
        ('about = "a study', 'aboot = "a study'),
        "study.aboot: unknown key, nearest is about; accepted: about, base, default, name, "
        "reference",
    ),
    "reference that is no setting": (
        ('reference = "reference"', 'reference = "referense"'),
        'study.reference: got "referense", nearest is "reference"; accepted: a setting: '
        "reference, default, same",
    ),
    "default that is no setting": (
        ('default = "default"', 'default = "x"'),
        'study.default: got "x"; accepted: a setting: reference, default, same',
    ),
    "name given twice": (
        ('name = "same"', 'name = "default"'),
        'setting 3.name: "default" is given twice; accepted: a name of its own',
    ),
    "name that is no folder": (
        ('name = "same"', 'name = "../same"'),
        'setting 3.name: got "../same"; accepted: up to 64 lower-case letters, digits and single '
        "hyphens, such as step-1e-4",
    ),
    "no name": (
        ('name = "same"', ""),
        "setting 3.name: missing; accepted: a text (of the setting, lower-case letters, digits and "
        "hyphens)",
    ),
    "unknown section of a setting": (
        ("run.ranks", "runs.ranks"),
        "all.runs: unknown key, nearest is run; accepted: ball, campaign, liner, material, mill, "
        "model, multi_ball, run, scaling, wall",
    ),
    "unknown key of a setting": (
        ("multi_ball.step_s", "multi_ball.step_mm"),
        'setting "reference": multi_ball.step_mm: wrong unit',
    ),
    "a value out of range in another unit": (
        ("step_s = 5e-5", "step_us = -1"),
        'setting "reference": multi_ball.step_us: time step of the physical mill, or from the '
        'limits of the contact law: got -1; accepted: a number > 0 or "advised"',
    ),
    "a value out of range": (
        ("step_s = 5e-5", "step_s = -1"),
        'setting "reference": multi_ball.step_s: time step of the physical mill [s], or from the '
        'limits of the contact law: got -1; accepted: a number > 0 or "advised"',
    ),
    "a step that is refused": (
        ("step_s = 5e-5", "step_s = 5e-2"),
        'setting "reference": multi_ball.step_s: got 0.05 s =',
    ),
    "a section that is a value": (
        ("run.ranks = 1", "run = 1"),
        "all.run: got 1; accepted: a key of it, run.KEY = ...",
    ),
    "a key to leave out that is not there": (
        ("run.ranks = 1", 'without = ["multi_ball.counts"]'),
        'all.without: got "multi_ball.counts", which the base does not have; accepted: '
        "SECTION.KEY of the base",
    ),
    "a setting that is a value": (
        (TEXT[TEXT.index("[all]") :], "[setting]\nname = 1\n"),
        "setting: got no list; accepted: 2 to 1000 settings, each written [[setting]]",
    ),
    "one setting": (
        (TEXT[TEXT.index('[[setting]]\nname = "default"') :], ""),
        "setting: got 1; accepted: 2 to 1000 settings, each written [[setting]]",
    ),
}


@pytest.mark.parametrize("case", ERRORS, ids=lambda name: name.replace(" ", "-"))
def test_what_is_not_accepted_gives_one_line_that_says_what_where_and_what_would_be(tmp_path, case):
    (old, new), said = ERRORS[case]
    assert old in TEXT
    with pytest.raises(CampaignError) as error:
        load_study(write_study(tmp_path, TEXT.replace(old, new)))
    text = str(error.value)
    assert said in text
    assert "\n" not in text and str(tmp_path) in text


def test_a_base_without_a_charge_is_refused(tmp_path):
    file = write_study(tmp_path)
    (tmp_path / "small.toml").write_text(BASE.partition("[multi_ball]")[0])
    with pytest.raises(
        CampaignError, match=r"study.base: got small.toml, which has no .multi_ball"
    ):
        load_study(file)


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_a_shipped_study_is_accepted(path):
    study = load_study(path)
    assert study.name == path.stem.lower().replace(".", "-")
    assert study_plan(study, {})


def test_the_study_at_s_2_6_takes_less_than_an_hour_of_one_core():
    study = load_study(CAMPAIGNS / "study-S2.6.toml")
    rows = study_plan(study, {})
    assert 0.5 < sum(row["core_time_s"] for row in rows) / 3600.0 < 1.0
    assert {case["ranks"] for row in rows for case in row["cases"]} == {1}
    assert {case["S"] for row in rows for case in row["cases"]} == {2.6}
    reference = next(row for row in rows if row["is_reference"])
    steps = [case["time_step_s"] for row in rows for case in row["cases"]]
    assert reference["cases"][0]["time_step_s"] == min(steps)


def test_the_ladder_holds_the_cases_of_the_papers_campaigns():
    study = load_study(CAMPAIGNS / "study-ladder.toml")
    for name, campaign in (
        ("counts-of-table-10", "paper-multi-ball"),
        ("equal-filling", "multi-ball-equal-filling"),
    ):
        (setting,) = (setting for setting in study.settings if setting.name == name)
        assert setting.campaign.parts == load_campaign(CAMPAIGNS / f"{campaign}.toml").parts


def test_the_example_of_the_documentation_is_accepted_and_every_key_is_in_it(tmp_path):
    text = (REPOSITORY / "docs/guide/study.md").read_text(encoding="utf-8")
    file = tmp_path / "example.toml"
    example = text.partition("```toml\n")[2].partition("```")[0]
    shutil.copy(CAMPAIGNS / "paper-multi-ball.toml", tmp_path)
    file.write_text(example)
    assert [setting.name for setting in load_study(file).settings] == ["fine", "usual"]
    for key in (*STUDY_KEYS, *SETTING_KEYS, WITHOUT):
        assert f"`{key}`" in text
