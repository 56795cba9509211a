from dataclasses import replace
from math import inf
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.scene.friction import dundurs
from tests.conftest import STEEL

MU, RADIUS, EXACT = 0.3, 0.01, cs.ExactPeriodicity()
FREE = cs.ZeroPadding(), cs.ZeroPadding()
CYLINDER = (cs.Cylinder(radius=RADIUS),)
ROUGH = (*CYLINDER, cs.Roughness(2e-7, hurst=0.8, roll_off=1e-4, cut_off=2e-5, seed=1))
CROWN = cs.Crown(1.0)
LOAD = cs.LineLoad(1e5)
SMOOTH = cs.Scene(LOAD, (STEEL, STEEL), CYLINDER)
A, P0 = SMOOTH.hertz.half_width, SMOOTH.hertz.peak_pressure
# Creepage at which all of the contact slides, Carter (1926).
SATURATION = MU * A / RADIUS


def rolling(**creepage: float) -> cs.TractiveRolling:
    return cs.TractiveRolling(MU, **{"longitudinal": 0.0, **creepage})


def solved(
    friction: object, cells: tuple[int, int] = (128, 1), tolerance: float = 1e-8, **other: object
) -> cs.Solution:
    scene = replace(SMOOTH, friction=friction, **other)
    grid = cs.Grid(cells, (3.2e-4 if other else 2.4 * A, 3.2e-4))
    return cs.solve(scene.problem(grid, cs.ExactPeriodicity()), tolerance=tolerance)


@pytest.mark.parametrize("part", [0.1, 0.9])
@pytest.mark.parametrize("cells", [32, 1024])
def test_shear_of_a_cylinder_is_carters(cells: int, part: float) -> None:
    """The error of the force is of first order, by where the stick-slip boundary falls in its cell."""
    solution = solved(rolling(longitudinal=part * SATURATION), (cells, 1))
    dx = solution.problem.grid.cell_size[0]
    assert solution.status is cs.Status.CONVERGED
    error = solution.shear.sum() / solution.pressure.sum() - MU * (1 - (1 - part) ** 2)
    assert abs(error) <= solution.traction.errors.force <= 50 * MU / cells
    assert solution.stick.sum() * dx / 2 == pytest.approx(A * (1 - part), abs=dx)
    x, half = solution.problem.grid.x, A * (1 - part)
    whole, stuck = (
        np.sqrt(np.maximum(1 - ((x - middle) / width) ** 2, 0)) for middle, width in ((0.0, A), (A - half, half))
    )
    carter = MU * P0 * (whole - half / A * stuck)
    assert np.abs(solution.shear[0, :, 0] - carter).mean() < 4 * MU * P0 / cells
    assert solution.traction.iterations <= 30


def steady(law: cs.TractiveRolling, body: cs.HalfSpace, grid: cs.Grid, pressure: np.ndarray, to: float) -> np.ndarray:
    """Traction (2, x, y) of two bodies alike that roll under a given pressure."""
    scene = cs.Scene(cs.LineLoad(1.0), (body, body), (cs.Sphere(1.0),), friction=law)
    friction = scene.problem(grid, FREE).friction
    return friction.steady(grid, pressure, cs.SolveOptions(to))[0].shear


@pytest.mark.parametrize(
    ("poisson_ratio", "shape", "c11", "c22", "c23"),
    [
        (0.0, 1.0, 3.40, 3.40, 1.33), (0.5, 1.0, 5.20, 3.98, 1.63), (0.25, 2.0, 5.10, 4.90, 2.62),
    ],
)  # fmt: skip
def test_small_creepages_act_by_kalkers_coefficients(
    poisson_ratio: float, shape: float, c11: float, c22: float, c23: float
) -> None:
    """Kalker (1990), table E.3: ``F = G a b C11 xi``, ``G a b C22 eta``, ``G (a b)^1.5 C23 phi``; read to 1 %."""
    body = cs.HalfSpace(1e9, poisson_ratio)
    grid, modulus = cs.Grid((72, 72), (2.2 * shape, 2.2)), 1e9 / 2 / (1 + poisson_ratio)
    pressure = np.sqrt(np.maximum(1 - (grid.x[:, None] / shape) ** 2 - grid.y**2, 0))
    for creepage, axis, expected in (
        ({"longitudinal": 1e-14}, 0, c11 * shape),
        ({"lateral": 1e-14}, 1, c22 * shape),
        ({"spin": 1e-14}, 1, c23 * shape**1.5),
    ):
        force = steady(rolling(**creepage), body, grid, pressure, 1e-6)[axis].sum() * grid.cell_area
        assert force / (modulus * 1e-14) == pytest.approx(expected, rel=1.5e-2)


@pytest.mark.parametrize(
    ("xi", "eta", "phi", "force", "stick"),
    [
        (0.1, 0, 0, (0.42520, 0), 0.754), (0, 0, 0.5, (0, 0.61135), 0.080), (0.2, 0.1, 0.4, (0.46419, 0.70450), 0.054),
    ],
)  # fmt: skip
def test_a_sphere_with_creepage_and_spin(
    xi: float, eta: float, phi: float, force: tuple[float, float], stick: float
) -> None:
    """Computed once by another program on this grid, to the digits given; a = p_0 = E* = 1."""
    body = cs.HalfSpace(2 * (1 - 0.25**2), 0.25)
    grid = cs.Grid((64, 64), (2.2, 2.2))
    pressure = np.sqrt(np.maximum(1 - grid.x[:, None] ** 2 - grid.y**2, 0))
    shear = steady(rolling(longitudinal=xi, lateral=eta, spin=phi), body, grid, pressure, 1e-7)
    assert shear.sum(axis=(1, 2)) / (MU * pressure.sum()) == pytest.approx(force, abs=1e-5)
    sticks = (np.hypot(*shear) < MU * pressure * (1 - 1e-6)).sum() / (pressure > 0).sum()
    assert sticks == pytest.approx(stick, abs=1e-3)


def test_power_is_that_of_the_creepages() -> None:
    """``V (Qx xi + Qy eta + M phi)``; nowhere below 0 by more than the direction of slip turns in a cell."""
    friction = rolling(longitudinal=0.4 * SATURATION, lateral=-0.1 * SATURATION, spin=3.0, speed=2.0)
    solution = solved(friction, (64, 64), 1e-9, shapes=(*ROUGH, CROWN))
    grid, (qx, qy) = solution.problem.grid, solution.shear
    work = qx * (friction.longitudinal - 3.0 * grid.y) + qy * (friction.lateral + 3.0 * grid.x[:, None])
    power = solution.traction.power
    # spin acts half a cell off in the mean of two steps
    assert power.sum() == pytest.approx(2.0 * work.sum(), rel=1e-3)
    assert power.min() > -1e-3 * power.max()


def test_without_creepage_nothing_is_sheared_and_at_the_largest_all_slides() -> None:
    still = solved(rolling(), (64, 1))
    assert not still.shear.any()
    assert (still.stick == (still.pressure > 0)).all()
    sliding = solved(cs.Sliding(MU), (64, 16), shapes=ROUGH)
    rolled = solved(rolling(longitudinal=1e3 * SATURATION), (64, 16), shapes=ROUGH)
    np.testing.assert_allclose(rolled.shear[0], sliding.shear[0], rtol=1e-5)
    assert np.abs(rolled.shear[1]).max() < 1e-2 * sliding.shear.max()
    assert not rolled.stick.any()


def test_rolling_back_is_rolling_in_a_mirror() -> None:
    """Mirrored across, the speed, the longitudinal creepage and the spin change their signs."""
    shears = []
    for sign in (1.0, -1.0):
        creepage = {"longitudinal": sign * 0.3 * SATURATION, "lateral": 0.1 * SATURATION, "spin": sign * 5.0}
        shapes = (*CYLINDER, CROWN, cs.Waviness(1e-7, across=1e-4, phase=sign))
        shears.append(solved(rolling(**creepage, speed=sign), (48, 16), 1e-10, shapes=shapes).shear)
    mirrored = shears[1][:, ::-1] * np.array([-1, 1])[:, None, None]
    np.testing.assert_allclose(mirrored, shears[0], atol=1e-7 * MU * P0)


@pytest.mark.cases(3)
@pytest.mark.parametrize(("part", "cells"), [(0.01, 28), (0.5, 512), (0.97, 84)])
def test_numbers_of_a_cylinder_are_carters_within_their_bounds(part: float, cells: int) -> None:
    """Also where a zone of slip or stick is few cells wide."""
    creepage, coefficient = part * SATURATION, MU * (1 - (1 - part) ** 2)
    driven = solved(rolling(longitudinal=creepage, speed=3.0), (cells, 1)).quantities
    power = 3.0 * coefficient * LOAD.per_length * creepage
    expected = {"traction_coefficient": coefficient, "frictional_power": power, "stick_fraction": 1 - part}
    for name, value in expected.items():
        assert abs(driven[name].value - value) <= driven[name].bound
        assert driven[name].bound < 0.02 * value or cells < 100
    assert (driven["frictional_power"].unit, driven["creepage"].value) == ("W m-1", creepage)
    given = solved(cs.TractiveRolling(MU, tangential=coefficient * LOAD.per_length), (cells, 1)).quantities
    assert abs(given["creepage"].value - creepage) <= given["creepage"].bound
    assert given["traction_coefficient"].value == pytest.approx(coefficient, abs=1e-8)


UNLIKE = (STEEL, cs.HalfSpace(inf, 0.3))
WIDE = replace(SMOOTH, solids=UNLIKE).hertz.half_width


@pytest.mark.parametrize(
    ("coefficient", "free", "stick"), [(0.05, 0.8206, 0.383), (0.1, 0.7525, 0.607), (0.3, 0.6585, 0.943)]
)
def test_unlike_bodies_rolling_freely_creep(coefficient: float, free: float, stick: float) -> None:
    """In units of ``beta a / R``; ``2 / pi`` where all sticks. The elastic body is stretched, and so falls behind."""
    unit = abs(dundurs(UNLIKE)) * WIDE / RADIUS
    friction, grid = cs.TractiveRolling(coefficient, tangential=0.0), cs.Grid((256, 1), (2.4 * WIDE, 1e-3))
    for pair, creepage in ((UNLIKE, free), (UNLIKE[::-1], -free)):
        solution = cs.solve(replace(SMOOTH, solids=pair, friction=friction), grid, EXACT, tolerance=1e-6)
        assert solution.status is cs.Status.CONVERGED
        assert solution.traction.creepage.longitudinal / unit == pytest.approx(creepage, rel=2e-3)
        assert solution.stick.sum() / (solution.pressure > 0).sum() == pytest.approx(stick, abs=1e-2)


@pytest.mark.parametrize("solids", [(STEEL, STEEL), UNLIKE])
def test_a_traction_has_the_sign_of_the_force_on_the_first_body(solids: tuple[cs.HalfSpace, cs.HalfSpace]) -> None:
    eta = 0.2 * SATURATION
    for sign in (1, -1):
        found = solved(rolling(longitudinal=-eta, lateral=sign * eta, speed=sign), (32, 1), solids=solids)
        forces = found.shear.sum(axis=(1, 2)) / found.pressure.sum()
        names = "traction_coefficient", "lateral_traction_coefficient"
        assert [found.quantities[name].value for name in names] == pytest.approx(forces)
        assert np.sign(forces[1]) == sign


LINES, POINTS = ((60, 1), (240, 1)), ((36, 36), (72, 72))
BALL = {"shapes": (cs.Sphere(RADIUS),), "load": cs.LineLoad(1e4)}


@pytest.mark.parametrize(
    ("friction", "changes", "cells", "extent", "padding"),
    [
        # little stick on few cells, forces along y beside a given one along x, spin of a sphere, unlike bodies
        (rolling(longitudinal=0.9 * SATURATION), {}, ((24, 1), (240, 1)), (3 * A, 1e-3), EXACT),
        (cs.TractiveRolling(MU, tangential=0.5e4, lateral=-0.1 * SATURATION), {}, LINES, (3 * A, 1e-3), EXACT),
        (rolling(lateral=0.2 * SATURATION, spin=SATURATION / A), BALL, POINTS, (4e-4, 4e-4), FREE),
        (cs.TractiveRolling(1e-3, tangential=-80.0), {"solids": UNLIKE}, LINES, (3 * WIDE, 1e-3), EXACT),
    ],
)
def test_force_creepage_power_and_stick_are_within_their_bounds(
    friction: cs.TractiveRolling, changes: dict[str, object], cells: Any, extent: tuple[float, float], padding: Any
) -> None:
    scene = replace(SMOOTH, friction=friction, **changes)
    coarse, fine = (cs.solve(scene, cs.Grid(each, extent), padding).quantities for each in cells)
    for name in ("traction_coefficient", "creepage", "frictional_power", "stick_fraction"):
        error = abs(coarse[name].value - fine[name].value)
        assert error <= coarse[name].bound * (1 + 1e-9)
        # the stick fraction is known to a row of cells alone, and this point contact has few
        assert name == "stick_fraction" or coarse[name].bound <= 0.2 * abs(coarse[name].value) + 0.1


@pytest.mark.parametrize("solids", [(STEEL, STEEL), UNLIKE])
def test_what_sticks_does_not_slip_and_what_slips_is_sheared_against_its_slip(
    solids: tuple[cs.HalfSpace, cs.HalfSpace],
) -> None:
    friction = rolling(longitudinal=0.1 * SATURATION, lateral=-0.3 * SATURATION, spin=2.0)
    solution = solved(friction, (48, 32), 1e-7, solids=solids, shapes=(*ROUGH, CROWN))
    slip, limit = solution.traction.slip, MU * solution.pressure
    largest = np.hypot(*slip)[limit > 0].max()
    assert solution.status is cs.Status.CONVERGED
    assert np.hypot(*slip)[solution.stick].max() < 1e-4 * largest
    slips = (limit > 0) & ~solution.stick
    lost = -np.einsum("cxy,cxy->xy", solution.shear, slip)
    np.testing.assert_allclose(lost[slips], (limit * np.hypot(*slip))[slips], atol=1e-4 * limit.max() * largest)


def test_rolling_under_a_load_that_changes_slowly_is_steady_at_each_instant() -> None:
    loads = cs.LoadHistory((0.0, 1.0, 3.0, 4.0), (1e5, 5e4, 0.8e5, 0.0))
    scene, grid = replace(SMOOTH, friction=rolling(longitudinal=5e-4), load=loads), cs.Grid((96, 1), (2.4 * A, 1e-3))
    found = cs.solve(scene, grid, EXACT, times=[0, 1, 2, 4], tolerance=1e-8)
    assert found.status is cs.Status.CONVERGED
    assert not found.to_dataset()["shear_x"][3].any()
    for frame, load in zip(found.frames[:3], (1e5, 5e4, 6.5e4), strict=True):
        alone = cs.solve(replace(scene, load=cs.LineLoad(load)), grid, EXACT, tolerance=1e-8)
        np.testing.assert_allclose(frame.shear, alone.shear, atol=1e-6 * MU * P0)
        wanted, number = (answer.quantities["frictional_power"].value for answer in (alone, frame))
        assert number == pytest.approx(wanted, rel=1e-5)


def creeping(time: float) -> cs.ViscoelasticHalfSpace:
    """Half the modulus of steel after a time [s]."""
    return cs.ViscoelasticHalfSpace(105e9, 0.3, ((105e9, time),))


def driven(body: cs.ViscoelasticHalfSpace | cs.HalfSpace, cells: int = 64, **changed: object) -> cs.Contact:
    """Two bodies alike that roll with creepage along both axes."""
    friction = replace(rolling(longitudinal=3e-3, lateral=1e-3), **changed)
    scene = replace(SMOOTH, solids=(body, body), friction=friction)
    return cs.solve(scene, cs.Grid((cells, 1), (3.2 * A, 3.2e-4)), EXACT)


@pytest.mark.parametrize(("time", "modulus"), [(1e-13, 105e9), (1e4, 210e9)])
def test_bodies_that_creep_fast_or_slowly_drive_like_elastic_ones(time: float, modulus: float) -> None:
    """Relaxed where they roll by far less than a cell in their time constant, sudden where by far more than a width."""
    found, elastic = (driven(body) for body in (creeping(time), cs.HalfSpace(modulus, 0.3)))
    assert found.status is cs.Status.CONVERGED
    largest = elastic.pressure.max()
    assert np.abs(found.pressure - elastic.pressure).max() < 1e-5 * largest
    assert np.abs(found.traction.shear - elastic.traction.shear).max() < 1e-5 * largest


def test_power_of_the_creepage_is_lost_by_slip_and_in_bodies_that_creep() -> None:
    """In plane strain, shear of like bodies loses in them what the same pressure would."""
    found = driven(creeping(1e-4), 256, lateral=0.0, longitudinal=1e-3)
    force = found.traction.shear[0].sum() * found.grid.cell_size[0]
    steady = found.rolling
    as_pressure = replace(steady.lagged.solution, pressure=found.traction.shear[0])
    of_shear = replace(steady, lagged=replace(steady.lagged, solution=as_pressure))
    in_bodies = of_shear.resistance_coefficient * force
    by_slip = found.quantities["frictional_power"].value
    assert in_bodies > 0.2 * by_slip
    assert by_slip + in_bodies == pytest.approx(1e-3 * force, rel=0.01)


def test_the_error_of_a_drive_that_creeps_covers_its_change_on_finer_cells() -> None:
    coarse, fine = (driven(creeping(1e-4), cells) for cells in (64, 256))
    for name in ("traction_coefficient", "frictional_power", "rolling_resistance", "peak_pressure"):
        known, better = coarse.quantities[name], fine.quantities[name]
        assert abs(known.value - better.value) < known.bound + better.bound < inf
