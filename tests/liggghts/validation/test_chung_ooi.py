"""The eight tests of Chung & Ooi, Granular Matter 13 (2011) 643-656, doi
10.1007/s10035-011-0277-0, and MercuryDPM's single ball, through every contact path and wall.

At the step the tests state (a five-hundredth of the impact where they state none) and at the
production step, a fifteenth of the impact: what campaigns of the paper have.
"""

import functools

import numpy as np
import pytest

from contact_bounds import restitution_bound, slip_bound
from contact_paths import CONTACT_PATHS, available_paths
from impacts import PLANES, Impact, Material, by_the_law, in_engine, rigid_plane

pytestmark = pytest.mark.engine

GLASS, LIMESTONE = Material(4.8e10, 0.20, 2800.0), Material(2.0e10, 0.25, 2500.0)
ALLOY_30, MAGNESIUM = Material(7e10, 0.30, 2699.0), Material(4e10, 0.35, 1800.0)
OXIDE, IRON = Material(3.8e11, 0.23, 4000.0), Material(1e11, 0.25, 7000.0)
ALLOY = Material(7e10, 0.33, 2700.0)
STEEL, POLYETHYLENE = Material(2.08e11, 0.30, 7850.0), Material(1e9, 0.40, 1400.0)
NYLON, COPPER = Material(2.5e9, 0.40, 1000.0), Material(1.2e11, 0.35, 8900.0)
STATED, PRODUCTION = "stated", "production"

REASON = {
    "peak": "a peak met between two steps, (pi dt / t)^2 / 8; first contact up to a step deep; "
    "the printed digits",
    "duration": "both ends of the contact are met within a step; the printed digits",
    "restitution": "dashpot half a step late and first contact up to a step deep "
    "(contact_bounds.restitution_bound)",
    "slip": "friction's events met within half a step, restitution, late decay and phase of "
    "sticking (contact_bounds.slip_bound)",
    "sliding": "slip_bound, and the closed form leaves out the overlap's lever, overlap / radius",
    "published": "5 %, the spread other codes are accepted with",
    "digits": "rounding of 1e-16 a step over the impact",
}


SPHERES, PLANE = "spheres", "plane"
# A wall does not know who evaluates balls: stock with every wall, and another path with each once.
# Kernels are of one law, materials of one kind: one of each for every day, all for the table.
EVERY_DAY = {"stock", "fast-v3"}


def through(places, cases, names):
    """Paths, walls, cases and steps of a test: (path, wall, case, step).

    Args:
        places: of a case, the test and which of SPHERES and PLANE it is of.
        cases: the first of each test is for every day.
    """
    out, seen = [], set()
    for case, name in zip(cases, names, strict=True):
        test, *where = places(case)
        first = test not in seen
        seen.add(test)
        for path, wall, step in _ways(where, first):
            every_day = first and (path == "stock" or (wall == "none" and path in EVERY_DAY))
            marks = () if every_day else pytest.mark.validate
            id = "-".join((path, wall, name, step))
            out.append(pytest.param(path, wall, case, step, id=id, marks=marks))
    return pytest.mark.parametrize(("path", "wall", "case", "step"), out)


def _ways(where, first):
    for path in CONTACT_PATHS:
        if SPHERES in where:
            yield from ((path, "none", step) for step in (STATED, PRODUCTION))
        for wall in PLANES if PLANE in where else ():
            if path == "stock":
                yield from ((path, wall, step) for step in (STATED, PRODUCTION))
            elif first:
                yield path, wall, STATED


def _needs(path):
    if path not in available_paths():
        pytest.skip(f"this machine cannot run {path}")


def _impact(wall, material, *args, **more):
    """On a rigid plane, or mirrored: the same forces on the ball, two ways."""
    if wall == "none":
        return Impact.of(material, *args, mirrored=True, other_radius=args[0], **more)
    return Impact.of(rigid_plane(material), *args, **more)


def _step(impact, step, stated):
    return stated or impact.duration / 500.0 if step == STATED else impact.duration / 15.0


@functools.lru_cache(maxsize=64)
def _law(key, wall):
    return by_the_law(_SCENES[key](wall), 2000)


def _off_law(impact):
    """Time step of `by_the_law`, whose own error has the same bounds."""
    return impact.duration / 2000.0


def _shares(impact, dt):
    _, overlap, duration = impact.hertz()
    return dt / duration, impact.closing * dt / overlap


# Tests 1 and 2: force, overlap and duration of elastic impacts, as printed.
ELASTIC = [
    ("1 elastic, two spheres", SPHERES, GLASS, 0.01, 10.0, 0.35, (10697.0, 274.1e-6, 40.3e-6)),
    ("1 elastic, two spheres", SPHERES, LIMESTONE, 0.01, 10.0, 0.35, (7108.0, 368.3e-6, 54.1e-6)),
    ("2 elastic, rigid plane", PLANE, ALLOY_30, 0.1, 0.2, 0.0, (11370.0, 49.7e-6, 731e-6)),
    ("2 elastic, rigid plane", PLANE, MAGNESIUM, 0.1, 0.2, 0.0, (7233.0, 52.1e-6, 766e-6)),
]
PRINTED = np.array([0.5, 0.05e-6, 0.5e-6])  # half of the last digit of the 2nd test, the coarser


@through(lambda case: case[:2], ELASTIC, ["glass", "limestone", "aluminium", "magnesium"])
def test_an_elastic_impact_has_hertz_force_overlap_and_duration(
    tmp_path, contact_row, path, wall, case, step
):
    test, _, material, radius, speed, friction, printed = case
    _needs(path)
    impact = _impact(wall, material, radius, 1.0, friction, speed)
    dt = _step(impact, step, None)
    history = in_engine(tmp_path, impact, path, wall, dt, every=1)
    force = np.array([state.force[0] for state in history])
    depth = np.array([state.overlap[0] for state in history])
    share, first = (float(x[0]) for x in _shares(impact, dt))
    off_peak = (np.pi * share) ** 2 / 8.0 + first**2.5
    touching = np.flatnonzero(depth > 0.0)
    got = force.max(), depth.max(), (touching[-1] - touching[0] + 1) * dt
    relative = 1.5 * off_peak, off_peak, 0.0
    for k, name in enumerate(("largest force [N]", "largest overlap [m]", "duration [s]")):
        contact_row(
            test,
            path,
            wall,
            name,
            dt=dt,
            expected=printed[k],
            got=got[k],
            tolerance=printed[k] * relative[k] + PRINTED[k] + (2.0 * dt if k == 2 else 0.0),
            reason=REASON["duration" if k == 2 else "peak"],
        )


RESTITUTIONS = {STATED: [0.2, 0.4, 0.6, 0.8, 1.0], PRODUCTION: [0.2, 0.6, 1.0]}


@through(lambda case: ("3", SPHERES, PLANE), [OXIDE, IRON], ["oxide", "iron"])
def test_a_damped_impact_has_its_restitution(tmp_path, contact_row, path, wall, case, step):
    _needs(path)
    got, bound = [], []
    for e in RESTITUTIONS[step]:
        impact = _impact(wall, case, 2.5e-3, e, 0.0, 3.9)
        dt = _step(impact, step, None)
        rebound = in_engine(tmp_path / f"{e}", impact, path, wall, dt)[-1]
        got.append(rebound.away[0] / 3.9)
        bound.append(restitution_bound(e, *_shares(impact, dt))[0] + 1e-12)
    contact_row(
        "3 damped, normal",
        path,
        wall,
        "restitution",
        dt=dt,
        expected=RESTITUTIONS[step],
        got=got,
        tolerance=bound,
        reason=REASON["restitution"],
        at=[f"e = {e}" for e in RESTITUTIONS[step]],
    )


def test_mercurys_single_ball_leaves_the_steel_plate_as_there(tmp_path, contact_row):
    for wall in PLANES:
        ball, plate = Material(1e9, 0.2, 2500.0), Material(210e9, 0.2, 7800.0)
        impact = Impact.of(ball, 1e-3, 0.4, 0.0, 1.0, other=plate)
        for dt in (5e-7, impact.duration / 15.0):
            got = in_engine(tmp_path / wall / f"{dt}", impact, "stock", wall, dt)[-1].away
            bound = restitution_bound(0.4, *_shares(impact, dt))
            common = dict(dt=dt, got=got, reason=REASON["restitution"])
            contact_row(
                "MercuryDPM M1",
                "stock",
                wall,
                "restitution",
                expected=0.4,
                tolerance=bound,
                **common,
            )
            contact_row(
                "MercuryDPM M1",
                "stock",
                wall,
                "speed there [m/s]",
                expected=0.401075,
                tolerance=bound + 0.001075,
                **common,
            )


ANGLES = np.array([5, 10, 15, 20, 25, 30, 35, 40, 50, 60, 70, 80, 85])
INCIDENCE = np.radians(ANGLES)
DEGREES = [f"{a} deg" for a in ANGLES]
# Chung & Ooi's reference curve of test 4, aluminium oxide.
PUBLISHED_COR = [
    0.948,
    0.687,
    0.624,
    0.616,
    0.634,
    0.684,
    0.737,
    0.781,
    0.845,
    0.893,
    0.932,
    0.966,
    0.983,
]
PUBLISHED_SPIN = [-19.3, -213, -378, -511, -599, -617, -582, -545, -457, -357, -246, -126, -63]
PUBLISHED_ANGLE = [
    3.76,
    -1.56,
    -5.54,
    -7.54,
    -7.54,
    -3.55,
    3.43,
    11.6,
    29.4,
    47.8,
    64.6,
    78.7,
    84.5,
]


def _oblique(material):
    return lambda wall: _impact(
        wall, material, 2.5e-3, 0.98, 0.092, 3.9 * np.cos(INCIDENCE), 3.9 * np.sin(INCIDENCE)
    )


ALONG = np.array([0.1, 0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 13.0, 17.0, 21.0])


def _constant_normal(material):
    return lambda wall: _impact(wall, material, 1e-5, 1.0, 0.3, 5.0 + 0.0 * ALONG, ALONG)


SPINS = np.array([0.175, 1.0, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 14.0, 21.0])


def _spinning(material):
    return lambda wall: _impact(wall, material, 0.1, 0.5, 0.4, 0.2, 0.0, SPINS)


def _on_a_large_ball(material):
    heavy = Material(material.youngs_modulus, material.poisson_ratio, 1000.0 * material.density)
    return lambda wall: Impact.of(
        material, 0.1, 0.5, 0.4, 0.2, 0.0, SPINS, other=heavy, other_radius=0.5
    )


_SCENES = {
    ("4 oblique", "oxide"): _oblique(OXIDE),
    ("4 oblique", "alloy"): _oblique(ALLOY),
    ("5 oblique, constant normal speed", "steel"): _constant_normal(STEEL),
    ("5 oblique, constant normal speed", "polyethylene"): _constant_normal(POLYETHYLENE),
    ("6 spinning, plane", "alloy"): _spinning(ALLOY),
    ("6 spinning, plane", "nylon"): _spinning(NYLON),
    ("7 spinning, two spheres", "alloy"): _spinning(ALLOY),
    ("7 spinning, two spheres", "copper"): _spinning(COPPER),
    ("8 spinning, unequal spheres", "alloy"): _on_a_large_ball(ALLOY),
    ("8 spinning, unequal spheres", "nylon"): _on_a_large_ball(NYLON),
}
_STATED_DT = {"4": 2e-8, "5": 1e-10, "6": 5e-7, "7": 5e-7, "8": 5e-7}
_CASES = {
    "4": DEGREES,
    "5": [f"{v:g} m/s" for v in ALONG],
    **{test: [f"{w:g} rad/s" for w in SPINS] for test in "678"},
}
_PLACES = {
    "4": (SPHERES, PLANE),
    "5": (SPHERES, PLANE),
    "6": (PLANE,),
    "7": (SPHERES,),
    "8": (SPHERES,),
}


@through(
    lambda case: (case[0], *_PLACES[case[0][0]]),
    list(_SCENES),
    [f"{test[0]}-{material}" for test, material in _SCENES],
)
def test_an_oblique_impact_is_that_of_the_law(tmp_path, contact_row, path, wall, case, step):
    _needs(path)
    key = case
    impact, law = _SCENES[key](wall), _law(key, wall)
    dt = _step(impact, step, _STATED_DT[key[0][0]])
    got = in_engine(tmp_path, impact, path, wall, dt)[-1]
    both = dt + _off_law(impact)
    common = dict(dt=dt, at=_CASES[key[0][0]])
    name = f"{key[0]}"
    speed = np.hypot(impact.towards, impact.along)
    slip, turn = slip_bound(impact, both), _turned(impact, both)
    off = restitution_bound(impact.restitution, *_shares(impact, both))
    for quantity, a, b, tolerance, reason in (
        (
            "speed away / impact speed",
            got.away,
            law.away,
            off * impact.towards + turn * speed,
            "restitution",
        ),
        ("speed along / impact speed", got.along, law.along, slip + turn * speed, "slip"),
        (
            "spin x radius / impact speed",
            got.spin * impact.radius,
            law.spin * impact.radius,
            2.5 * slip,
            "slip",
        ),
    ):
        contact_row(
            name,
            path,
            wall,
            quantity,
            expected=b / speed,
            got=a / speed,
            tolerance=tolerance / speed + 1e-9,
            reason=REASON[reason],
            **common,
        )
    if wall != "none":
        if step == STATED:
            _sliding_limits(contact_row, name, path, wall, impact, got, common)
    elif impact.mirrored:
        _mirror_images(contact_row, name, path, impact, got, common)


def _turned(impact, dt):
    """Two balls that slip past each other turn their normal, which a contact met a step late does
    less [rad]; a plane does not turn."""
    if impact.other_radius is None:
        return 0.0
    passing = np.abs(impact.along) * (2.0 if impact.mirrored else 1.0)
    return passing * dt / (impact.radius + impact.other_radius)


FRICTION_IN_TENSION = (
    "friction goes with |F|, and the dashpot pulls towards the end of an impact: with e = 0.5 the "
    "friction of gross sliding is 17 % larger than mu (1 + e) m v. The law's own, on every path; "
    "the row of the law itself passes"
)


def _sliding_limits(contact_row, name, path, wall, impact, got, common):
    """Closed forms where the ball slides all the way, as Chung & Ooi give them."""
    dt = common["dt"]
    e, mu = impact.restitution, impact.friction
    slip = impact.along - impact.radius * impact.spin
    # To the end; from the first step on is k_t v_t > mu k_n v_n, which is weaker.
    sliding = np.abs(slip) > 1.1 * 3.5 * mu * (1.0 + e) * impact.towards
    if not sliding.any():
        return
    change = -np.sign(slip) * mu * (1.0 + e) * impact.towards
    lever = impact.hertz()[1] / impact.radius
    tolerance = slip_bound(impact, dt) + lever * np.abs(change)
    at = [case for case, s in zip(common["at"], sliding, strict=True) if s]
    for quantity, a, b, factor in (
        ("sliding: change of speed along / normal speed", got.along - impact.along, change, 1.0),
        (
            "sliding: change of spin x radius / normal speed",
            (got.spin - impact.spin) * impact.radius,
            -2.5 * change,
            2.5,
        ),
    ):
        unit = impact.towards[sliding]
        contact_row(
            name,
            path,
            wall,
            quantity,
            expected=b[sliding] / unit,
            got=a[sliding] / unit,
            tolerance=factor * tolerance[sliding] / unit,
            reason=REASON["sliding"],
            dt=dt,
            at=at,
            fault=FRICTION_IN_TENSION if e < 0.9 else None,
        )


def _mirror_images(contact_row, name, path, impact, got, common):
    speed, other = np.hypot(impact.towards, impact.along), got.other
    off = np.abs(
        [got.away + other.away, got.along + other.along, impact.radius * (got.spin - other.spin)]
    )
    contact_row(
        name,
        path,
        "none",
        "difference of the two balls / impact speed",
        expected=0.0,
        got=off.max(axis=0) / speed,
        tolerance=1e-11,
        reason=REASON["digits"],
        **common,
    )


@pytest.mark.parametrize(
    ("path", "wall"), [*((path, "none") for path in CONTACT_PATHS), *(("stock", w) for w in PLANES)]
)
def test_the_published_curve_of_test_4_is_met(tmp_path, contact_row, path, wall):
    _needs(path)
    impact = _SCENES["4 oblique", "oxide"](wall)
    got = in_engine(tmp_path, impact, path, wall, 2e-8)[-1]
    common = dict(dt=2e-8, at=DEGREES, reason=REASON["published"])
    name = "4 oblique, published curve"
    contact_row(
        name,
        path,
        wall,
        "tangential restitution",
        expected=PUBLISHED_COR,
        got=got.along / impact.along,
        tolerance=0.05,
        **common,
    )
    contact_row(
        name,
        path,
        wall,
        "spin [rad/s]",
        expected=PUBLISHED_SPIN,
        got=-got.spin,
        tolerance=0.05 * np.abs(PUBLISHED_SPIN).max(),
        **common,
    )
    surface = got.along - impact.radius * got.spin
    contact_row(
        name,
        path,
        wall,
        "rebound of the contact point [deg]",
        expected=PUBLISHED_ANGLE,
        got=np.degrees(np.arctan2(surface, got.away)),
        tolerance=4.5,
        **common,
    )
