import itertools

import numpy as np
import pytest
from scipy.special import erf

import contactstudy as cs
from studies.definitions.speed import SLOPE, peak_bytes, self_affine
from studies.reference.line_contact import SCENE
from tests.studies.conftest import measured


def test_memory_of_a_solve_is_the_most_that_is_held_at_once() -> None:
    held = peak_bytes(lambda: np.ones(40_000_000, dtype=np.int8)[:1].copy())
    assert held == pytest.approx(40_000_000, rel=1e-2)


def test_the_error_of_creep_falls_with_the_steps_under_its_estimate() -> None:
    several = [measured("creep", steps=steps, grid=512) for steps in (10, 20, 40)]
    error = np.array([float(one["pressure_error_l1"]) for one in several])
    # by the 1.5th power at least, until the cells count
    assert (error[:-1] / error[1:] > 2).all()
    for one in several:
        assert one["solver_status"] == 0
        # the estimate is of the steps alone; 512 cells leave 0.35 (dx / a)^1.5 = 2e-4
        assert one["time_discretisation_error"] + 3e-4 > one["pressure_error_l1"]
        # creep multiplies compliance by 1 + 1.5 (1 - exp(-2)), the half-width by its root
        widening = np.sqrt(1 + 1.5 * (1 - np.exp(-2)))
        assert float(one["half_width"][-1]) == pytest.approx(widening, abs=0.36 / 512 / 0.1)
    # of four steps the second is at the sixth of the instants that are stored
    halfway = measured("creep", steps=4, grid=64)["half_width"][5]
    assert float(halfway) == pytest.approx(np.sqrt(1 + 1.5 * (1 - np.exp(-1))), abs=0.36 / 64 / 0.1)


@pytest.mark.whole
def test_explicit_wear_breaks_before_its_limit_and_implicit_never() -> None:
    error = {}
    for scheme, steps in itertools.product(("explicit", "implicit", "two-stage"), (8, 32)):
        one = measured("wear", scheme=scheme, steps=steps, grid=32)
        error[scheme, steps] = float(one["pressure_error_l1"])
        assert (one["longest_explicit"] > 1) == (steps == 32)
        assert one["volume_error"] < 1e-13
    assert error["explicit", 8] > 0.5
    assert max(error["explicit", 32], error["implicit", 8]) < 5e-2
    assert error["two-stage", 8] < error["implicit", 8]
    assert error["two-stage", 32] < error["implicit", 32] < error["implicit", 8] / 2
    # between the rigid law and that of the cubes added, and a little above: 2 and 9^(1/3) = 2.08
    assert 2 < float(one["half_width"][-1]) < 2.2
    # of two steps the first is halfway, and what is stored before it lies on the line to it
    start, *between, first = measured("wear", steps=2, grid=32)["half_width"][:5].values
    assert between == pytest.approx(np.linspace(start, first, 5)[1:-1])


def test_a_contact_that_yields_nears_the_known_one_and_a_hardness_does_not() -> None:
    """Errors are of first order in the steps: 0.75 % of the pressure with 8, by finite elements too."""
    few, known = (measured("plastic", pressure=3.0, steps=steps, grid=48) for steps in (4, 8))
    elastic = measured("plastic", pressure=1.5, steps=8, grid=48)
    assert few["solver_status"] == known["solver_status"] == elastic["solver_status"] == 0
    assert known["peak_pressure_error"] < 1.5e-2
    assert 1.4 < few["peak_pressure_error"] / known["peak_pressure_error"] < 2.5
    # a cell is a seventh of the half-width, a layer down there two of them
    assert known["half_width_error"] < 0.1
    assert known["plastic_depth_error"] < 0.1
    assert known["dent_error"] < 0.03
    # on 48 cells the lower edge of the layer in which the known depth lies, or of the one above
    assert 2.3 < known["plastic_depth"] < 2.7
    assert elastic["plastic_depth"] == elastic["dent"] == 0.0
    assert elastic["hardness_limited_difference"] < 1e-6
    # 2.8 Y over 3 Y, not 0.787
    assert float(known["hardness_limited_pressure"]) == pytest.approx(2.8 / 3, abs=1e-9)
    assert known["hardness_limited_difference"] > 0.1


def test_a_self_affine_surface_bears_the_load_of_its_share_and_ends_at_so_many_cells() -> None:
    """Persson (2001): the fraction is erf(sqrt(2) p / (E* slope)), p the mean pressure."""
    grid = cs.Grid((64, 64), (3e-3, 3e-3))
    scene = self_affine(grid, 0.5, 4.0, 0.3)
    mean = scene.largest_load / 3e-3
    shape = scene.shapes[0]
    assert shape.rms == cs.RmsSlope(0.1)
    assert shape.roll_off == pytest.approx(3e-3 / 4)
    assert erf(np.sqrt(2) * mean / (SCENE.contact_modulus * SLOPE)) == pytest.approx(0.3)
    waves = np.abs(np.fft.rfft2(scene.shapes[0].gap(grid)))  # type: ignore[union-attr]
    index = np.hypot(*np.meshgrid(np.fft.fftfreq(64), np.fft.rfftfreq(64), indexing="ij"))
    assert waves[index > 1.001 / 4].max() < 1e-12 * waves.max() < waves[index > 0.9 / 4].max()
