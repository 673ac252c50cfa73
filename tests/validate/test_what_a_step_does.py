"""Effect of the time step: collisions, rows of the mill from a study, the page."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from msgspec.structs import replace

from millscale.validate.cases import CASES, base_campaign, mill_of
from millscale.validate.collision import PAIRS, SPEED, collide
from millscale.validate.deck import BACKENDS
from millscale.validate.time_step import EXACT, backend_of, mills
from millscale.validate.time_step_page import COLOURS, draw, page
from synthetic_case import case_document, typed

MILL = mill_of(CASES[0], base_campaign())


def by_the_law(share):
    """Mean restitution, dissipated share and largest overlap over a of the head-on collision in
    explicit steps of a share of the Rayleigh time."""
    a, young = MILL.radii[0], 0.5 * MILL.youngs_modulus / (1.0 - MILL.poisson_ratio**2)
    mass = 0.5 * 4.0 / 3.0 * np.pi * a**3 * MILL.density
    log = math.log(MILL.restitution[0])
    damping = -2.0 * math.sqrt(5.0 / 6.0) * log / math.hypot(log, math.pi)
    dt = share * MILL.rayleigh_time
    left, largest = [], []
    for phase in (np.arange(PAIRS) + 0.5) / PAIRS:
        gap, speed, deepest = phase * SPEED * dt, -SPEED, 0.0
        while gap <= 0.0 or speed < 0.0:
            gap += dt * speed
            overlap = max(-gap, 0.0)
            size = math.sqrt(0.5 * a * overlap)
            force = 4.0 / 3.0 * young * size * overlap
            force -= damping * math.sqrt(2.0 * young * size * mass) * speed
            speed += dt * force / mass
            deepest = max(deepest, overlap)
        left.append(speed / SPEED)
        largest.append(deepest / a)
    return np.mean(left), 1.0 - np.mean(np.square(left)), np.mean(largest)


@pytest.mark.engine
@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("share", [0.05, 0.2])
def test_a_collision_realises_what_explicit_steps_of_the_law_do(tmp_path, backend, share):
    found = collide(tmp_path / "c", MILL, backend, share * MILL.rayleigh_time, oblique=False)
    # Some ten roundings of a number in single precision, 6e-8; in double those of the dump.
    rounding = 1e-6 if backend == "mixed" else 1e-10
    assert (found.restitution, found.dissipated, found.peak_overlap) == pytest.approx(
        by_the_law(share), rel=0.0, abs=rounding
    )


@pytest.mark.engine
def test_friction_takes_at_most_what_sliding_to_rolling_takes(tmp_path):
    """Half of the energy is along the normal; sliding that ends in rolling takes 2/7 of the other
    half."""
    found = collide(tmp_path / "c", MILL, "plain", EXACT * MILL.rayleigh_time, oblique=True)
    assert found.restitution is None
    least = 0.5 * (1.0 - MILL.restitution[0] ** 2)
    assert least < found.dissipated < least + 0.5 * 2.0 / 7.0


def test_balls_still_in_contact_are_reported(tmp_path, monkeypatch):
    monkeypatch.setattr("millscale.validate.collision.LOSSY", 0.2)
    with pytest.raises(RuntimeError, match="still touch"):
        collide(tmp_path / "c", MILL, "plain", 0.1 * MILL.rayleigh_time, oblique=False)


def case(step, surface="fast", damping="bounded", wall="analytic", **deck):
    document = case_document("multi-ball", "constant-gravity", "paper", 2.6)
    document["deck"] |= {"surface": surface, "tangential_damping": damping, **deck}
    document["wall"] |= {"kind": wall, "chord_error_m": 1e-4, "curvature_deg": 1.0}
    document["time"] |= {
        "step_s": step,
        "rayleigh_fraction": step / 7e-4,
        "limit_fraction": step / 1e-4,
        "steps_per_contact": 1.4e-3 / step,
    }
    return typed(document)


@pytest.mark.parametrize(
    ("document", "backend"),
    [
        (case(1.0), "default"),
        (case(1.0, precision="mixed"), "mixed"),
        (case(1.0, damping="plain"), "plain"),
        (case(1.0, surface="default", wall="mesh"), "stock"),
        (case(1.0, surface="default"), None),
        (case(1.0, wall="mesh"), None),
    ],
)
def test_the_backend_of_a_case_follows_from_its_contacts_and_wall(document, backend):
    assert backend_of(document) == backend


def error(value):
    return {"error": value, "spread": 0.01, "within_spread": False}


@pytest.fixture
def study(tmp_path, monkeypatch):
    """A study of four settings, two of them seeds 1 and 2; `soft` differs in more than its step."""
    soft = case(4e-4)
    soft = replace(soft, material=replace(soft.material, youngs_modulus_pa=1.5e7))
    settings = {
        "fine": (case(2.5e-5, damping="plain"), (1.0, 1.2)),
        "usual": (case(2e-4), (1.3, 1.3)),
        "stock": (case(1e-4, surface="default", damping="plain", wall="mesh"), (0.88,)),
        "soft": (soft, (5.0,)),
    }
    content = {"reference": "fine", "settings": []}
    finished, rows = {}, []
    for name, (document, values) in settings.items():
        folders = [f"{name}/{k}" for k in range(len(values))]
        content["settings"].append({"name": name, "cases": [{"folder": f} for f in folders]})
        rows.append(
            {
                "setting": name,
                "time_s": 9.0,
                "errors": {key: error(0.02) for key in ("contour", "curtain", "power")},
            }
        )
        for folder, value in zip(folders, values, strict=True):
            (tmp_path / folder).mkdir(parents=True)
            (tmp_path / folder / "case.json").write_text(document.text())
            means = dict.fromkeys(("kinetic", "kinetic_rotation", "power", "centre_z"), value)
            result = {"dimensionless": means, "largest_overlap_over_radius": 0.1 * value}
            finished[tmp_path / folder] = SimpleNamespace(case=document, result=result)
    (tmp_path / "report").mkdir()
    (tmp_path / "report" / "speed-against-error.json").write_text(json.dumps({"rows": rows}))
    # One setting failed and is not a seed; one has not begun.
    failed = {"name": "long", "cases": [{"folder": "long/0"}]}
    content["settings"] += [failed, {"name": "later", "cases": [{"folder": "later/0"}]}]
    (tmp_path / "long" / "0").mkdir(parents=True)
    (tmp_path / "long" / "0" / "case.json").write_text(case(2.9e-4).text())
    record = {"state": "failed", "cause": "ball 7 is too fast"}
    (tmp_path / "long" / "0" / "stage.json").write_text(json.dumps(record))
    (tmp_path / "study.json").write_text(json.dumps(content))
    monkeypatch.setattr(
        "millscale.validate.time_step.finished_or_reason",
        lambda place: finished.get(place, "not yet"),
    )
    return tmp_path


def test_rows_of_the_mill_are_the_settings_that_differ_in_step_and_backend_alone(study):
    rows = {row["setting"]: row for row in mills(study)}
    assert set(rows) == {"fine", "usual", "stock", "long"}
    assert [row["path"] for row in rows.values()] == ["plain", "default", "stock", "default"]
    assert rows["long"]["stopped_by"] == ["ball 7 is too fast"] and rows["long"]["seeds"] == 0
    assert rows["fine"]["stopped_by"] == [] and "kinetic" not in rows["long"]
    assert rows["fine"]["is_reference"] and rows["fine"]["kinetic"]["difference"] == 0.0
    assert rows["fine"]["kinetic"]["range_of_seeds"] == pytest.approx(0.2 / 1.1)
    assert rows["stock"]["power"]["difference"] == pytest.approx(-0.2)
    assert rows["usual"]["seeds"] == 2 and rows["usual"]["max_overlap"] == pytest.approx(0.13)


def bed(backend, share, stopped=None):
    return {
        "scene": "bed",
        "path": backend,
        "dt": share,
        "dt_over_rayleigh": share,
        "dt_over_damping_limit": share,
        "kinetic_left": None if stopped else 1e-6,
        "spin_noise": None if stopped else 0.01,
        "max_overlap": 0.02,
        "stopped_by": stopped,
    }


def hit(backend, kind, share):
    return {
        "scene": "collision",
        "kind": kind,
        "path": backend,
        "dt": share,
        "dt_over_rayleigh": share,
        "steps_per_contact": 2.0 / share,
        "restitution": 0.0917 if kind == "head-on" else None,
        "peak_overlap": 0.07,
        "dissipated": 0.99 if kind == "head-on" else 0.63,
    }


def test_the_page_and_the_picture_show_every_row(study, tmp_path):
    rows = [*mills(study), bed("plain", 0.1), bed("plain", 0.4, "ERROR: ball 7")]
    rows += [hit(backend, kind, 0.1) for backend in COLOURS for kind in ("head-on", "oblique")]
    record = {"command": "c", "commit": "abc", "date": "today", "machine": {"cpu": "a cpu"}}
    text = page({"restitution": 0.1, "rows": rows, "provenance": record})
    assert "| stock | 0.0001 | 0.143 | 1.00 | 1 | -20.0 (0.0) |" in text
    assert "| 2.00 ± 1.00 | 2.00 ± 1.00 | 0.088 |" in text
    assert "| default | 0.00029 | 0.414 | 2.90 | 0, 1 stopped |  |" in text
    assert "| plain | 0.4 | 0.40 | stopped | stopped | 0.020 |" in text
    assert text.count("| 0.1 | 20.0 | 0.0917 | 0.0700 | 0.9900 | 0.6300 |") == len(COLOURS)
    figure = draw(rows, tmp_path / "p.png")
    assert (tmp_path / "p.png").stat().st_size > 10_000
    drawn = [len(axes.containers) for axes in figure.axes]
    assert drawn == [4, 1, 3, 3]


def test_the_page_has_no_column_for_a_mean_that_no_row_has(study):
    rows = list(mills(study))
    rows += [hit("plain", kind, 0.1) for kind in ("head-on", "oblique")]
    record = {"command": "c", "commit": "abc", "date": "today", "machine": {"cpu": "a cpu"}}
    document = {"restitution": 0.1, "rows": rows, "provenance": record}
    assert "| of rotation | power | contour |" in page(document)
    del rows[0]["power"]
    assert "| +0.0 (18.2) | +0.0 (18.2) |  |" in page(document)
    for row in rows[1:]:
        row.pop("power", None)
    text = page(document)
    assert "power" not in text
    lines = [line for line in text.splitlines() if line.startswith("| stock | 0.0001")]
    assert lines == [
        "| stock | 0.0001 | 0.143 | 1.00 | 1 | -20.0 (0.0) | -20.0 (0.0) "
        "| 2.00 ± 1.00 | 2.00 ± 1.00 | 0.088 |"
    ]
