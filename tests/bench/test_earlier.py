"""Comparison with an earlier bench: verdicts on ratios that are known, and results it refuses."""

import json

import numpy as np
import pytest
from scipy.stats import ttest_ind

from in_process import millscale
from millscale.bench.earlier import compared, read_earlier
from millscale.bench.engines import Phases
from millscale.bench.machine_kind import kind_of
from millscale.bench.state import State
from millscale.runs.untrusted import RunFolderError

V3, V4 = "avx avx2 fma bmi2", "avx512f avx512bw avx512cd avx512dq avx512vl"
# Times over their median, of rounds on a quiet machine; of stock, and of ours in two precisions.
ROUNDS = np.array([0.99, 1.0, 1.01, 0.995, 1.005])
OTHER_ROUNDS = np.array([1.004, 0.991, 1.0, 1.009, 0.996])


@pytest.fixture(autouse=True)
def of_one_kind(monkeypatch):
    monkeypatch.setattr("millscale.bench.earlier.machine_kind", lambda: "AVX2")


def rows(double=80.0, mixed=70.0, pace=1.0, scene="s2.6", balls=13370):
    """Rows of a bench whose stock step takes 400 ns.

    Args:
        pace: of the machine, time over that of a quiet one; a number, or one for each round.
    """
    times = {
        ("millscale", "fast"): double * ROUNDS,
        ("millscale", "mixed"): mixed * OTHER_ROUNDS[::-1],
        ("liggghts", "stock"): 400.0 * OTHER_ROUNDS,
    }
    return [
        {"scene": scene, "engine": engine, "pair": pair, "balls": balls, "ranks": 1,
         "wall": "analytic", "repeats": (pace * each).tolist()}
        for (engine, pair), each in times.items()
    ]  # fmt: skip


def document(of_rows, kind="AVX2"):
    machine = {"cpu": "a processor", "cores": 2, "available_cores": 2}
    made = {"command": "millscale bench", "commit": "abc", "date": "2026-11-30", "machine": machine}
    return {"schema": 1, "machine_kind": kind, "rows": of_rows, "provenance": made}


def written(tmp_path, content):
    file = tmp_path / "earlier.json"
    file.write_text(content if isinstance(content, str) else json.dumps(content))
    return file


def changes(tmp_path, now, before):
    file = written(tmp_path, document(before))
    return compared(now, read_earlier(file, "s2.6"), file)


@pytest.mark.parametrize(
    ("double", "verdict"), [(80.0, "no difference"), (84.0, "slower"), (76.0, "faster")]
)
def test_a_change_of_a_twentieth_is_found_and_none_where_there_is_none(tmp_path, double, verdict):
    found = changes(tmp_path, rows(double=double), rows())
    of_double, of_mixed = found["changes"]
    assert (of_double["precision"], of_double["verdict"]) == ("double", verdict)
    assert (of_mixed["precision"], of_mixed["verdict"]) == ("mixed", "no difference")
    assert of_double["change"] == pytest.approx(80.0 / double - 1.0)
    assert of_double["low"] < 80.0 / double - 1.0 < of_double["high"]
    assert f"s2.6 double {verdict}" in found["summary"] and "\n" not in found["summary"]


def test_the_pace_of_the_machine_cancels(tmp_path):
    quiet = changes(tmp_path, rows(84.0), rows())["changes"]
    busy = changes(tmp_path, rows(84.0, pace=np.array([3, 1, 2, 5, 1])), rows(pace=0.5))["changes"]
    for a, b in zip(quiet, busy, strict=True):
        assert [b[key] for key in ("now", "before", "low", "high")] == pytest.approx(
            [a[key] for key in ("now", "before", "low", "high")]
        )


def test_the_interval_is_that_of_welch(tmp_path):
    now, before = rows(84.0), rows()
    of_double = changes(tmp_path, now, before)["changes"][0]
    ratios = [np.divide(x[2]["repeats"], x[0]["repeats"]) for x in (now, before)]
    naive = ttest_ind(*map(np.log, ratios), equal_var=False).confidence_interval(0.95)
    assert np.log1p([of_double["low"], of_double["high"]]) == pytest.approx([*naive], rel=1e-9)
    assert of_double["range_now"] == pytest.approx([ratios[0].min(), ratios[0].max()])


def test_wide_rounds_are_no_difference(tmp_path):
    wide = rows(88.0)
    wide[0]["repeats"] = [60.0, 120.0, 90.0, 70.0, 100.0]
    assert changes(tmp_path, wide, rows())["changes"][0]["verdict"] == "no difference"


@pytest.mark.parametrize(
    ("content", "cause"),
    [
        (document(rows(), "AVX-512"), "measured with AVX-512, this machine has AVX2"),
        (document(rows(scene="s1")), "is of scene s1, not of s2.6"),
        (document([]), r"is of scene \(no rows\)"),
        (document(rows()[:2]), "has no row of stock LIGGGHTS for scene s2.6"),
        (json.dumps(document(rows()))[:-40], "not valid JSON"),
        ("[]", "accepted"),
        ({k: v for k, v in document(rows()).items() if k != "machine_kind"}, "machine_kind"),
        (document([x | {"repeats": [1.0, 2.0]} for x in rows()]), "2 rounds; at least 3"),
        (document([x | {"repeats": [1.0, 0.0, 2.0]} for x in rows()]), "> 0"),
        (document([rows()[0] | {"repeats": [1.0] * 4}, *rows()[1:]]), "unequal rounds"),
    ],
)
def test_an_earlier_result_that_cannot_be_compared_is_refused(tmp_path, content, cause):
    with pytest.raises(RunFolderError, match=cause):
        read_earlier(written(tmp_path, content), "s2.6")


def test_another_mill_of_the_same_scene_is_refused(tmp_path):
    with pytest.raises(RunFolderError, match=r"has no row of s2\.6, fast, 13370 balls, 1 rank"):
        changes(tmp_path, rows(), rows(balls=1020))


@pytest.mark.parametrize(
    ("scene", "cause"),
    [("s2.6", "measured with AVX-512"), ("campaign", "--compare: got scene campaign; accepted")],
)
def test_a_refused_comparison_is_one_line_and_times_nothing(tmp_path, monkeypatch, scene, cause):
    monkeypatch.setattr("millscale.bench.command._measured", lambda *_: pytest.fail("timed"))
    file = written(tmp_path, document(rows(), "AVX-512"))
    done = millscale("bench", "--scene", scene, "--compare", file, "--runs", tmp_path / "runs")
    assert done.returncode == 2 and cause in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.parametrize("as_json", [False, True])
def test_a_slower_build_ends_with_a_line_and_code_0(tmp_path, monkeypatch, as_json):
    """Timing itself is replaced: each engine has the times of `rows`."""
    now = rows(84.0)
    state = State({}, tmp_path, tmp_path, 0.0, 13370)
    timed = [[Phases(ns, 0.0, 0.0, 0.0, ns) for ns in row["repeats"]] for row in now]
    monkeypatch.setattr("millscale.bench.command.prepare", lambda *_: state)
    monkeypatch.setattr("millscale.bench.command.interleaved", lambda *_: timed)
    file = written(tmp_path, document(rows()))
    done = millscale("bench", "--compare", file, *(["--json"] if as_json else []))
    assert done.returncode == 0, done.stderr
    words = "s2.6 double slower, -4.8 %"
    if as_json:
        made = json.loads(done.stdout)
        assert words in made["compared"]["summary"]
        assert made["compared"]["with"]["file"] == "earlier.json"
        file.write_text(done.stdout)
        monkeypatch.setattr("millscale.bench.earlier.machine_kind", lambda: made["machine_kind"])
        assert read_earlier(file, "s2.6").rows[0].repeats == tuple(now[0]["repeats"])
    else:
        assert words in done.stdout.splitlines()[-1]


@pytest.mark.parametrize(
    ("flags", "kind"), [(V3, "AVX2"), (f"{V3} {V4}", "AVX-512"), (V4, "scalar"), ("sse2", "scalar")]
)
def test_the_kind_of_a_machine_follows_from_its_flags(flags, kind):
    assert kind_of(set(flags.split())) == kind
