"""Rollers: crowns, profiles, ends and tilt."""

import math
from dataclasses import replace
from math import atan, exp, pi, tan
from pathlib import Path

import numpy as np
import pytest
from scipy import optimize

import contactstudy as cs
from tests.conftest import STEEL, LineContact

FREE = (cs.ZeroPadding(), cs.ZeroPadding())
RADIUS, LENGTH, LOAD = 5e-3, 10e-3, 1500.0
GRID = cs.Grid((48, 200), (0.6e-3, LENGTH))
ALONG = cs.Grid((4, 100), (1e-3, LENGTH))
Y = np.abs(ALONG.y)


def roller(*shapes: cs.Shape) -> cs.Solution:
    """A roller of `LENGTH` under `LOAD`, whose ends are the grid's."""
    scene = cs.Scene(cs.TotalLoad(LOAD, LENGTH), (STEEL, STEEL), (cs.Cylinder(RADIUS), *shapes))
    return cs.solve(scene.problem(GRID, FREE), tolerance=1e-9)


def lundberg(contact: LineContact, length: float) -> cs.LundbergProfile:
    return cs.LundbergProfile.for_load(
        contact.scene.load.per_length,
        contact_modulus=contact.scene.contact_modulus,
        radius=0.01,
        length=length * contact.hertz.half_width,
    )


def test_crowns_ends_and_tilt_have_their_heights_and_lengths() -> None:
    grid, y = cs.Grid((4, 3), (4.0, 6.0)), np.array([-2.0, 0.0, 2.0])
    assert cs.Crown(5.0).gap(grid) == pytest.approx((y**2 / 10)[None])
    assert cs.Crown.of_drop(5e-6, 0.01).radius == pytest.approx(2.5)
    assert cs.Tilt(0.01).gap(grid) == pytest.approx(tan(0.01) * y[None])
    # 4 m long: the middle cell and those whose centres lie on the ends
    assert cs.FiniteLength(4.0).gap(grid).tolist() == [[0.0]] * 4
    assert cs.FiniteLength(3.9).gap(grid).tolist() == [[3.9, 0.0, 3.9]]
    # cells of 2 m, of which 0.95 m lie on the roller: the cell in the middle stands for them
    assert cs.FiniteLength(3.9).covered_fractions(grid) == pytest.approx([0.0, 1.95, 0.0])
    assert cs.FiniteLength(4.4).covered_fractions(grid) == pytest.approx([0.6, 1.0, 0.6])
    lengths = {
        cs.FiniteLength(2.0): 2.0, cs.Crown(5.0): math.inf, cs.Crown(5.0, 0.01): 0.01, cs.Crown(length=0.01): 0.01,
        cs.Crown.of_drop(0.0, 0.01): 0.01, cs.Crown(): 0.0, cs.Tilt(1e-3): math.inf, cs.Tilt(0.0): 0.0,
        cs.LundbergProfile(1e-6, 1e-5, 2.0): 2.0,
    }  # fmt: skip
    for shape, length in lengths.items():
        assert shape.length_scales.roller == length


@pytest.mark.parametrize("drop", [1e-6, 1.0])
def test_a_profile_follows_its_formula_and_ends_at_its_drop(drop: float) -> None:
    """Without bound it is Lundberg's own; of an amplitude without bound it is a parabola."""
    profile, t = cs.LundbergProfile(amplitude=2e-7, end_drop=drop, length=LENGTH), 2 * ALONG.y / LENGTH
    expected = -2e-7 * np.log(1 - (1 - math.exp(-drop / 2e-7)) * t**2)
    np.testing.assert_allclose(profile.gap(ALONG)[0], expected, rtol=1e-12)
    longer = cs.Grid(cells=(4, 128), extent=(1e-3, 2 * LENGTH))
    assert (profile.gap(longer)[0, :32] == drop).all()
    np.testing.assert_allclose(replace(profile, amplitude=1e60).gap(ALONG)[0], drop * t**2, rtol=1e-8)


def test_a_lundberg_profile_removes_the_peak_at_sharp_ends(line_contact: LineContact) -> None:
    """That grows like the inverse root of the distance, as under a sharp punch: by root two a halving.

    What is left is bounded, and the pressure is Hertz's all along but for the ends.
    """
    profile, p_h = lundberg(line_contact, 16.0), line_contact.hertz.peak_pressure
    (sharp, profiled), (sharper, fine) = (
        [
            cs.solve(line_contact.with_shapes(*more).problem(line_contact.grid(cells, 16.0, 2.5), FREE)).pressure
            for more in ((), (profile,))
        ]
        for cells in ((32, 205), (64, 410))
    )
    assert sharp.max() > 2 * p_h
    assert sharper.max() / sharp.max() == pytest.approx(math.sqrt(2), rel=0.05)
    assert fine.max() < 1.15 * p_h
    assert fine.max() / profiled.max() == pytest.approx(1, abs=0.03)
    assert np.abs(fine[32, 41:-41] / p_h - 1).max() < 0.03


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


def test_end_reliefs_are_tangential_arcs_or_chamfers() -> None:
    rounded = cs.EndRelief(10e-3, 8e-3, end_radius=2e-3).gap(ALONG)[0]
    assert rounded == pytest.approx(2e-3 - np.sqrt(4e-6 - np.maximum(Y - 4e-3, 0) ** 2))
    two_radii = cs.EndRelief(10e-3, 6e-3, end_radius=0.5, radius=4.0).gap(ALONG)[0]
    beyond = np.maximum(Y - 3e-3, 0)
    expected = np.minimum(Y, 3e-3) ** 2 / 8 + 3e-3 / 4 * beyond + beyond**2 / (2 * 0.5)
    assert two_radii == pytest.approx(expected, rel=1e-4, abs=1e-15)
    chamfered = cs.EndRelief(10e-3, 9e-3, end_angle=0.1).gap(ALONG)[0]
    assert chamfered == pytest.approx(np.maximum(Y - 4.5e-3, 0) * tan(0.1))


def test_points_are_met_and_a_half_is_mirrored() -> None:
    half = cs.ProfilePoints((0.0, 2e-3, 4e-3, 5e-3), (0.0, 0.0, 2e-6, 6e-6))
    places, drops = (-5e-3, -4e-3, -2e-3, 2e-3, 4e-3, 5e-3), (6e-6, 2e-6, 0.0, 0.0, 2e-6, 6e-6)
    shifted = cs.ProfilePoints(tuple(y + 20e-3 for y in places), drops)
    for profile in (half, cs.ProfilePoints(places, drops), shifted):
        gap = profile.gap(cs.Grid((2, 11), (1e-3, 11e-3)))[0]
        assert profile.length == pytest.approx(10e-3)
        assert gap[[10, 9, 7, 5]] == pytest.approx([6e-6, 2e-6, 0, 0], abs=1e-15)
        assert gap == pytest.approx(gap[::-1], abs=1e-15)


def read(profile: str, folder: Path) -> cs.Scene:
    """A scene file of a cylinder with a profile."""
    steel = '[[solids]]\nmaterial = "steel"\n'
    cylinder = '[[shapes]]\nkind = "Cylinder"\nradius = "5 mm"\n'
    path = folder / "scene.toml"
    path.write_text(f'[load]\ntotal = "1.5 kN"\n{2 * steel}{cylinder}[[shapes]]\n{profile}', encoding="utf-8")
    return cs.read_scene(path).scene


@pytest.mark.parametrize(("header", "sign"), [("y [mm], drop [um]", 1.0), ("position (mm);height (µm)", -1.0)])
def test_a_file_of_two_columns_with_units_is_a_roller_of_its_length(header: str, sign: float, tmp_path: Path) -> None:
    mark = ";" if ";" in header else ","
    rows = (f"{y}{mark}{sign * d}" for y, d in ((-5, 6.5), (-4, 2.5), (0, 0.5), (4, 2.5), (5, 6.5)))
    (tmp_path / "p.csv").write_text("\n".join((header, *rows)), encoding="utf-8")
    scene = read('kind = "ProfilePoints"\nfile = "p.csv"', tmp_path)
    assert scene.roller_length == pytest.approx(10e-3)
    drop = scene.shapes[1].gap(cs.Grid((2, 11), (1e-3, 11e-3)))[0]
    assert drop[10] - drop[5] == pytest.approx(6e-6)
    (tmp_path / "p.csv").write_text("1,2\n2,3", encoding="utf-8")
    with pytest.raises(cs.InvalidInput, match="two columns with their units in the header"):
        read('kind = "ProfilePoints"\nfile = "p.csv"', tmp_path)


def test_the_modified_logarithmic_profile_is_that_of_fujiwara_and_kawase(tmp_path: Path) -> None:
    keys = 'kind = "LundbergProfile"\nlength = "10 mm"\nfor_load = "150 N/mm"\n'
    scene = read(keys + "k1 = 1.5\nk2 = 0.6\nz_m = '8 um'", tmp_path)
    # their A = 2 K1 Q / (pi L E'), E' = E / (1 - nu^2) of two equal bodies
    a, modulus = 5e-3, 210e9 / (1 - 0.3**2)
    amplitude = 2 * 1.5 * 1.5e5 / (pi * modulus)
    t = np.maximum((Y - a) / (0.6 * a) + 1, 0)
    expected = amplitude * np.log(1 / (1 - (1 - exp(-8e-6 / amplitude)) * t**2))
    assert scene.shapes[1].gap(ALONG)[0] == pytest.approx(expected, abs=1e-15)
    assert read(keys, tmp_path) == read(keys + "k1 = 1\nk2 = 1", tmp_path)
    with pytest.raises(cs.InvalidInput, match="give for_load"):
        read(keys.replace('for_load = "150 N/mm"', 'iso_16281_diameter = "1 cm"') + "k1 = 2", tmp_path)


def test_a_roller_ends_within_a_grid_as_at_the_end_of_one(line_contact: LineContact) -> None:
    """Both stop at a residual of 1e-9, whose error is no more than its root.

    The mean gap is that of the roller, also where its ends lie inside cells, of 0.1263 half-widths.
    """
    length = 8 * line_contact.hertz.half_width

    def solved(cells: int, period: float, *more: cs.Shape) -> cs.Solution:
        grid = line_contact.grid((32, cells), period, width=3.0)
        return cs.solve(line_contact.with_shapes(*more).problem(grid, FREE), tolerance=1e-9)

    own, longer, divided = (
        solved(64, 8.0), solved(96, 12.0, cs.FiniteLength(length)), solved(95, 12.0, cs.FiniteLength(length)),
    )  # fmt: skip
    assert not longer.pressure[:, [*range(16), *range(80, 96)]].any()
    np.testing.assert_allclose(longer.pressure[:, 16:-16], own.pressure, rtol=0, atol=3e-5 * own.pressure.max())
    assert longer.mean_gap == pytest.approx(own.mean_gap, rel=1e-4)
    # the pressure ends at the border of a cell, up to half a cell from the end
    assert divided.mean_gap == pytest.approx(own.mean_gap, rel=0.126 / 8)
    assert divided.gap.mean() > 100 * own.mean_gap  # the rows beyond the ends are recessed by the roller's length


def test_a_tilted_crown_is_the_crown_beside_the_middle() -> None:
    """``y^2 / (2 R) + y t`` is the parabola about ``-R t``, less a constant."""
    crown, cells = cs.Crown(0.3), 10
    straight = roller(crown).pressure
    tilted = roller(crown, cs.Tilt(atan(cells * GRID.cell_size[1] / crown.radius))).pressure
    shifted = np.roll(straight, -cells, axis=1)
    np.testing.assert_allclose(tilted, shifted, rtol=0, atol=1e-7 * straight.max())


@pytest.mark.parametrize("angle", [2e-4, 5e-4])
def test_a_profiled_roller_follows_the_slices_of_palmgren(angle: float) -> None:
    """Slices under ``d = 3.84e-5 q^0.9 L^0.1`` (N, mm; Palmgren 1959) miss the peak by 2 % where no end bears."""
    profile = cs.LundbergProfile.iso_16281(2 * RADIUS, LENGTH)
    tilted = roller(profile, cs.Tilt(angle))
    drop = 1e3 * (profile.gap(GRID) + cs.Tilt(angle).gap(GRID))[0]  # mm
    stiffness = 3.84e-5 ** (-10 / 9) * (1e3 * LENGTH) ** (-1 / 9)

    def loads(approach: float) -> np.ndarray:
        return np.asarray(stiffness * np.clip(approach - drop, 0, None) ** (10 / 9))  # N/mm

    def excess(approach: float) -> float:
        return float(loads(approach).mean()) * 1e3 * LENGTH - LOAD

    per_length = 1e3 * loads(float(optimize.brentq(excess, -1.0, 1.0)))
    modulus = STEEL.youngs_modulus / (2 * (1 - STEEL.poisson_ratio**2))
    slices = np.sqrt(per_length * modulus / (pi * RADIUS))
    assert tilted.pressure.max() == pytest.approx(slices.max(), rel=0.02)
    place = GRID.y[[tilted.pressure.max(axis=0).argmax(), slices.argmax()]]
    assert place[0] == pytest.approx(place[1], abs=LENGTH / 20)


def test_a_roller_is_planned_over_its_own_length_or_that_of_its_load() -> None:
    profile = cs.LundbergProfile.iso_16281(2 * RADIUS, LENGTH)
    for load, shapes in (
        (cs.TotalLoad(LOAD), (profile, cs.Tilt(5e-4))),
        (cs.TotalLoad(LOAD, length=LENGTH), (cs.Crown(2.5),)),
    ):
        planned = cs.plan(cs.Scene(load, (STEEL, STEEL), (cs.Cylinder(RADIUS), *shapes)), error=0.05)
        assert (planned.grid.length, planned.padding) == (LENGTH, FREE)
    endless = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(RADIUS), cs.Tilt(5e-4)))
    with pytest.raises(cs.InvalidInput, match="a roller without a length"):
        cs.plan(endless)
