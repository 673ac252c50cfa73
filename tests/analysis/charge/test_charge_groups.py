"""Groups of seeds against each other."""

from types import SimpleNamespace

import pytest

from millscale.analysis.charge import groups as charge_groups
from millscale.analysis.charge.groups import compare_groups, markdown
from millscale.runs.case_folder import RunFolderError


def charge(name, place, torque=0.37):
    """A charge that is one number: its errors against another are differences of places."""
    finished = SimpleNamespace(folder=f"cases/{name}")
    result = {"dimensionless": {"torque": torque}}
    return SimpleNamespace(id=name, place=place, result=result, finished=finished)


@pytest.fixture(autouse=True)
def pairs(monkeypatch):
    def compare(a, b):
        apart = abs(a.place - b.place)
        return {
            "massflow_correlation": 1.0 - apart,
            "power_error": b.place - a.place,
            "mean_over_angles": {"contour_error_mean": apart, "curtain_iou_whole": None},
        }

    monkeypatch.setattr(charge_groups, "compare_two", compare)


def test_a_shift_below_the_spread_of_seeds_agrees_and_one_above_does_not():
    first = [charge("a1", 0.0), charge("a2", 0.1)]
    near = [charge("b1", 0.02), charge("b2", 0.12)]
    far = [charge("b1", 0.2), charge("b2", 0.3)]
    for second, agree in ((near, True), (far, False)):
        found = compare_groups(first, second)["distances"]
        assert set(found) == {"contour_error_mean", "power_error", "1 - massflow_correlation"}
        assert {entry["agree"] for entry in found.values()} == {agree}
    one = found["contour_error_mean"]
    assert one["between"] == pytest.approx(0.2)  # 0.2, 0.3, 0.1, 0.2
    assert one["within_largest"] == pytest.approx(0.1)


def test_means_agree_within_the_range_of_seeds():
    first = [charge("a1", 0.0, 0.370), charge("a2", 0.1, 0.372)]
    for shift, agree in ((0.001, True), (0.005, False)):
        second = [charge(c.id, c.place, c.result["dimensionless"]["torque"] + shift) for c in first]
        compared = compare_groups(first, second)
        found = compared["means"]["torque"]
        assert found["difference"] == pytest.approx(-shift)
        assert found["range_of_seeds"] == pytest.approx(0.002)
        assert found["agree"] is agree
        assert f"| torque | {-shift:.4f} | 0.0020 | {'yes' if agree else 'no'} |" in markdown(
            compared
        )


def test_a_case_alone_is_an_error():
    with pytest.raises(RunFolderError, match="one case alone has no spread"):
        compare_groups([charge("a", 0.0)], [charge("b", 0.0), charge("c", 0.0)])
