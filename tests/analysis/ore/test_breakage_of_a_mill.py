"""Breakage by the impacts of scaled mills: back-scaling, rates against a sum by hand, warnings."""

import math

import numpy as np
import pytest

from millscale.analysis.finished_campaign import load_campaign
from millscale.analysis.ore.breakage import MINUTE, back_scaling, breakage_of, physical_spectrum
from millscale.analysis.ore.file import load_ore
from millscale.breakage import t10
from millscale.errors import CampaignError
from synthetic_case import finish_case, write_campaign, write_case
from synthetic_impacts import write_spectra
from synthetic_mills import charge_case, columns_of
from synthetic_ore import AUSTIN, JK, TAVARES, ore_text, write_ore

# Of each ball and revolution, with either energy, on balls and on the liner.
CONTACTS = 5.0
# Share of the contacts with the higher energy that a charge has, by S and seed.
STRONG = {(1.0, 1): 1.0, (1.696, 1): 1.0, (2.6, 1): 0.5, (2.6, 2): 0.3}


@pytest.fixture(scope="module")
def mills(tmp_path_factory):
    """Charges of three S, of which S = 2.6 has two packings. Read only."""
    runs, names = tmp_path_factory.mktemp("mills"), []
    for (S, seed), strong in STRONG.items():
        case = charge_case(S, seed)
        case["deck"]["impacts"] = "on"
        folder = write_case(runs, case, columns_of(case))
        # A scaled mill has S times as much liner for each ball.
        write_spectra(folder, case, CONTACTS * case["ball"]["count"], strong, on_liner=S)
        finish_case(folder)
        names.append(folder.name)
    write_campaign(runs, names)
    return runs


def found_in(runs, tmp_path, *args, **changes):
    ore = load_ore(write_ore(tmp_path / "ore.toml", *args, **changes))
    return breakage_of(load_campaign(runs).charges, ore, runs)


def test_impacts_of_scaled_mills_become_those_of_the_physical_mill(mills):
    for charge in load_campaign(mills).charges:
        case, strong = charge.case, STRONG[charge.S, charge.seed]
        physical = case.physical
        unit = case.ball.mass_kg * (physical.omega_rad_s * physical.radius_m) ** 2
        per_length = charge.balls_per_length_scaled
        revolutions = per_length * physical.length_m * physical.omega_rad_s / math.tau
        spectrum = physical_spectrum(charge, "dissipated", "ball_ball")
        assert spectrum.rate == pytest.approx(CONTACTS * (1.0 + strong) * revolutions)
        power = CONTACTS * (2e-4 + 2e-3 * strong) * unit * revolutions
        assert spectrum.power == pytest.approx(power)
        both = physical_spectrum(charge, "dissipated")
        assert both.power == pytest.approx(2.0 * power)
        if charge.S == 1.0:
            assert back_scaling(case)[0] == pytest.approx(1.0)


def test_a_mill_with_the_spectrum_of_the_physical_mill_gives_its_rates(mills, tmp_path):
    first, like, unlike = found_in(mills, tmp_path).mills
    assert (first.S, like.S, unlike.S, unlike.seeds) == (1.0, 1.696, 2.6, 2)
    # Balls of S = 1.696 are rounded to whole ones.
    for a, b in zip(first.sizes, like.sizes, strict=True):
        assert b.rate == pytest.approx(a.rate, rel=2e-3)
        assert b.specific_energy == pytest.approx(a.specific_energy, rel=1e-9)
        assert b.t10 == pytest.approx(a.t10, rel=1e-9)
        assert a.rate_deviation is None
    # Rates come from the strong contacts, of which S = 2.6 has 0.5 and 0.3.
    for a, b in zip(first.sizes, unlike.sizes, strict=True):
        assert 0.4 * a.rate < b.rate < a.rate
        assert b.rate_deviation > 0.0


def test_rates_are_the_sum_over_the_impacts(mills, tmp_path):
    ore = load_ore(write_ore(tmp_path / "ore.toml", energy="dissipated"))
    charge = load_campaign(mills).charges[0]
    (mill, *_) = breakage_of([charge], ore, mills).mills
    unit = charge.case.ball.mass_kg * (charge.case.mill.omega_rad_s * 3.9) ** 2
    per_second = 2.0 * CONTACTS * charge.balls * charge.case.mill.omega_rad_s / math.tau
    for row in mill.sizes:
        mass = 2700.0 * math.pi / 6.0 * row.size**3
        energies = unit * np.array([2e-4, 2e-3])
        taken = 0.8 * energies / (3.0 * mass)
        broken = ore.tavares.broken(taken, row.size)
        rate = per_second * 3.0 * mass / 3000.0 * broken.sum()
        assert row.rate == pytest.approx(rate, rel=1e-9)
        weights = energies / energies.sum()
        assert row.specific_energy == pytest.approx(weights @ taken / 3600.0)
        assert row.t10 == pytest.approx(weights @ t10(taken / 3600.0, 60.0, 0.8))
        assert row.breaking_share == pytest.approx(weights @ broken)
        # Damage breaks particles that a first impact leaves whole.
        assert row.broken_share >= 0.98 * (1.0 - math.exp(-MINUTE * row.rate))
    assert mill.specific_power == pytest.approx(0.8 * sum(mill.power.values()) / 3000.0)
    assert [math.fsum(x) for x in zip(*(row.rate_shares for row in mill.decades), strict=True)] == (
        pytest.approx([1.0] * len(ore.sizes))
    )
    assert math.fsum(row.power for row in mill.decades) == pytest.approx(sum(mill.power.values()))


def test_without_fracture_energies_there_are_no_rates(mills, tmp_path):
    for mill in found_in(mills, tmp_path, JK).mills:
        assert all(row.rate is None and row.t10 > 0.0 for row in mill.sizes)
        assert mill.fit is None and all(row.rate_shares == () for row in mill.decades)
    assert all(row.t10 is None for row in found_in(mills, tmp_path, TAVARES).mills[0].sizes)


def test_austins_function_is_fitted_and_stated(mills, tmp_path):
    first = found_in(mills, tmp_path, JK + TAVARES + AUSTIN).mills[0]
    fitted = first.fit.selection.at(np.array([x.size for x in first.sizes])) / MINUTE
    ratios = np.log(fitted / [x.rate for x in first.sizes])
    assert math.sqrt(np.mean(ratios**2)) == pytest.approx(first.fit.error, rel=1e-6)
    # 0.5 x^0.8 / (1 + (x / 12)^3) per minute.
    assert first.sizes[2].austin * MINUTE == pytest.approx(0.5 * 4**0.8 / (1 + (4 / 12) ** 3))


def test_warnings_say_what_is_not_similar_and_out_of_range(mills, tmp_path):
    warnings = "\n".join(found_in(mills, tmp_path, sizes="[1, 50]").warnings)
    assert "S2.600-seed1, ball on ball: 9 % of the energy of S = 1" in warnings
    assert "S1.696" not in warnings
    assert "particles of 50 mm are as large as the balls, 40 mm" in warnings
    assert "A and b are of particles of 13 to 63 mm: 1 size outside" in warnings
    only = [x for x in load_campaign(mills).charges if x.S == 2.6]
    ore = load_ore(tmp_path / "ore.toml")
    assert "only S = 2.6 has spectra" in "\n".join(breakage_of(only, ore, mills).warnings)


@pytest.mark.parametrize(
    ("old", "new", "cause"),
    [
        ("density_g_cm3 = 2.7", "", "ore.density_kg_m3: missing"),
        ("density_g_cm3", "density_kg_mm3", "nearest is density_kg_m3"),
        ("hold_up_t = 3.0", "hold_up_t = 0", "catch.hold_up_t"),
        ("energy_share = 0.8", "energy_share = 1.2", "catch.energy_share"),
        ('"dissipated"', '"kinetic"', 'got "kinetic"; accepted: "available" or "dissipated"'),
        ("[jk]", "[jk_test]", "unknown section"),
        ("A = 60", "a = 60", "jk.a: unknown key; accepted: A, b"),
        ("truncation = 4", "truncation = 1", "tavares.truncation"),
        ("[1, 2, 4, 6, 8, 16]", "[2, 2]", "2.0 is given twice"),
        ("[1, 2, 4, 6, 8, 16]", str(list(range(1, 60))), "got 59 sizes"),
        ("[1, 2, 4, 6, 8, 16]", "[]", "ore.sizes_mm"),
        (JK + TAVARES, "", "no strength of the ore"),
    ],
)
def test_an_ore_that_is_not_accepted_is_refused(tmp_path, old, new, cause):
    path = tmp_path / "ore.toml"
    text = ore_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(CampaignError) as caught:
        load_ore(path)
    assert cause in str(caught.value)
