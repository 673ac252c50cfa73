import pytest

from millscale import _core

RADII = (3.9, 3.6, 3.3, 3.0, 2.3, 1.5)


@pytest.fixture(scope="session")
def physical():
    """Table 4's physical mill, trapezoid reading."""
    return _core.Lifters(3.9, 3.61, 0.25, 0.635, 25)


@pytest.fixture(scope="session", params=RADII, ids=lambda radius: f"R{radius}")
def table4_mill(request, physical):
    """Each mill of Table 4, and its S."""
    S = 3.9 / request.param
    return physical.scaled(S), S


@pytest.fixture(
    params=["trapezoid", "parallel", "few", "drum"],
)
def liner(request, physical):
    """Liners of different kinds."""
    return {
        "trapezoid": physical,
        "parallel": _core.Lifters.from_face_angle(3.9, 3.61, 0.25, 0.0, 25, phase=0.3),
        "few": _core.Lifters(1.0, 0.7, 0.2, 0.9, 5, phase=-1.0),
        "drum": _core.Lifters(2.0, 0.0, 0.0, 0.0, 0),
    }[request.param]
