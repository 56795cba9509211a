import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from math import inf, pi

import numpy as np
import pytest
from scipy.optimize import brentq

import contactstudy as cs
from contactstudy.accuracy.coarser import coarse_solution
from contactstudy.accuracy.error_terms import residual_errors
from contactstudy.accuracy.estimate import error_estimate
from contactstudy.domain.errors import ErrorParts
from contactstudy.domain.grid import Array
from contactstudy.io.quantities.quantity import Quantity
from contactstudy.scene.solids.bodies import contact_modulus
from tests.conftest import STEEL, LineContact

FREE, EXACT = cs.ZeroPadding(), cs.ExactPeriodicity()

MODULUS = cs.Scene(cs.LineLoad(1.0), (STEEL, STEEL)).contact_modulus


def ratios(solution: cs.Solution, true: Array, highest: float) -> tuple[float, float]:
    """Estimate over error: of the peak pressure, and in L1."""
    estimate = error_estimate(solution)
    true = np.broadcast_to(true, solution.pressure.shape)
    l1 = np.abs(solution.pressure - true).sum() / true.sum()
    peak = abs(solution.pressure.max() / highest - 1)
    return estimate.peak_pressure.total / peak, estimate.l1.total / l1


def hertz_lines(line_contact: LineContact) -> Iterator[tuple[float, float]]:
    """The contact edge anywhere in its cell, the axis in a cell or between two."""
    hertz = line_contact.hertz
    for cells in (16, 25, 32, 48, 65, 128, 192, 255):
        for width in np.linspace(2.2, 3.1, 7):
            grid = line_contact.grid((cells, 1), 1.0, width)
            solution = cs.solve(line_contact.scene.problem(grid, EXACT))
            yield ratios(solution, hertz.pressure(grid.x)[:, None], hertz.peak_pressure)


def hertz_points(line_contact: LineContact) -> Iterator[tuple[float, float]]:
    point = cs.analytic.HertzPoint(30.0, 0.01, MODULUS)
    for cells in (24, 33, 48, 64):
        for width in np.linspace(2.2, 3.4, 5):
            length = width * point.contact_radius
            grid = cs.Grid(cells=(cells, cells), extent=(length, length))
            scene = cs.Scene(cs.LineLoad(30.0 / length), (STEEL, STEEL), (cs.Sphere(0.01),))
            solution = cs.solve(scene.problem(grid, (FREE, FREE)))
            true = point.pressure(np.hypot(grid.x[:, None], grid.y))
            yield ratios(solution, true, point.peak_pressure)


def wavy_surfaces(line_contact: LineContact) -> Iterator[tuple[float, float]]:
    """From a strip of contact in each wave to nearly no gap left."""
    height, length = 1e-6, 1e-3
    for cells in (16, 25, 32, 64, 129):
        for fraction in np.linspace(0.05, 0.95, 7):
            closing = math.pi * MODULUS * height / length
            wave = cs.analytic.Westergaard(fraction * closing, height, length, MODULUS)
            load = cs.LineLoad(wave.mean_pressure * length)
            shapes = (cs.Waviness(height, across=length),)
            grid = cs.Grid(cells=(cells, 1), extent=(length, length))
            problem = cs.Scene(load, (STEEL, STEEL), shapes).problem(grid, (EXACT, EXACT))
            true = wave.pressure(grid.x)[:, None]
            yield ratios(cs.solve(problem), true, wave.peak_pressure)


@pytest.mark.parametrize("cases", [hertz_lines, hertz_points, wavy_surfaces])
def test_estimate_bounds_the_error_and_is_not_five_times_too_large(
    cases: Callable[[LineContact], Iterator[tuple[float, float]]], line_contact: LineContact
) -> None:
    found = np.array(list(cases(line_contact)))
    assert ((found >= 1).mean(axis=0) >= 0.95).all()
    assert (np.median(found, axis=0) <= 5).all()


@pytest.mark.parametrize("solver", [cs.PreconditionedCG(), cs.PolonskyKeer()], ids=str)
def test_residual_part_bounds_what_further_iterations_change(solver: cs.Solver, line_contact: LineContact) -> None:
    problem = line_contact.scene.problem(line_contact.grid(48, 2.4, 2.5), cs.Superposition(2))
    done = cs.solve(problem, tolerance=1e-12)
    for tolerance in (1e-2, 1e-3, 1e-4, 1e-6, 1e-8):
        early = cs.solve(problem, tolerance=tolerance, solver=solver)
        estimate = error_estimate(early)
        l1 = np.abs(early.pressure - done.pressure).sum() / done.pressure.sum()
        assert l1 <= estimate.l1.residual <= 5 * l1
        for parts, one, other in (
            (estimate.peak_pressure, early.pressure.max(), done.pressure.max()),
            (estimate.contact_area, (early.pressure > 0).sum(), (done.pressure > 0).sum()),
            (estimate.mean_gap, early.mean_gap, done.mean_gap),
        ):
            assert abs(one / other - 1) <= parts.residual
    assert error_estimate(done).l1.residual < 1e-10


def test_each_cause_shows_in_its_own_part_alone(line_contact: LineContact) -> None:
    def parts(cells: int, padding: cs.Padding, tolerance: float) -> ErrorParts:
        problem = line_contact.scene.problem(line_contact.grid((cells, 2), 2.4), padding)
        return error_estimate(cs.solve(problem, tolerance=tolerance)).l1

    plain = parts(64, EXACT, 1e-8)
    assert plain.images == 0
    cut = parts(64, cs.CircularSuperposition(3), 1e-8)
    assert cut.images > 1e-3
    assert cut.residual < 1e-6
    # by the rate 23 times less, of which the leap of the edge may take a factor of 8
    assert parts(512, EXACT, 1e-8).discretisation < plain.discretisation / 3
    assert parts(64, EXACT, 1e-3).residual > 100 * plain.residual


def test_a_solve_that_failed_has_no_bound_with_its_status_and_no_part_of_another_cause(
    line_contact: LineContact,
) -> None:
    problem = line_contact.scene.problem(line_contact.grid((16, 1), 1.2), EXACT)
    failed = replace(cs.solve(problem), status=cs.Status.NOT_FINITE)
    for _, parts in error_estimate(failed):
        assert parts.by_cause == {"residual": inf}
        assert "NOT_FINITE" in parts.reason


def test_a_solution_on_larger_cells_that_did_not_converge_is_no_comparison(line_contact: LineContact) -> None:
    grid = line_contact.grid((96, 1), 1.0, width=4.0)
    scene = line_contact.with_shapes(cs.Waviness(1e-7, across=6 * grid.cell_size[0]))
    solution = cs.solve(scene.problem(grid, EXACT))
    coarse = coarse_solution(solution.problem)
    assert coarse is not None
    for status in (cs.Status.ITERATION_LIMIT, cs.Status.STALLED, cs.Status.CONVERGED):
        estimate = error_estimate(solution, coarse=replace(coarse, status=status))
        assert (estimate.l1.total < inf) is status.has_converged


def test_a_problem_without_paddings_is_refused(line_contact: LineContact) -> None:
    problem = line_contact.scene.problem(line_contact.grid(16, 1.2), EXACT)
    solution = cs.solve(replace(problem, paddings=None))
    with pytest.raises(cs.InvalidInput, match=r"^Problem\.paddings is None: "):
        error_estimate(solution)


def test_a_contact_inside_one_cell_has_the_largest_l1_error(line_contact: LineContact) -> None:
    """Two pressures of one load differ by 2 at most, which is all there is to say."""
    grid = line_contact.grid((33, 1), 1.0, width=33 * 4.0)
    estimate = error_estimate(cs.solve(line_contact.scene.problem(grid, EXACT)))
    assert estimate.l1.discretisation == 2
    assert estimate.peak_pressure.total == estimate.contact_area.total == math.inf
    assert estimate.warnings


@pytest.mark.parametrize(("ratio", "wide"), [(0.03, 8), (10, 100), (40, 1000)])
def test_the_bound_holds_under_soft_and_stiff_coatings(ratio: float, wide: float) -> None:
    a = 1e-3
    coating = cs.HalfSpace(1e11, 0.3)
    body = cs.CoatedHalfSpace(coating, a / wide, cs.HalfSpace(1e11 / ratio, 0.3))
    load = pi * contact_modulus((body,), a) * a**2 / 4
    rigid = cs.HalfSpace(inf, 0.3)
    scene = cs.Scene(cs.LineLoad(load), (body, rigid), (cs.Cylinder(1.0),))

    def solved(cells: int) -> cs.Solution:
        grid = cs.Grid((cells, 1), (3.3 * a, 3.3 * a))
        return cs.solve(scene.problem(grid, cs.ExactPeriodicity()), tolerance=1e-9)

    fine, coarse = solved(6144).pressure[:, 0], solved(192)
    true = fine.reshape(192, -1).mean(axis=1)
    estimate = error_estimate(coarse)
    assert np.abs(coarse.pressure[:, 0] - true).sum() <= estimate.l1.total * true.sum()


def jkr_line(load: float, work: float, modulus: float, radius: float, edges: Array) -> tuple[float, Array]:
    """Return half-width and forces between `edges` of a cylinder with adhesion (Barquins 1988)."""
    half = brentq(
        lambda a: pi * modulus * a**2 / (4 * radius) - math.sqrt(2 * pi * modulus * a * work) - load, 1e-5, 1e-2
    )
    t = np.clip(edges / half, -1, 1)
    hertz = modulus * half**2 / (4 * radius) * (t * np.sqrt(1 - t**2) + np.arcsin(t))
    return half, np.diff(hertz - math.sqrt(2 * modulus * half * work / pi) * np.arcsin(t))


@pytest.mark.parametrize(("load", "count"), [(2.0, 150), (60.0, 480)])
def test_in_the_limit_of_short_ranges_net_traction_area_and_approach_are_bounded_against_jkr(
    load: float, count: int
) -> None:
    scene = cs.Scene(
        load=cs.LineLoad(load),
        solids=(cs.HalfSpace(1e6, 0.49), cs.HalfSpace(inf, 0.3)),
        shapes=(cs.Cylinder(0.01),),
        adhesion=cs.Adhesion(0.05),
        outputs=(cs.SubsurfaceStress((5e-5,)),),
    )
    contact = cs.solve(scene, cs.Grid((count, 1), (6e-3, 1e-3)), EXACT)
    assert contact.adhesion is not None
    assert contact.error.contact_area is not None
    edges = np.linspace(-3e-3, 3e-3, count + 1)
    half, forces = jkr_line(load, 0.05, scene.contact_modulus, 0.01, edges)
    net = (contact.pressure - contact.adhesion.attraction)[:, 0] * 6e-3 / count
    true_l1 = np.abs(net - forces).sum() / np.abs(forces).sum()
    area = contact.quantities["contact_area"]
    assert true_l1 <= contact.error.l1.total
    assert abs(area.value - 2 * half) <= area.bound
    peak = contact.quantities["peak_pressure"]
    griffith = math.sqrt(2 * scene.contact_modulus * 0.05 / (pi * half))
    true_peak = scene.contact_modulus * half / 2 / 0.01 - griffith
    assert abs(peak.value - true_peak) <= peak.bound < true_peak
    assert contact.quantities["peak_repulsive_pressure"].bound == inf
    assert contact.quantities["largest_von_mises"].bound == inf
    # Hertz's pressure and, with the rest of the load, that of a flat punch
    of_hertz = pi * scene.contact_modulus * half**2 / 4 / 0.01
    datum = 2 * 0.01  # twice the radius
    true = (2 * load * np.log(2 * datum / half) + of_hertz) / (pi * scene.contact_modulus)
    approach = contact.quantities["approach"]
    assert abs(approach.value - true) <= approach.bound < 0.25 * true


def test_beside_a_given_range_the_pressure_is_bounded_where_two_coarse_grids_agree_by_chance() -> None:
    """Without the law of edges the bound is 1.3 % for 22 %."""
    bodies, adhesion = (cs.HalfSpace(5e6, 0.49), cs.HalfSpace(inf, 0.3)), cs.Adhesion(0.05, 4.6e-6)
    scene = cs.Scene(cs.LineLoad(9.5), bodies, (cs.Cylinder(1e-3),), adhesion=adhesion)
    width = 8 * scene.hertz.half_width + 8e-4
    coarse, fine = (cs.solve(scene, cs.Grid((n, 1), (width, 1e-3)), EXACT) for n in (32, 1024))
    assert cs.compare(fine, coarse).l1 <= coarse.error.l1.total < 1


def test_an_attraction_cut_off_at_the_edge_has_no_bound() -> None:
    """On a width of 8 the peak pressure is 7 % lower than on a wide grid."""
    solids = cs.HalfSpace(1.0, 0.0), cs.HalfSpace(inf, 0.3)
    adhesion = cs.Adhesion(pi, 8.0)
    scene = cs.Scene(cs.Approach(0.5, datum=16.0), solids, (cs.Cylinder(1.0),), adhesion=adhesion)
    for width, is_bounded in ((8.0, False), (32.0, True)):
        solution = cs.solve(scene.problem(cs.Grid((int(16 * width), 1), (width, 1.0)), EXACT))
        estimate = error_estimate(solution)
        parts = estimate.l1, estimate.peak_pressure, estimate.load
        assert all((part.total < inf) is is_bounded for part in parts)
        assert any("attraction is cut off" in said for said in estimate.warnings) is not is_bounded


def test_a_mean_gap_as_small_as_the_residual_has_no_bound() -> None:
    """The bodies touch everywhere."""
    wave = cs.Waviness(1e-9, across=1e-3)
    scene = cs.Scene(cs.LineLoad(1e5), (cs.HalfSpace(1e9, 0.3), STEEL), (wave,))
    solution = cs.solve(scene.problem(cs.Grid((64, 1), (1e-3, 1e-3)), (cs.CircularSuperposition(1), FREE)))
    assert solution.pressure.all()
    assert error_estimate(solution).mean_gap.total == inf


def test_a_contact_cut_off_at_the_edge_has_no_bound(line_contact: LineContact) -> None:
    problem = line_contact.scene.problem(line_contact.grid((64, 1), 1.0, 1.5), cs.ZeroPadding())
    estimate = error_estimate(cs.solve(problem))
    assert estimate.l1.total == inf
    assert "cut off at the edge" in estimate.warnings[0]


def test_the_residual_part_bounds_what_the_attraction_still_changes() -> None:
    solids = cs.HalfSpace(1e7, 0.4), cs.HalfSpace(inf, 0.3)
    adhesion = cs.Adhesion(0.05, range=1e-6)
    scene = cs.Scene(cs.LineLoad(1e3), solids, (cs.Cylinder(0.01),), adhesion=adhesion)
    problem = scene.problem(cs.Grid((256, 1), (5e-3, 1e-3)), EXACT)
    done, early = (cs.solve(problem, tolerance=one) for one in (1e-10, 1e-4))
    estimate = error_estimate(early)
    change = np.abs(early.pressure - done.pressure)
    assert change.sum() / done.pressure.sum() <= estimate.l1.residual
    peak = abs(early.pressure.max() / done.pressure.max() - 1)
    assert 1e-6 < peak <= estimate.peak_pressure.residual


def test_the_residual_part_of_a_load_near_zero_is_relative_to_that_load() -> None:
    """Relative to the pressure it is 0.3, for a load of 6 times the true one."""
    solids = cs.HalfSpace(1e7, 0.4), cs.HalfSpace(inf, 0.3)
    scene = cs.Scene(cs.Approach(6.4535e-7), solids, (cs.Cylinder(0.01),), adhesion=cs.Adhesion(0.05, range=1e-6))
    problem = scene.problem(cs.Grid((256, 1), (5e-3, 1e-3)), EXACT)
    done, early = (cs.solve(problem, tolerance=one) for one in (1e-12, 1e-3))
    change = abs(done.load_per_length / early.load_per_length - 1)
    assert 0.5 < change <= error_estimate(early).load.residual < inf


def test_the_residual_part_bounds_what_a_uniform_gap_changes_at_a_given_approach(line_contact: LineContact) -> None:
    change, grid = -1e-2, line_contact.grid((96, 1), 1.0, width=8.0)
    one, other = (
        cs.solve(replace(line_contact.scene, load=cs.Approach(a)), grid, EXACT, tolerance=1e-12)
        for a in (2e-6, 2e-6 * (1 + change))
    )
    off = replace(one, problem=other.problem, gap=one.gap - 2e-6 * change, approach=other.approach)
    error = np.abs(other.pressure - one.pressure).sum() / one.pressure.sum()
    found = residual_errors(off)
    assert error <= found.l1 <= 10 * error
    assert abs(other.pressure.max() / one.pressure.max() - 1) <= found.peak_pressure
    assert abs(other.mean_gap - off.mean_gap) <= found.gap


def test_the_load_of_bodies_that_only_attract_has_the_bound_of_the_attraction() -> None:
    steel = cs.HalfSpace(210e9, 0.3)
    adhesion = cs.Adhesion(0.1, 2e-7)
    scene = cs.Scene(cs.Approach(-1e-7), (steel, steel), (cs.Cylinder(0.01),), adhesion=adhesion)
    loads = [
        cs.solve(scene, cs.Grid((cells, 1), (9e-4, 1e-3)), EXACT).quantities["load_per_length"]
        for cells in (4, 16, 32, 512)
    ]
    for load in loads[:-1]:
        assert abs(load.value - loads[-1].value) <= load.bound
    assert loads[0].bound == inf > loads[1].bound
    assert loads[2].bound < 1e-3 * abs(loads[2].value)


SOFT = (cs.HalfSpace(1e6, 0.49), cs.HalfSpace(inf, 0.3))


def test_the_pull_off_of_a_surface_that_is_pressed_flat_has_no_limit() -> None:
    length, modulus = 1e-3, 1e6 / (1 - 0.49**2)
    flattens = pi * modulus * 0.05
    work = (0.4 * flattens) ** 2 * length / 2 / modulus
    wave = (cs.Waviness(0.05 * length, across=length),)

    def pull_off(preload: float, work: float) -> Quantity:
        scene = cs.Scene(cs.PullOff(preload), SOFT, wave, adhesion=cs.Adhesion(work))
        grid = cs.Grid((32, 1), (length, length))
        return cs.solve(scene, grid, (cs.ExactPeriodicity(),) * 2).quantities["pull_off"]

    flat = pull_off(0.6 * flattens * length, work)
    assert flat.bound == inf
    assert "pressed flat" in flat.reason
    assert pull_off(0.3 * flattens * length, 0.2 * work).bound < inf


@pytest.mark.parametrize("approach", [-4.0, 3.0])
def test_the_load_at_a_given_approach_has_a_part_for_the_range_that_the_grid_chooses(approach: float) -> None:
    unit = (0.1 * 0.01**2 * (1 - 0.49**2) / (pi * 1e6)) ** (1 / 3)
    branch = "from full contact" if approach < 0 else "from afar"
    load = cs.Approach(approach * unit**2 / 0.01, datum=16 * unit)
    scene = cs.Scene(load, SOFT, (cs.Cylinder(0.01),), adhesion=cs.Adhesion(0.1, branch=branch))
    coarse, fine = (
        cs.solve(scene, cs.Grid((cells, 1), (16 * unit, unit)), EXACT).quantities["load_per_length"]
        for cells in (192, 768)
    )
    assert abs(coarse.value - fine.value) <= coarse.bound < 0.2 * abs(fine.value)


def test_the_peak_of_dissimilar_bodies_has_a_part_for_the_shear_where_slip_begins() -> None:
    solids = (cs.HalfSpace(1.235e9, 0.0), cs.HalfSpace(4.657e9, 0.3277))
    friction = cs.TractiveRolling(0.483, longitudinal=-0.0013786)
    scene = cs.Scene(cs.LineLoad(5428.0), solids, (cs.Cylinder(0.01575),), friction=friction)
    coarse, fine = (
        cs.solve(scene, cs.Grid((cells, 1), (1.1874e-3, 3e-4)), EXACT).quantities["peak_pressure"]
        for cells in (81, 648)
    )
    assert abs(coarse.value - fine.value) <= coarse.bound < 0.05 * fine.value


@pytest.mark.parametrize("law", ["exponential", "dugdale"])
def test_a_pull_off_is_bounded_against_the_jkr_limit(law: str) -> None:
    """It is ``3 (pi E* w^2 R / 16)^(1/3)`` (Barquins 1988)."""
    work, radius = 0.05, 0.01
    scene = cs.Scene(cs.PullOff(1.0), SOFT, (cs.Cylinder(radius),), adhesion=cs.Adhesion(work, law=law))
    width = 10 * (radius**2 * work / scene.contact_modulus) ** (1 / 3)
    found = cs.solve(scene, cs.Grid((128, 1), (width, 1e-3)), EXACT).quantities["pull_off"]
    true = 3 * (pi * scene.contact_modulus * work**2 * radius / 16) ** (1 / 3)
    assert abs(found.value - true) <= found.bound < 0.2 * true
