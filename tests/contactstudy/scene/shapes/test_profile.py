"""Profiles by points, arcs and chamfers, and the modified logarithmic profile, by hand."""

from math import exp, pi, tan
from pathlib import Path

import numpy as np
import pytest

import contactstudy as cs

GRID = cs.Grid((4, 100), (1e-3, 10e-3))
Y = np.abs(GRID.y)


def test_a_rounded_end_is_a_circle_tangential_to_the_straight_part() -> None:
    drop = cs.EndRelief(10e-3, 8e-3, end_radius=2e-3).gap(GRID)[0]
    beyond = np.maximum(Y - 4e-3, 0)
    assert drop == pytest.approx(2e-3 - np.sqrt(4e-6 - beyond**2))


def test_two_radii_meet_in_their_tangent() -> None:
    drop = cs.EndRelief(10e-3, 6e-3, end_radius=0.5, radius=4.0).gap(GRID)[0]
    beyond = np.maximum(Y - 3e-3, 0)
    middle = np.minimum(Y, 3e-3) ** 2 / 8
    expected = middle + 3e-3 / 4 * beyond + beyond**2 / (2 * 0.5)
    assert drop == pytest.approx(expected, rel=1e-4, abs=1e-15)


def test_a_chamfer_has_its_angle() -> None:
    drop = cs.EndRelief(10e-3, 9e-3, end_angle=0.1).gap(GRID)[0]
    assert drop == pytest.approx(np.maximum(Y - 4.5e-3, 0) * tan(0.1))


def test_points_are_met_and_a_half_is_mirrored() -> None:
    half = cs.ProfilePoints((0.0, 2e-3, 4e-3, 5e-3), (0.0, 0.0, 2e-6, 6e-6))
    places, drops = (-5e-3, -4e-3, -2e-3, 2e-3, 4e-3, 5e-3), (6e-6, 2e-6, 0.0, 0.0, 2e-6, 6e-6)
    whole = cs.ProfilePoints(places, drops)
    grid = cs.Grid((2, 11), (1e-3, 11e-3))
    for profile in (half, whole):
        assert profile.length == pytest.approx(10e-3)
        assert profile.gap(grid)[0, [10, 9, 7, 5]] == pytest.approx([6e-6, 2e-6, 0, 0], abs=1e-18)
        assert profile.gap(grid)[0] == pytest.approx(profile.gap(grid)[0, ::-1], abs=1e-18)
    shifted = cs.ProfilePoints(tuple(y + 20e-3 for y in places), drops)
    assert shifted.gap(grid) == pytest.approx(whole.gap(grid), abs=1e-15)


SCENE = """
[load]
total = "1.5 kN"
[[solids]]
material = "steel"
[[solids]]
material = "steel"
[[shapes]]
kind = "Cylinder"
radius = "5 mm"
[[shapes]]
"""


def read(profile: str, folder: Path) -> cs.Scene:
    path = folder / "scene.toml"
    path.write_text(SCENE + profile, encoding="utf-8")
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
    assert scene.shapes[1].gap(GRID)[0] == pytest.approx(expected, abs=1e-15)
    plain, even = read(keys, tmp_path), read(keys + "k1 = 1\nk2 = 1", tmp_path)
    assert plain == even
    with pytest.raises(cs.InvalidInput, match="give for_load"):
        read(
            keys.replace('for_load = "150 N/mm"', 'iso_16281_diameter = "1 cm"') + "k1 = 2",
            tmp_path,
        )
