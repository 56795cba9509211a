"""How a recommendation is held against stored settings, of settings that are written here."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from contactstudy.accuracy.expected_error import Edges, ErrorParts, Metric
from studies.advice import verification
from studies.advice.recommendation import Limits, Setting, SmoothContact
from studies.advice.settings_table import Settings
from studies.advice.verification import TARGETS, _places, _slower, verify
from studies.reference.line_contact import HERTZ

# padding, images, cells, tolerance, solver, seconds, error
STORED: tuple[tuple[Any, ...], ...] = (
    ("exact", 1, 32, 1e-8, "preconditioned_cg", 4.0, 1e-3),
    ("exact", 1, 32, 1e-8, "polonsky_keer", 0.5, 1e-3),
    ("exact", 1, 64, 1e-8, "preconditioned_cg", 8.0, 1e-4),
    ("exact", 1, 32, 1e-4, "preconditioned_cg", 3.0, 5e-3),
    ("circular", 1, 32, 1e-8, "preconditioned_cg", 1.0, 2e-2),
    ("circular", 6, 32, 1e-8, "preconditioned_cg", 2.0, 1e-3),
)
NAMES = ("padding", "images", "grid", "solver_tolerance", "solver")
EVERY = Settings(
    np.array([row[5] for row in STORED]),
    np.zeros((2, len(STORED))),
    np.array([row[6] for row in STORED]),
    {name: np.array([row[n] for row in STORED]) for n, name in enumerate(NAMES)},
)


def setting(mode: str, cells: int, padding: cs.Padding, tolerance: float = 1e-8) -> Any:
    grid = cs.Grid((cells, cells), (1.0, 1.0))
    return SimpleNamespace(mode=mode, grid=grid, padding=padding, tolerance=tolerance)


EXACT = cs.ExactPeriodicity()
FINE, COARSE = setting("exact", 64, EXACT), setting("exact", 32, EXACT)
SIX = setting("circular", 32, cs.CircularSuperposition(6))


def test_a_setting_is_found_by_its_mode_grid_tolerance_and_n() -> None:
    assert _places(EVERY, COARSE).tolist() == [0]
    assert _places(EVERY, FINE).tolist() == [2]
    assert _places(EVERY, setting("exact", 32, EXACT, 1e-4)).tolist() == [3]
    assert _places(EVERY, SIX).tolist() == [5]
    assert _places(EVERY, setting("circular", 32, cs.CircularSuperposition(1))).tolist() == [4]
    # cells across, of which one stands for all along a line
    line = SimpleNamespace(**(vars(COARSE) | {"grid": cs.Grid((32, 1), (1.0, 1.0))}))
    assert _places(EVERY, line).tolist() == [0]  # type: ignore[arg-type]
    assert not _places(EVERY, setting("zero", 32, cs.ZeroPadding())).size


def test_its_time_is_over_the_quickest_foreseen_and_over_the_quickest_at_all() -> None:
    # 8 s over the 2 s of six images; the other solver meets 1e-3 in half a second
    assert _slower(EVERY, FINE, [FINE, SIX, COARSE], 1e-3) == pytest.approx((4.0, 16.0))
    assert _slower(EVERY, SIX, [SIX], 1e-3) == pytest.approx((1.0, 4.0))
    foreseen, lucky = _slower(EVERY, FINE, [FINE], 1e-6)
    assert foreseen == 1
    assert np.isnan(lucky)


def test_targets_are_two_in_a_decade_from_a_tenth_to_a_millionth() -> None:
    assert TARGETS[0] == pytest.approx(0.1)
    assert TARGETS[-1] == pytest.approx(1e-6)
    assert TARGETS[1:] / TARGETS[:-1] == pytest.approx(np.full(10, 10**-0.5))


# stored errors of the one setting, and whether its edges are corrected
ERRORS = {
    "peak_pressure_error": 2e-3,
    "half_width_error": 4e-4,
    "pressure_error_l1": 9e-4,
    "corrected_error_l1": 5e-4,
}


@pytest.mark.parametrize(("edges", "of_l1"), [(Edges.AS_SOLVED, 9e-4), (Edges.CORRECTED, 5e-4)])
@pytest.mark.parametrize("periods", [[0.6], [0.6, 2.4], [0.6, 2.4, 9.6]])
def test_each_period_is_recommended_for_by_the_times_of_the_others(
    edges: Edges, of_l1: float, periods: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One setting, stored with a cost of 4 s, whose error is foreseen as 1e-3 and is so in the sweeps."""
    known, asked = [], []

    def timings(dataset: xr.Dataset, cpu: str) -> tuple[()]:
        known.append((dataset["period"].values.tolist(), cpu))
        return ()

    def settings(_: xr.Dataset, *names: str) -> Settings:
        error = np.array([min(ERRORS[name] for name in names)])
        axes = {name: np.array([STORED[0][n]]) for n, name in enumerate(NAMES)}
        return Settings(np.array([4.0]), np.zeros((2, 1)), error, axes)

    def candidates(contact: SmoothContact, limits: Limits, _: object) -> list[Setting]:
        asked.append((contact, limits))
        grid = cs.Grid((32, 32), (1.0, 1.0))
        return [Setting("exact", EXACT, grid, 1e-8, edges, ErrorParts(0, 1e-3, 0), 1.0, 1)]

    monkeypatch.setattr(verification, "stored_timings", timings)
    monkeypatch.setattr(verification, "settings", settings)
    monkeypatch.setattr(verification, "candidates", candidates)
    dataset = xr.Dataset(
        coords={
            "padding": ["exact", "line", "zero"],
            "period": periods,
            "grid": [32, 48],
            "images": [1, 6],
            "solver_tolerance": [1e-8, 1e-4, 1e-6],
        },
        attrs={"cpu": "here"},
    )
    found = verify(dataset)
    # one period alone is foreseen by itself
    others = [[one for one in periods if one != period] or periods for period in periods]
    assert known == [(one, "here") for one in others]
    # with all modes and without the line; three metrics; targets from a tenth to the thousandth it keeps to
    met = TARGETS[:5]
    of_metric = {
        Metric.PEAK_PRESSURE: 2e-3,
        Metric.L1: of_l1,
        Metric.HALF_WIDTH: 4e-4,
    }
    wanted = [of_metric[metric] / target for metric in Metric for target in met]
    assert found.error == pytest.approx(2 * len(periods) * wanted)
    assert found.slower.tolist() == [1.0] * len(found.error)
    contacts = [*dict.fromkeys(contact for contact, _ in asked)]
    a = HERTZ.half_width
    lengths = [contact.period for contact in contacts]
    assert lengths == pytest.approx([period * a for period in periods for _ in range(2)])
    for contact, modes in zip(
        contacts, len(periods) * [("exact", "line", "zero"), ("exact", "zero")], strict=True
    ):
        assert (contact.half_width, contact.modes) == (a, modes)
        assert (contact.across, contact.images) == ((32, 48), (1, 6))
        assert contact.tolerances == (1e-4, 1e-6, 1e-8)
    assert {limits.error for _, limits in asked} == set(TARGETS.tolist())
