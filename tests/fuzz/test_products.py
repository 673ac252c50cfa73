"""Changed files of a finished run are named, refused, or change no number."""

import json
import shutil
from functools import cache
from pathlib import Path

import pytest
from attempts import WrongNumberError
from hypothesis import strategies as st
from mutations import as_json, damaged, documents, hostile
from trials import NUMBERS, run

from millscale.analysis.finished_campaign import load_campaign
from millscale.runs.digests import digest_of, files_of
from millscale.runs.provenance import read_provenance, write_provenance
from synthetic_ball import usual_motion
from synthetic_case import case_document, finish_case, timing_document, write_campaign, write_case
from synthetic_charge import write_charge

SCHEME = "constant-gravity"


def finished(folder):
    """Two single balls and a charge, with every product that the report reads."""
    folders = []
    for S in (1.0, 2.6):
        case = case_document("single-ball", SCHEME, "paper", S, sample_angle=0.05)
        folders.append(write_case(folder, case, usual_motion(case).series()))
    folders.append(write_charge(folder, SCHEME))
    (folders[-1] / "settled.json").write_text(json.dumps(timing_document(1, 100)))
    for case_folder in folders:
        finish_case(case_folder)
    # As the stage records them.
    stages = read_provenance(folders[-1])
    stages["rotate"]["products"] |= {
        name: digest_of(folders[-1] / name) for name in files_of(folders[-1], ["dump"])
    }
    write_provenance(folders[-1], stages)
    write_campaign(folder, [x.name for x in folders])
    return folder


def numbers(runs):
    """Return every number of results.json with its place, and the text of the file."""
    text = json.dumps(load_campaign(runs).results(), allow_nan=False)
    return dict(_numbers(json.loads(text))), text


def _numbers(value, place=()):
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _numbers(inner, (*place, key))
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from _numbers(inner, (*place, i))
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield place, value


@pytest.mark.parametrize("number", NUMBERS)
def test_no_number_is_derived_from_a_changed_product(tallies, number, tmp_path):
    good = finished(tmp_path / "good")
    files = sorted(str(x.relative_to(good)) for x in good.glob("cases/**/*") if x.is_file())
    originals = {name: (good / name).read_bytes() for name in files}

    def kinds(name):
        some = [damaged([originals[name]]), hostile()]
        if name.endswith(".json"):
            some.append(documents([json.loads(originals[name])]).map(as_json))
        return st.tuples(st.just(name), st.one_of(some))

    @cache
    def accepted(name):
        """Numbers of the run as it was, without the file, and without its case."""
        found = [numbers(good)[0]]
        for gone in (name, f"cases/{name.split('/')[1]}/result.json"):
            runs = shutil.copytree(good, tmp_path / "less")
            (runs / gone).unlink()
            found.append(numbers(runs)[0])
            shutil.rmtree(runs)
        return found

    def read(folder, data):
        name, content = data
        runs = shutil.copytree(good, folder / "runs")
        (runs / name).write_bytes(content)
        found, text = numbers(runs)
        clean = accepted(name)[0]
        if not any(found.items() <= known.items() for known in accepted(name)):
            wrong = [x for x in found if clean.get(x) != found[x]][:3]
            numbers_of = [(x, clean.get(x), found[x]) for x in wrong]
            raise WrongNumberError(f"place, clean, found: {numbers_of}")
        if found != clean and Path(name).name not in text:
            raise WrongNumberError("numbers are left out, the file is not named")

    for name in files:
        accepted(name)
    inputs = st.sampled_from(files).flatmap(kinds)
    run(tallies, "products of a run", number, inputs, read, tmp_path)
