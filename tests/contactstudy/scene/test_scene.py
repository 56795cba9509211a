import math
from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import STEEL, LineContact


@pytest.mark.parametrize("radius", [-0.01, 0.0, math.nan, math.inf, "10 mm", None])
def test_a_bad_radius_is_refused_by_name_and_value(radius: object) -> None:
    with pytest.raises(
        cs.InvalidInput, match=r"^Cylinder\.radius is .*: give a radius above 0 m\.$"
    ):
        cs.Cylinder(radius=radius)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("modulus", "ratio"), [(0.0, 0.3), (-1.0, 0.3), (1e9, 0.51), (1e9, -1.0), (1e9, math.nan)]
)
def test_a_solid_that_cannot_exist_is_refused(modulus: float, ratio: float) -> None:
    with pytest.raises(cs.InvalidInput, match=r"^HalfSpace\."):
        cs.HalfSpace(youngs_modulus=modulus, poisson_ratio=ratio)


def test_two_rigid_bodies_are_refused() -> None:
    rigid = cs.HalfSpace(youngs_modulus=math.inf, poisson_ratio=0.3)
    with pytest.raises(cs.InvalidInput, match="all rigid"):
        cs.Scene(load=cs.LineLoad(1.0), solids=(rigid, rigid))


@pytest.mark.parametrize("solids", [(STEEL,), STEEL, (STEEL, 210e9), ()])
def test_solids_that_are_not_two_bodies_are_refused(solids: object) -> None:
    with pytest.raises(cs.InvalidInput, match=r"^Scene\.solids"):
        cs.Scene(load=cs.LineLoad(1.0), solids=solids)  # type: ignore[arg-type]


def test_a_rigid_body_adds_no_compliance() -> None:
    rigid = cs.HalfSpace(youngs_modulus=math.inf, poisson_ratio=0.0)
    scene = cs.Scene(load=cs.LineLoad(1.0), solids=(STEEL, rigid))
    assert scene.contact_modulus == pytest.approx(210e9 / (1 - 0.09), rel=1e-15)


def test_shapes_add_up(line_contact: LineContact) -> None:
    halves = replace(line_contact.scene, shapes=(cs.Cylinder(0.02), cs.Cylinder(0.02)))
    grid = line_contact.grid((16, 4), 1.0)
    whole = line_contact.scene.problem(grid, cs.ExactPeriodicity())
    split = halves.problem(grid, cs.ExactPeriodicity())
    np.testing.assert_allclose(split.undeformed_gap, whole.undeformed_gap, rtol=4e-16)
    assert split.scales.length == pytest.approx(whole.scales.length, rel=1e-15)


@pytest.mark.parametrize("kind", [np.int16, np.int64, np.float16, np.float32, int])
def test_numbers_of_any_kind_are_kept_as_floats(kind: type) -> None:
    """Else an int16 would overflow in a formula, and a float32 round it."""
    load = cs.LineLoad(kind(10_000))
    assert type(load.per_length) is float
    assert load.per_length == 10_000.0
    assert type(cs.Cylinder(kind(2)).radius) is float
    assert type(cs.Superposition(np.uint8(3)).images) is int
    hertz = cs.analytic.HertzLine(kind(100), kind(1), kind(1000))
    assert hertz == cs.analytic.HertzLine(100.0, 1.0, 1000.0)


def test_a_number_beyond_floats_is_refused() -> None:
    with pytest.raises(cs.InvalidInput, match=r"^Cylinder\.radius is 1000"):
        cs.Cylinder(10**400)


@pytest.mark.parametrize("shape", [0.01, cs.Cylinder, None])
def test_what_is_no_shape_is_refused(shape: object) -> None:
    with pytest.raises(cs.InvalidInput, match=r"^Scene\.shapes\[0\] is .*: give a shape"):
        cs.Scene(load=cs.LineLoad(1.0), solids=(STEEL, STEEL), shapes=(shape,))  # type: ignore[arg-type]


def test_what_is_no_grid_is_refused(line_contact: LineContact) -> None:
    with pytest.raises(cs.InvalidInput, match=r"^grid is \(8, 8\): give a Grid\.$"):
        line_contact.scene.problem((8, 8), cs.ExactPeriodicity())  # type: ignore[arg-type]


WAVE, LONG = cs.Waviness(1e-6, across=0.5), cs.Waviness(2e-6, across=0.9, along=1.5)
