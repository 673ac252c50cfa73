"""Breakage models: closed forms, limits, the same in another way, particles hit one by one."""

from __future__ import annotations

import doctest
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

import millscale.breakage as breakage
from millscale.breakage import (
    AustinSelection,
    Grinding,
    Nip,
    Spectrum,
    TavaresOre,
    broken_share,
    damage,
    fit_austin,
    selection_rates,
    specific_energy_for,
    t10,
)

# A made-up ore within the ranges of published materials.
ORE = TavaresOre(
    density=2700.0,
    residual_energy=150.0,
    size=3e-3,
    size_exponent=1.2,
    scatter=0.5,
    truncation=4.0,
    damage_exponent=5.0,
    largest_t10=60.0,
    t10_rate=0.03,
)
EDGES = np.geomspace(1e-4, 10.0, 26)
SPECTRUM = Spectrum(EDGES, 2e4 * EDGES[:-1] ** -0.6)


def test_the_examples_run():
    assert doctest.testmod(breakage).failed == 0


def test_a_spectrum_keeps_its_energy():
    sums = SPECTRUM.counts * np.sqrt(EDGES[:-1] * EDGES[1:]) * 1.1
    measured = replace(SPECTRUM, sums=sums)
    assert measured.power == pytest.approx(1.1 * SPECTRUM.power, rel=1e-12)
    both = measured + SPECTRUM
    assert both.power == pytest.approx(measured.power + SPECTRUM.power, rel=1e-12)
    assert both.rate == pytest.approx(2.0 * SPECTRUM.rate, rel=1e-12)
    # A bin without impacts has the middle of its ends.
    empty = Spectrum(np.array([1.0, 4.0, 9.0]), np.array([0.0, 2.0]), np.array([0.0, 10.0]))
    assert empty.energies.tolist() == [2.0, 5.0]


def test_bins_that_are_left_out_are_empty():
    edges = np.geomspace(1e-3, 1.0, 7)
    kept = [0, 1, 4]
    counts, sums = np.array([5.0, 3.0, 2.0]), np.array([6e-3, 9e-3, 0.3])
    found = Spectrum.of_bins(edges[kept], edges[[1, 2, 5]] * (1.0 + 1e-15), counts, sums)
    assert found.edges == pytest.approx(edges[[0, 1, 2, 4, 5]], rel=1e-12)
    assert found.counts.tolist() == [5.0, 3.0, 0.0, 2.0]
    assert found.power == pytest.approx(sums.sum(), rel=1e-12)


def test_impacts_of_a_larger_mill_keep_their_bins():
    large = SPECTRUM.scaled(energy=8.0, rate=0.5)
    assert large.power == pytest.approx(4.0 * SPECTRUM.power, rel=1e-12)
    assert large.rate == pytest.approx(0.5 * SPECTRUM.rate, rel=1e-12)
    assert large.energies == pytest.approx(8.0 * SPECTRUM.energies, rel=1e-12)


@pytest.mark.parametrize(
    ("edges", "counts"),
    [([1.0, 2.0], [1.0, 1.0]), ([2.0, 1.0], [1.0]), ([0.0, 1.0], [1.0]), ([1.0, 2.0], [-1.0])],
)
def test_what_is_no_spectrum_is_refused(edges, counts):
    with pytest.raises(ValueError, match="accepted"):
        Spectrum(np.array(edges), np.array(counts))


def test_spectra_of_other_bins_do_not_add():
    with pytest.raises(ValueError, match="other bins"):
        SPECTRUM + Spectrum(2.0 * EDGES, SPECTRUM.counts)


def test_t10_has_the_slope_of_softness_and_an_end():
    assert t10(1e-6, 60.0, 0.8) == pytest.approx(60.0 * 0.8 * 1e-6, rel=1e-6)
    assert t10(1e3, 60.0, 0.8) == pytest.approx(60.0, rel=1e-12)
    for fineness in (0.0, 10.0, 59.0):
        assert t10(specific_energy_for(fineness, 60.0, 0.8), 60.0, 0.8) == pytest.approx(fineness)
    with pytest.raises(ValueError, match="below A = 60"):
        specific_energy_for(60.0, 60.0, 0.8)
    with pytest.raises(ValueError, match="0 < A <= 100"):
        t10(1.0, 160.0, 0.8)


def test_fracture_energies_have_the_median_the_scatter_and_the_end_of_the_model():
    size = 5e-3
    median = ORE.median_energy(size)
    assert median == pytest.approx(150.0 * (1.0 + 0.6**1.2), rel=1e-12)
    # The relative energy of the median is e_max / (e_max - e_50) times itself.
    relative = ORE.truncation / (ORE.truncation - 1.0)
    below = 0.5 * (1.0 + math.erf(math.log(relative) / (ORE.scatter * math.sqrt(2.0))))
    assert ORE.broken(np.array([median]), size)[0] == pytest.approx(below, rel=1e-12)
    ends = np.array([0.0, ORE.truncation * median, 1e9])
    assert ORE.broken(ends, size).tolist() == [0.0, 1.0, 1.0]
    shares = np.linspace(0.01, 0.99, 9)
    assert ORE.broken(ORE.energy_of_share(shares, size), size) == pytest.approx(shares, rel=1e-9)
    # Without truncation it is log-normal about the median.
    plain = replace(ORE, truncation=1e9)
    above = median * math.exp(plain.scatter)
    assert plain.broken(np.array([median, above]), size) == pytest.approx([0.5, 0.841344746])


def test_particles_on_a_softer_surface_break_by_less_energy():
    stiff = replace(ORE, stiffness_ratio=0.25)
    assert stiff.median_energy(1e-3) == pytest.approx(ORE.median_energy(1e-3) / 1.25, rel=1e-12)


@pytest.mark.parametrize("exponent", [3.0, 5.0])
@pytest.mark.parametrize("ratio", [0.02, 0.3, 0.9])
def test_damage_is_that_of_a_contact_that_softens(exponent, ratio):
    """Work to a deformation alpha of F = (1 - alpha^gamma) alpha^1.5, alpha up to 1 at fracture."""
    reached = float(damage(np.array([ratio]), exponent)[0]) ** (1.0 / exponent)

    def force(alpha: float) -> float:
        return (1.0 - alpha**exponent) * alpha**1.5

    assert quad(force, 0.0, reached)[0] / quad(force, 0.0, 1.0)[0] == pytest.approx(ratio, rel=1e-7)


def test_damage_ends_at_fracture_and_begins_at_nothing():
    # The work has its maximum at fracture, where a double resolves D to the root of its precision.
    assert damage(np.array([0.0, 1.0, 2.0]), 4.0) == pytest.approx([0.0, 1.0, 1.0], abs=5e-8)


def test_t10_of_an_impact_counts_the_particles_that_it_breaks():
    energy, size = np.array([400.0]), 4e-3
    share = float(ORE.broken(energy, size)[0])
    broken = ORE.energy_of_share(share * np.linspace(0.0005, 0.9995, 1000), size)
    expected = 60.0 * (1.0 - math.exp(-0.03 * 400.0 / np.median(broken)))
    assert ORE.t10(energy, size)[0] == pytest.approx(expected, rel=1e-3)
    assert ORE.t10(np.array([0.0]), size)[0] == 0.0


def test_numbers_outside_of_published_ranges_are_named():
    assert ORE.unusual() == []
    assert replace(ORE, damage_exponent=9.0).unusual() == ["damage_exponent 9, usual 3 to 5.4"]
    with pytest.raises(ValueError, match=r"scatter of an ore: 0\.0"):
        replace(ORE, scatter=0.0)
    with pytest.raises(ValueError, match="largest_t10"):
        replace(ORE, largest_t10=101.0)


GRINDING = Grinding(SPECTRUM, ORE, hold_up=50.0, nip=Nip(particles=3.0, energy_share=0.8))


def test_the_ore_takes_the_energy_of_the_impacts():
    size = 2e-3
    taken = GRINDING.impact_rates(size) @ GRINDING.specific_energies(size)
    assert taken == pytest.approx(0.8 * SPECTRUM.power / 50.0, rel=1e-12)
    assert taken == pytest.approx(GRINDING.specific_power, rel=1e-12)


def test_a_hammer_that_breaks_all_breaks_at_the_rate_of_its_blows():
    hammer = Spectrum(np.array([1e3, 2e3]), np.array([7.0]))
    grinding = replace(GRINDING, spectrum=hammer)
    size = 1e-3
    blows = 7.0 * 3.0 * ORE.mass(size) / 50.0
    assert selection_rates(grinding, [size])[0] == pytest.approx(blows, rel=1e-12)
    for time in (0.3 / blows, 2.0 / blows):
        expected = 1.0 - math.exp(-blows * time)
        assert broken_share(grinding, size, time) == pytest.approx(expected, rel=1e-9)


def test_the_broken_share_begins_at_the_rate_without_damage():
    size = 2e-3
    rate = selection_rates(GRINDING, [size])[0]
    time = 1e-4 / rate
    assert broken_share(GRINDING, size, time) / time == pytest.approx(rate, rel=0.02)


def test_the_broken_share_is_that_of_particles_hit_one_by_one():
    """Impacts of about the median fracture energy, of which each particle takes four: most break
    after damage."""
    size, generator = 2e-3, np.random.default_rng(3)
    share = ORE.median_energy(size) * ORE.mass(size) * 3.0 / 0.8
    edges = share * np.array([0.3, 0.5, 0.7, 0.9])
    grinding = replace(GRINDING, spectrum=Spectrum(edges, np.array([5.0, 3.0, 1.0])))
    rates = grinding.impact_rates(size)
    time = 4.0 / rates.sum()
    count = 4000
    energies = ORE.energy_of_share(generator.random(count), size)
    blows, of_bins = generator.poisson(4.0, count), grinding.specific_energies(size)
    whole = np.ones(count, bool)
    for number in range(blows.max()):
        hit = whole & (blows > number)
        blow = generator.choice(of_bins, hit.sum(), p=rates / rates.sum())
        breaks = blow >= energies[hit]
        energies[hit] *= 1.0 - damage(blow / energies[hit], ORE.damage_exponent)
        whole[np.flatnonzero(hit)[breaks]] = False
    expected = 1.0 - whole.mean()
    assert 0.3 < expected < 0.9
    # Three standard errors of the count, and the grid.
    error = 3.0 * math.sqrt(expected * (1.0 - expected) / count) + 0.003
    assert broken_share(grinding, size, time) == pytest.approx(expected, abs=error)


def test_without_damage_each_strength_decays_at_its_own_rate():
    size = 2e-3
    grinding = replace(GRINDING, ore=replace(ORE, damage_exponent=400.0))
    rates, blows = grinding.impact_rates(size), grinding.specific_energies(size)
    time = 1.0 / selection_rates(grinding, [size])[0]
    strengths = ORE.energy_of_share((np.arange(20000) + 0.5) / 20000, size)
    breaking = np.array([rates[blows >= one].sum() for one in strengths])
    expected = float(np.mean(1.0 - np.exp(-breaking * time)))
    assert broken_share(grinding, size, time) == pytest.approx(expected, abs=0.006)


def test_austin_has_its_maximum_where_the_closed_form_is():
    selection = AustinSelection(rate=0.6, exponent=0.9, size=8e-3, fall=3.0)
    sizes = np.geomspace(1e-4, 1e-1, 20001)
    assert selection.fastest == pytest.approx(sizes[np.argmax(selection.at(sizes))], rel=1e-3)
    assert selection.at([1e-3])[0] == pytest.approx(0.6, rel=0.01)
    half = AustinSelection(0.6, 0.9, 1e3, 3.0).at([8e-3])[0] / 2.0
    assert selection.at([8e-3])[0] == pytest.approx(half, rel=1e-12)
    assert AustinSelection(1.0, 2.0, 1e-2, 1.5).fastest is None


def test_the_fit_of_austin_returns_his_constants():
    given = AustinSelection(rate=0.02, exponent=0.8, size=6e-3, fall=2.6)
    sizes = np.geomspace(5e-4, 4e-2, 14)
    found, error = fit_austin(sizes, given.at(sizes))
    assert error < 1e-6
    for name in ("rate", "exponent", "size", "fall"):
        assert getattr(found, name) == pytest.approx(getattr(given, name), rel=1e-4)
    with pytest.raises(ValueError, match="5 or more"):
        fit_austin(sizes[:4], given.at(sizes[:4]))


@pytest.mark.parametrize(("particles", "share"), [(0.0, 0.5), (1.0, 0.0), (1.0, 1.1)])
def test_a_nip_that_catches_nothing_is_refused(particles, share):
    with pytest.raises(ValueError, match="accepted"):
        Nip(particles, share)
