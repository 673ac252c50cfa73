"""Stages that have to run and stale products, found by digests alone."""

import json
import os
import shutil
import subprocess
import time

import pytest

from millscale.runs import digests
from millscale.runs.case_digest import case_digest
from millscale.runs.current import unfinished, why_stale
from millscale.runs.digests import CACHE_FILE, Digests, digest_of
from millscale.runs.layout import CASE_FILE, STAGES
from millscale.runs.provenance import PROVENANCE_FILE, read_provenance, write_provenance

CASE = {"schema": 1, "id": "x", "S": 2.0, "warnings": ["a warning"]}
DECK = {"single-ball": "single_ball.in", "multi-ball": "mill.in"}


@pytest.fixture(params=sorted(STAGES))
def kind(request):
    return request.param


@pytest.fixture
def folder(tmp_path, kind):
    """A finished case."""
    folder = tmp_path / "case"
    folder.mkdir()
    (folder / CASE_FILE).write_text(json.dumps(CASE))
    for stage in STAGES[kind]:
        for name in stage.products:
            (folder / name).write_text(f"{stage.name} made {name}")
    record(folder, kind)
    return folder


def record(folder, kind):
    write_provenance(
        folder,
        {
            stage.name: {
                "case": case_digest(CASE),
                "inputs": {name: digest_of(folder / name) for name in stage.inputs},
                "products": {name: digest_of(folder / name) for name in stage.products},
            }
            for stage in STAGES[kind]
        },
    )


def left(folder, kind, **options):
    return [stage.name for stage, _ in unfinished(folder, kind, **options)]


def reasons(folder, kind):
    return {stage.name: reason for stage, reason in unfinished(folder, kind)}


def names_of(kind):
    return [stage.name for stage in STAGES[kind]]


def test_a_finished_case_has_nothing_left_and_is_not_stale(folder, kind):
    assert left(folder, kind) == [] and why_stale(folder, kind) == ""


def test_an_empty_folder_has_every_stage_left(tmp_path, kind):
    assert left(tmp_path, kind) == names_of(kind)


def test_any_missing_product_leaves_its_stage_and_all_later_ones(folder, kind):
    for number, stage in enumerate(STAGES[kind]):
        for product in stage.products:
            (folder / product).rename(folder / "away")
            assert left(folder, kind) == names_of(kind)[number:], product
            # The product was removed, not changed: products made from it may be used.
            assert why_stale(folder, kind) == "", product
            (folder / "away").rename(folder / product)


def test_any_changed_product_but_a_deck_leaves_its_stage_and_all_later_ones(folder, kind):
    for number, stage in enumerate(STAGES[kind]):
        for product in stage.products:
            before = (folder / product).read_bytes()
            (folder / product).write_bytes(before[::-1])
            if not product.endswith(".in"):
                assert left(folder, kind) == names_of(kind)[number:], product
                reason = f"{product} is not what stage {stage.name} made"
                assert reasons(folder, kind)[stage.name] == why_stale(folder, kind) == reason
            (folder / product).write_bytes(before)


def test_an_edited_deck_is_kept_and_leaves_the_stages_that_read_it(folder, kind):
    deck = DECK[kind]
    (folder / deck).write_text("edited")
    assert left(folder, kind) == ["rotate", "result"]
    reason = f"{deck} has changed since stage rotate read it"
    assert reasons(folder, kind)["rotate"] == why_stale(folder, kind) == reason


def test_an_edited_deck_that_is_included_counts_too(folder, kind):
    stages = read_provenance(folder)
    (folder / "integrate.in").write_text("included")
    stages["rotate"]["inputs"]["integrate.in"] = digest_of(folder / "integrate.in")
    write_provenance(folder, stages)
    assert left(folder, kind) == []
    (folder / "integrate.in").write_text("edited")
    assert left(folder, kind) == ["rotate", "result"]


def test_another_case_leaves_every_stage_unless_only_informing_keys_differ(folder, kind):
    (folder / CASE_FILE).write_text(json.dumps({**CASE, "warnings": ["other"]}, indent=4))
    assert left(folder, kind) == [] and why_stale(folder, kind) == ""
    (folder / CASE_FILE).write_text(json.dumps({**CASE, "S": 2.5}))
    assert left(folder, kind) == names_of(kind)
    assert why_stale(folder, kind) == "case.json has changed since stage mesh read it"


def test_a_case_about_to_change_leaves_every_stage(folder, kind):
    assert left(folder, kind, case_changed=True) == names_of(kind)


def test_a_product_without_a_record_is_not_done(folder, kind):
    (folder / PROVENANCE_FILE).unlink()
    assert left(folder, kind) == names_of(kind)
    assert why_stale(folder, kind) == "stage mesh has no record in provenance.json"


def test_a_record_without_the_digest_of_the_case_is_accepted(folder, kind):
    stages = read_provenance(folder)
    for stage in stages.values():
        del stage["case"]
    write_provenance(folder, stages)
    assert left(folder, kind) == []


@pytest.mark.parametrize("way", ["cp -r", "tar", "future", "past", "touched"])
def test_no_copy_and_no_date_changes_anything(folder, kind, way, tmp_path):
    """Every file gets another date, in another order than that of the stages."""
    copy = tmp_path / "copy"
    names = sorted(path.name for path in folder.iterdir())
    if way == "cp -r":
        subprocess.run(["cp", "-r", folder, copy], check=True)
    elif way == "tar":
        copy.mkdir()
        tar = tmp_path / "case.tar"
        subprocess.run(["tar", "-cf", tar, "-C", folder, *reversed(names)], check=True)
        subprocess.run(["tar", "-xmf", tar, "-C", copy], check=True)
    else:
        copy = folder
        begin = {"future": 4e9, "past": 1e9, "touched": time.time()}[way]
        for second, name in enumerate(reversed(names)):
            os.utime(copy / name, (begin + second, begin + second))
    assert left(copy, kind) == [] and why_stale(copy, kind) == ""
    # Equal and old dates do not hide a change either.
    (copy / CASE_FILE).write_text(json.dumps({**CASE, "S": 2.5}))
    for path in copy.iterdir():
        os.utime(path, (1e9, 1e9))
    assert left(copy, kind) == names_of(kind)


def test_a_digest_is_kept_and_never_used_for_another_file(tmp_path, monkeypatch):
    monkeypatch.setattr(digests, "RESTED_NS", 0)
    file, other = tmp_path / "a", tmp_path / "b"
    file.write_text("one")
    other.write_text("two")
    time.sleep(0.02)
    first = Digests(tmp_path).of("a")
    digests.keep(tmp_path)
    assert (tmp_path / CACHE_FILE).exists()
    digests._KNOWN.clear()
    read = []
    with monkeypatch.context() as patch:
        patch.setattr("hashlib.file_digest", lambda *a: read.append(a))
        assert Digests(tmp_path).of("a") == first and not read
    # Same name, size and date; another file.
    date = file.stat().st_mtime_ns
    os.utime(other, ns=(date, date))
    other.replace(file)
    assert Digests(tmp_path).of("a") == digest_of(file) != first
    # The same file, written in place, its date put back.
    file.write_text("six")
    os.utime(file, ns=(date, date))
    assert Digests(tmp_path).of("a") == digest_of(file)
    # A copy has the cache, and another inode.
    shutil.copytree(tmp_path, tmp_path / "copy")
    (tmp_path / "copy" / "a").write_text("ten")
    os.utime(tmp_path / "copy" / "a", ns=(date, date))
    assert Digests(tmp_path / "copy").of("a") == digest_of(tmp_path / "copy" / "a")


def test_a_file_that_has_not_rested_is_read_again(tmp_path):
    (tmp_path / "a").write_text("one")
    Digests(tmp_path).of("a")
    digests.keep(tmp_path)
    assert not (tmp_path / CACHE_FILE).exists()


@pytest.mark.parametrize("content", ["", "[]", '{"digests": {"a": 3}}', '{"digests": [1]}',
                                     '{"digests": {"a": ["x"]}}', "[" * 10**5, "\xff"])  # fmt: skip
def test_a_damaged_cache_is_no_cache(tmp_path, content):
    (tmp_path / "a").write_text("one")
    (tmp_path / CACHE_FILE).write_text(content, encoding="latin-1")
    assert Digests(tmp_path).of("a") == digest_of(tmp_path / "a")


def test_a_pipe_in_place_of_a_product_is_no_product(tmp_path):
    os.mkfifo(tmp_path / "a")
    (tmp_path / "b").mkdir()
    assert Digests(tmp_path).of("a") is None and Digests(tmp_path).of("b") is None
    (tmp_path / CACHE_FILE).unlink(missing_ok=True)
    os.mkfifo(tmp_path / CACHE_FILE)
    digests._KNOWN.clear()
    assert Digests(tmp_path).of("none") is None
