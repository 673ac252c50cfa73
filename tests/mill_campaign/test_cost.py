import pytest

from mill_campaign.cost import wall_time

# Reference runs on two ranks at 1e-4 s: balls, omega [rad/s], wall time of 0.8 s of settling and
# rotation to 8 rad [s].
REFERENCE = [(13370, 1.6125, 200.0), (50449, 1.3023, 936.0), (100786, 1.1402, 2032.0)]


@pytest.mark.parametrize(("balls", "omega", "measured"), REFERENCE)
def test_prediction_is_within_a_fifth_of_the_reference_runs(balls, omega, measured):
    steps = round((0.8 + 8.0 / omega) / 1e-4)
    assert wall_time("multi-ball", balls, 300, steps, 2) == pytest.approx(measured, rel=0.2)


# Triangles, processor time of 17,000 steps [s].
MEASURED = [(300, 2.33), (350, 2.88), (450, 3.23), (750, 5.21)]


@pytest.mark.parametrize(("triangles", "measured"), MEASURED)
def test_a_single_ball_costs_what_moving_the_mesh_costs(triangles, measured):
    for ranks in (1, 8):
        predicted = wall_time("single-ball", 1, triangles, 17_000, ranks)
        assert predicted == pytest.approx(measured, rel=0.1)
