import re
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import contactstudy as cs
from contactstudy.elasticity.kernels.stress import BOUSSINESQ
from tests.conftest import STEEL

FREE = cs.ZeroPadding(), cs.ZeroPadding()
LOAD, CYLINDER = cs.LineLoad(1.5e5), cs.Cylinder(0.005)
HERTZ = cs.Scene(LOAD, (STEEL, STEEL), (CYLINDER,)).hertz
LENGTH = 20 * HERTZ.half_width
GRID = cs.Grid((32, 160), (2.6 * HERTZ.half_width, LENGTH))
ENDED = cs.FreeFaces(STEEL, LENGTH)
ROLLER = cs.Scene(LOAD, (ENDED, STEEL), (CYLINDER,))


def line(scene: cs.Scene, grid: cs.Grid = GRID) -> np.ndarray:
    """Largest pressure across over that of Hertz (y,)."""
    solution = cs.solve(scene, grid, FREE)
    assert solution.status is cs.Status.CONVERGED
    return np.asarray(solution.pressure.max(axis=0) / HERTZ.peak_pressure)


def test_a_sharp_end_of_one_body_grows_as_beside_a_right_angle_and_no_faster() -> None:
    """By ``r^-0.226`` (Dundurs & Lee 1972), of which cells of an eighth of the half-width show the beginning."""
    ends = [line(ROLLER, cs.Grid((4 * n, 20 * n), GRID.extent))[0] for n in (8, 16, 32)]
    orders = np.log2(np.divide(ends[1:], ends[:-1]))
    assert np.all((orders > 0.15) & (orders < 0.24))
    assert orders[1] > orders[0]


def test_two_rollers_that_end_in_one_plane_have_no_peak_at_their_ends() -> None:
    both = line(replace(ROLLER, solids=(ENDED, ENDED)))
    assert both.max() < 1.05
    assert both[0] < both[80]
    assert line(ROLLER)[0] > 1.3


def test_a_body_that_ends_far_beyond_the_contact_is_a_half_space() -> None:
    ball, far = (cs.Sphere(0.005),), cs.FreeFaces(STEEL, 1e4 * LENGTH)
    ended, infinite = (
        cs.solve(cs.Scene(LOAD, (body, STEEL), ball), cs.Grid((32, 32), (LENGTH / 4, LENGTH / 4)), FREE).pressure
        for body in (far, STEEL)
    )
    assert np.abs(ended - infinite).max() < 1e-3 * infinite.max()


def test_a_longer_grid_and_exchanged_bodies_change_nothing() -> None:
    total = replace(ROLLER, load=cs.TotalLoad(LOAD.per_length * LENGTH))
    longer = line(total, cs.Grid((32, 200), (GRID.extent[0], 1.25 * LENGTH)))
    assert_allclose(longer[20:-20], line(total), rtol=1e-5)
    assert not longer[:20].any()
    assert_allclose(line(replace(ROLLER, solids=(STEEL, ENDED))), line(ROLLER), rtol=1e-5)


def test_the_shorter_of_two_bodies_ends_the_contact_and_the_longer_is_stiffer_there() -> None:
    longer = cs.FreeFaces(STEEL, 1.2 * LENGTH)
    both = replace(ROLLER, solids=(ENDED, longer))
    assert both.roller_length == LENGTH
    ends = [line(replace(ROLLER, solids=(ENDED, other)))[0] for other in (ENDED, longer, STEEL)]
    assert ends[0] < ends[1] < ends[2]


def test_a_plan_ends_at_the_faces_and_a_peak_has_a_bound_where_it_is_not_at_a_sharp_end() -> None:
    sharp = cs.solve(ROLLER, error="4 %")
    assert sharp.grid.length == pytest.approx(LENGTH)
    assert not sharp.quantities["peak_pressure"].relative_bound < np.inf
    flush = cs.solve(replace(ROLLER, solids=(ENDED, ENDED)), error="4 %")
    assert flush.quantities["peak_pressure"].relative_bound < 0.05
    assert flush.error.l1.total < 0.04


def test_stress_below_leaves_the_faces_free_and_is_the_pressure_at_the_surface() -> None:
    stress = (cs.SubsurfaceStress(tuple(HERTZ.half_width * np.array([0.001, 0.25, 0.78])), body=1),)
    lundberg = cs.LundbergProfile.for_load(
        LOAD.per_length, contact_modulus=HERTZ.contact_modulus, radius=0.005, length=LENGTH
    )
    fields = []
    for body in (ENDED, STEEL):
        contact = cs.solve(cs.Scene(LOAD, (STEEL, body), (CYLINDER, lundberg), outputs=stress), GRID, FREE)
        fields.append(contact.derived["stress"].values)
        at_surface = fields[-1][2, 0] + contact.pressure
        assert np.abs(at_surface[:, 2:-2]).max() < 0.01 * HERTZ.peak_pressure
    # normal and shear traction on the face, by a parabola through the three cells beside it
    faces, without = (np.abs(field[[1, 3, 5], 1:][..., :3] @ (1.875, -1.25, 0.375)).max() for field in fields)
    assert faces < 0.02 * HERTZ.peak_pressure
    assert without > 0.05 * HERTZ.peak_pressure
    middle = (fields[0] - fields[1])[[2, 4], :, 16, 80]
    assert np.abs(middle).max() < 0.05 * HERTZ.peak_pressure


def test_the_stress_of_a_pressure_beside_one_face_is_mirrored_beside_the_other() -> None:
    grid = cs.Grid((8, 16), (1.0, 4.0))
    below = cs.SubsurfaceStress((0.3,), body=0).of((cs.FreeFaces(STEEL, 4.0), STEEL), grid, FREE)
    pressure = np.random.default_rng(1).random(grid.cells) * (np.arange(16) < 5)
    stress, mirrored = below(pressure), below(pressure[:, ::-1])[..., ::-1]
    turning = np.array([kernel.parity[1] for kernel in BOUSSINESQ.values()])[:, None, None, None]
    assert_allclose(turning * mirrored, stress, atol=1e-12)
    assert np.abs(stress[..., :3]).max() > 10 * np.abs(stress[..., -3:]).max()


def test_without_faces_the_first_warning_names_them_for_the_end_of_a_half_space() -> None:
    ended = cs.Scene(LOAD, (STEEL, STEEL), (CYLINDER, cs.FiniteLength(LENGTH)))
    first = cs.solve(ended, cs.Grid((16, 80), GRID.extent), FREE).error.warnings[0]
    assert f'free_faces = "{LENGTH * 1e3:.4g} mm" of Scene.solids[0]' in first


def test_ends_that_a_profile_does_not_relieve_are_told_a_drop_that_does() -> None:
    def solved(profile: cs.Shape) -> cs.Contact:
        scene = cs.Scene(cs.TotalLoad(1500.0), (STEEL, STEEL), (CYLINDER, profile, cs.FiniteLength(10e-3)))
        return cs.solve(scene, cs.Grid((32, 120), (6e-4, 10e-3)), FREE)

    (said,) = (text for text in solved(cs.Crown.of_drop(1e-6, 10e-3)).error.warnings if "suggested drop" in text)
    numbers = dict(re.findall(r"(amplitude|end_drop|length)=([-+.e\d]+)", said))
    relieved = solved(cs.LundbergProfile(**{name: float(text) for name, text in numbers.items()}))
    along = relieved.pressure.max(axis=0)
    assert along.max() < 1.05 * along[12:-12].max()
    highest = float(said.split("on this grid is ")[1].split(" GPa")[0])
    assert highest == pytest.approx(along.max() / 1e9, rel=5e-3)  # of a drop of three digits


def test_one_row_of_cells_gives_no_bound_of_a_peak_that_may_lie_at_an_end() -> None:
    contact = cs.solve(replace(ROLLER, solids=(ENDED, ENDED)), cs.Grid((32, 1), GRID.extent), FREE)
    assert contact.quantities["peak_pressure"].bound == np.inf
