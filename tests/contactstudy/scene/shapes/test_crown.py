import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import integrate

import contactstudy as cs
from tests.conftest import LineContact

FREE = (cs.ZeroPadding(), cs.ZeroPadding())
LENGTH = 16.0  # half-widths


def roller(contact: LineContact, *more: cs.Shape, across: int = 32) -> cs.Solution:
    """A roller of square cells whose ends are the grid's."""
    scene = replace(contact.scene, shapes=contact.scene.shapes + more)
    grid = contact.grid((across, round(across * LENGTH / 2.5)), LENGTH, width=2.5)
    return cs.solve(scene.problem(grid, FREE))


def lundberg(contact: LineContact, length: float = LENGTH) -> cs.LundbergProfile:
    return cs.LundbergProfile.for_load(
        contact.scene.load.per_length,
        contact_modulus=contact.scene.contact_modulus,
        radius=0.01,
        length=length * contact.hertz.half_width,
    )


def test_crown_drops_at_the_ends_by_what_was_asked() -> None:
    crown = cs.Crown.of_drop(5e-6, 0.01)
    assert crown.radius == pytest.approx(2.5)
    grid = cs.Grid(cells=(4, 1001), extent=(1e-3, 0.01 * 1001 / 1000))
    gap = crown.gap(grid)
    assert gap.shape == (1, 1001)
    assert gap[0, [0, 500, -1]] == pytest.approx([5e-6, 0, 5e-6], rel=1e-12)


def test_a_roller_is_planned_over_the_length_of_its_load() -> None:
    """As ``[load] length`` in a file gives it, where no shape has a length."""
    steel = cs.HalfSpace(206e9, 0.3)
    load = cs.TotalLoad(1500.0, length=0.01)
    scene = cs.Scene(load, (steel, steel), (cs.Cylinder(0.005), cs.Crown(2.5)))
    assert cs.plan(scene, error=0.05).grid.length == 0.01


@pytest.mark.parametrize("drop", [1e-6, 1.0])
def test_profile_follows_its_formula_and_ends_at_its_drop(drop: float) -> None:
    """Without bound it is Lundberg's own."""
    profile = cs.LundbergProfile(amplitude=2e-7, end_drop=drop, length=0.01)
    grid = cs.Grid(cells=(4, 64), extent=(1e-3, 0.01))
    t = 2 * grid.y / 0.01
    expected = -2e-7 * np.log(1 - (1 - math.exp(-drop / 2e-7)) * t**2)
    np.testing.assert_allclose(profile.gap(grid)[0], expected, rtol=1e-12)
    longer = cs.Grid(cells=(4, 128), extent=(1e-3, 0.02))
    assert (profile.gap(longer)[0, :32] == drop).all()


@pytest.mark.parametrize("amplitude", [1e3, 1e60])
def test_an_amplitude_without_bound_is_a_parabola(amplitude: float) -> None:
    """``-A ln(1 - d t^2 / A)`` differs from it by parts of d / A."""
    profile = cs.LundbergProfile(amplitude, end_drop=1e-6, length=0.01)
    grid = cs.Grid(cells=(4, 64), extent=(1e-3, 0.01))
    np.testing.assert_allclose(profile.gap(grid)[0], 1e-6 * (2 * grid.y / 0.01) ** 2, rtol=1e-8)


@pytest.mark.parametrize("fraction", [0.5, 1.0])
def test_profile_is_what_an_even_pressure_of_finite_length_lifts(fraction: float, line_contact: LineContact) -> None:
    """Displacement of the axis under Hertz's pressure on ``|y| < l``, by quadrature of Boussinesq's.

    Lundberg's profile leaves out, and so does the drop at the ends, what falls as the square of half-width
    over length.
    """
    hertz, errors = line_contact.hertz, []
    for length in (8.0, 16.0, 32.0):
        end = length / 2

        def displaced(y: float, end: float = end) -> float:
            def along(x: float) -> float:
                ends = math.asinh((end - y) / x) + math.asinh((end + y) / x)
                return math.sqrt(1 - x * x) * ends

            return 4 / math.pi * float(integrate.quad(along, 0, 1, epsabs=1e-12, epsrel=1e-12)[0])

        amplitude = hertz.load_per_length / (math.pi * hertz.contact_modulus)
        lifted = amplitude * (displaced(0.0) - displaced(fraction * end))
        profile = lundberg(line_contact, length)
        if fraction < 1:
            profile = replace(profile, end_drop=1.0)
        grid = cs.Grid(cells=(2, 2), extent=(1.0, 2 * fraction * profile.length))
        drop = profile.gap(grid)[0, 0]
        errors.append(abs(drop - lifted) / amplitude)
    assert errors[-1] <= errors[0] / 13, errors  # second order would be 16
    assert errors[-1] < 0.5 / 16**2


def test_ends_of_a_cylindrical_roller_bear_a_peak_that_grows_with_the_grid(
    line_contact: LineContact,
) -> None:
    """Like the inverse root of the distance, as under a sharp punch: by root two a halving."""
    peaks = [roller(line_contact, across=n).pressure.max() for n in (32, 64)]
    assert peaks[0] > 2 * line_contact.hertz.peak_pressure
    assert peaks[1] / peaks[0] == pytest.approx(math.sqrt(2), rel=0.05)


def test_a_lundberg_profile_removes_the_peak_at_the_ends(line_contact: LineContact) -> None:
    """What is left is bounded, and the pressure is Hertz's all along but for the ends."""
    profile, p_h = lundberg(line_contact), line_contact.hertz.peak_pressure
    coarse, fine = (roller(line_contact, profile, across=n).pressure for n in (32, 64))
    assert fine.max() < 1.15 * p_h
    assert fine.max() / coarse.max() == pytest.approx(1, abs=0.03)
    count = fine.shape[1]
    axis = fine[fine.shape[0] // 2, count // 10 : -count // 10]
    assert np.abs(axis / p_h - 1).max() < 0.03


@pytest.mark.parametrize(("length", "factor"), [(12e-3, 3.5e-4), (40e-3, 5e-4)])
def test_the_profile_of_iso_16281_is_the_formula_of_the_standard(length: float, factor: float) -> None:
    """A roller longer than 2.5 diameters is straight in the middle."""
    diameter, profiled = 10e-3, min(length, 25e-3)
    grid = cs.Grid((2, 80), (1e-3, length))
    t = np.maximum(2 * np.abs(grid.y) - (length - profiled), 0) / profiled
    within = t < 0.9
    profile = cs.LundbergProfile.iso_16281(diameter, length).gap(grid)[0, within]
    standard = -factor * diameter * np.log(1 - t[within] ** 2)
    np.testing.assert_allclose(profile, standard, atol=0.003 * factor * diameter)
