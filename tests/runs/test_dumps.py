"""LIGGGHTS custom dumps."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.runs.digests import digest_of
from millscale.runs.dumps import dump_files, read_dump
from millscale.runs.provenance import write_provenance
from millscale.runs.untrusted import RunFolderError
from synthetic_charge import block, write_dump

BALLS = 12


@pytest.fixture
def dump_path(case, tmp_path):
    (tmp_path / "dump").mkdir()
    path = tmp_path / "dump/charge.000000500.liggghts"
    write_dump(path, 500, block(case, BALLS), case)
    return path


def test_balls_are_in_order_of_id_whatever_the_order_in_the_file(case, dump_path):
    dump = read_dump(dump_path)
    assert dump.step == 500
    assert len(dump) == BALLS
    assert np.array_equal(dump["id"], np.arange(1, BALLS + 1))
    assert_allclose(dump.positions, block(case, BALLS), rtol=1e-8)
    assert_allclose(dump["radius"], case["ball"]["radius_m"])


def test_a_dump_that_its_stage_did_not_make_is_refused(case, dump_path, tmp_path):
    digest, name = digest_of(dump_path), f"dump/{dump_path.name}"
    write_provenance(tmp_path, {"rotate": {"inputs": {}, "products": {name: digest}}})
    assert read_dump(dump_path).step == 500
    other = dump_path.with_name("charge.000000700.liggghts")
    write_dump(other, 700, block(case, BALLS), case)
    write_dump(dump_path, 500, 0.99 * block(case, BALLS), case)
    for path in (dump_path, other):
        with pytest.raises(RunFolderError, match="not the dump that stage rotate made"):
            read_dump(path)


def test_dumps_are_in_order_of_step_not_of_name(tmp_path):
    (tmp_path / "dump").mkdir()
    for name in ("charge.1000.liggghts", "charge.200.liggghts", "charge.30.vtk", "notes.txt"):
        (tmp_path / "dump" / name).touch()
    assert list(dump_files(tmp_path)) == [200, 1000]


@pytest.mark.parametrize(("kept", "cause"), [(0.7, "12 announced: cut"), (0.02, "header")])
def test_cut_dump_is_refused(dump_path, kept, cause):
    text = dump_path.read_text()
    dump_path.write_text(text[: int(kept * len(text))])
    with pytest.raises(RunFolderError, match=cause):
        read_dump(dump_path)


def test_last_line_cut_is_refused(dump_path):
    dump_path.write_text(dump_path.read_text().rstrip().rsplit(" ", 1)[0])
    with pytest.raises(RunFolderError, match="cut short"):
        read_dump(dump_path)


def test_two_frames_in_one_file_are_refused(dump_path):
    dump_path.write_text(2 * dump_path.read_text())
    with pytest.raises(RunFolderError, match="12 announced: cut short, or two frames"):
        read_dump(dump_path)


def test_missing_column_is_named(dump_path):
    dump_path.write_text(dump_path.read_text().replace(" radius \n", " mass \n"))
    with pytest.raises(RunFolderError, match=r"no column radius; got 'ITEM: ATOMS id"):
        read_dump(dump_path)


def test_a_missing_dump_is_reported_with_the_next_command(tmp_path):
    with pytest.raises(RunFolderError, match=r"no such file; .*millscale run"):
        read_dump(tmp_path / "charge.1.liggghts")


@pytest.mark.parametrize(
    ("old", "new", "cause"),
    [
        ("\n11 1 ", "\n12 1 ", "id 12 is there twice"),
        ("\n11 1 ", "\n0 1 ", "id 0, accepted: whole numbers from 1"),
        ("\n11 1 ", "\n10.5 1 ", "id 10.5, accepted: whole numbers from 1"),
        (" 0.05 \n1 1", " 0 \n1 1", "radius 0 of id 2, accepted: above 0"),
        (" 0.05 \n1 1", " -0.05 \n1 1", "radius -0.05 of id 2, accepted: above 0"),
        (" 0.05 \n1 1", " nan \n1 1", "not finite"),
        (" 0.05 \n1 1", " 1e999 \n1 1", "not finite"),
        ("TIMESTEP\n500", "TIMESTEP\n400", "holds step 400"),
    ],
)
def test_impossible_balls_are_refused(case, dump_path, old, new, cause):
    text = dump_path.read_text()
    old = old.replace("0.05", f"{case['ball']['radius_m']:g}")
    assert text.count(old) == 1
    dump_path.write_text(text.replace(old, new))
    with pytest.raises(RunFolderError, match=cause):
        read_dump(dump_path)


def test_a_name_whose_step_is_no_number_is_no_dump(tmp_path):
    (tmp_path / "dump").mkdir()
    (tmp_path / "dump/charge.².liggghts").touch()
    assert dump_files(tmp_path) == {}
