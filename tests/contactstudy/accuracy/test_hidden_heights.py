"""Heights between cell centres: a bound sees them, or is infinite and says why."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import LineContact


@dataclass(frozen=True)
class Lands:
    """A user's own shape that does not say how fine it is: lands with deep grooves between them."""

    pitch: float
    land: float
    phase: float
    curvature = 0.0

    def gap(self, grid: cs.Grid) -> np.ndarray:
        t = np.abs((grid.x / self.pitch + self.phase + 0.5) % 1 - 0.5) * self.pitch
        return np.where(t < self.land / 2, 0.0, 2e-6)[:, None]


@dataclass(frozen=True)
class Spike:
    """A user's own shape: one narrow peak between two cell centres."""

    place: float
    width: float
    curvature = 0.0

    def gap(self, grid: cs.Grid) -> np.ndarray:
        return -3e-7 * np.exp(-(((grid.x - self.place) / self.width) ** 2))[:, None]


def estimate_of(scene: cs.Scene, grid: cs.Grid) -> cs.ErrorEstimate:
    return cs.error_estimate(cs.solve(scene.problem(grid, cs.ExactPeriodicity())))


@pytest.mark.parametrize(("cells", "land"), [(96, 0.03), (96, 0.07), (160, 0.01), (77, 0.015)])
def test_lands_narrower_than_a_cell_leave_no_bound(
    cells: int, land: float, line_contact: LineContact
) -> None:
    pitch = line_contact.hertz.half_width / 4
    groove = cs.Groove(2e-6, (1 - land) * pitch, cs.FlatBottomed())
    scene = replace(
        line_contact.scene, shapes=(*line_contact.scene.shapes, cs.Texture(groove, (pitch, inf)))
    )
    estimate = estimate_of(scene, line_contact.grid((cells, 1), 1.0, width=3.0))
    assert estimate.l1.total == estimate.peak_pressure.total == inf
    assert "do not show lengths" in estimate.warnings[0]


@pytest.mark.parametrize("phase", [0.0, 0.01, 0.33])
@pytest.mark.parametrize("land", [0.03, 0.01])
def test_what_stands_out_of_the_cells_of_an_unknown_shape_leaves_no_bound(
    land: float, phase: float, line_contact: LineContact
) -> None:
    pitch = line_contact.hertz.half_width / 4
    own = Lands(pitch, land * pitch, phase)
    scene = replace(line_contact.scene, shapes=(*line_contact.scene.shapes, own))
    estimate = estimate_of(scene, line_contact.grid((96, 1), 1.0, width=3.0))
    assert estimate.l1.total == estimate.contact_area.total == inf
    assert "between their centres" in estimate.warnings[0]


@pytest.mark.parametrize("place", [0.1, 0.3])
def test_one_hidden_peak_is_enough(place: float, line_contact: LineContact) -> None:
    grid = line_contact.grid((96, 1), 1.0, width=3.0)
    spike = Spike(place * grid.cell[0], 0.05 * grid.cell[0])
    scene = replace(line_contact.scene, shapes=(*line_contact.scene.shapes, spike))
    assert estimate_of(scene, grid).l1.total == inf


def test_a_smooth_unknown_shape_keeps_its_bound(line_contact: LineContact) -> None:
    wide = Spike(0.0, line_contact.hertz.half_width)
    scene = replace(line_contact.scene, shapes=(*line_contact.scene.shapes, wide))
    estimate = estimate_of(scene, line_contact.grid((192, 1), 1.0, width=3.0))
    assert estimate.l1.total < 0.01
    assert not estimate.warnings


@pytest.mark.parametrize("along", [60, 120])
def test_pressure_that_reaches_a_sharp_end_has_no_highest(
    along: int, line_contact: LineContact
) -> None:
    """Lundberg's profile has a finite drop: pressure there grows without limit on finer cells."""
    length = 4 * line_contact.hertz.half_width
    profile = cs.LundbergProfile.for_load(
        1e5, contact_modulus=line_contact.scene.contact_modulus, radius=0.01, length=length
    )
    scene = replace(line_contact.scene, shapes=(*line_contact.scene.shapes, profile))
    grid = line_contact.grid((36, along), 4.0, width=2.6)
    estimate = cs.error_estimate(
        cs.solve(scene.problem(grid, (cs.ZeroPadding(), cs.ZeroPadding())))
    )
    assert estimate.peak_pressure.total == inf
    assert "sharp end" in " ".join(estimate.warnings)
    assert estimate.l1.total < 0.02
