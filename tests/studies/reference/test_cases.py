"""What a case of a reference matrix stands for: its name is what a journal and a report know of it."""

import hashlib
import json
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from studies.reference.accuracy.case import AccuracyCase, ClosedForm
from studies.reference.accuracy.matrix import matrix
from studies.reference.hard_cases import CASES

KNOWN = Path(__file__).parents[2] / "reference" / "cases_by_name.json"
CLOSED = [name for name, case in matrix().items() if isinstance(case.find_truth, ClosedForm)]


def described(value: Any) -> Any:
    """What tells two cases apart: numbers to six digits, of heights their size and their spread."""
    if is_dataclass(value) and not isinstance(value, type):
        # a digest of heights is one of their last bits too, which differ between processors
        names = [part.name for part in fields(value) if part.name != "digest"]
        parts = {name: described(getattr(value, name)) for name in names}
        return {type(value).__name__: parts}
    if isinstance(value, bool | str | Enum) or value is None:
        return str(value)
    if isinstance(value, int | float | np.number):
        return f"{value:.6g}"
    if isinstance(value, np.ndarray):
        steps = np.abs(np.diff(value, axis=0)).mean() if len(value) > 1 else 0.0
        return [value.shape, f"{value.std():.5g}", f"{np.abs(value).max():.5g}", f"{steps:.5g}"]
    if isinstance(value, tuple | list):
        return [described(one) for one in value]
    if isinstance(value, frozenset):
        return sorted(map(str, value))
    return getattr(value, "__name__", type(value).__name__).replace("<lambda>", "")


def of_today() -> dict[str, str]:
    every: dict[str, Any] = {f"accuracy: {name}": case for name, case in matrix().items()}
    every |= {f"hard: {name}": case for name, case in CASES.items()}
    return {
        name: hashlib.sha256(json.dumps(described(case)).encode()).hexdigest()[:8]
        for name, case in every.items()
    }


def test_a_name_stands_for_the_same_contact_as_before() -> None:
    """To change one is to change what stored results of that name mean: write its new digest down with it."""
    known, found = json.loads(KNOWN.read_text(encoding="utf-8")), of_today()
    changed = {name for name in known.keys() | found.keys() if known.get(name) != found.get(name)}
    assert not changed


@pytest.mark.parametrize("name", CLOSED)
def test_a_closed_form_carries_its_load_on_its_area_up_to_its_peak_pressure(name: str) -> None:
    """Sampled at points that fall anywhere: the load to the fraction of them at an edge or beside a pole."""
    case: AccuracyCase = matrix()[name]
    truth = case.find_truth
    assert isinstance(truth, ClosedForm)
    count = (1008, 1012 if case.grid.cells[1] > 1 else 1)
    places = [(np.arange(n) + 0.5) / n - 0.5 for n in count]
    x, y = (fraction * side for fraction, side in zip(places, case.grid.extent, strict=True))
    pressure = np.broadcast_to(truth.pressure(x[:, None], y), count)
    load = case.scene.load.largest
    carried = pressure.mean() * case.grid.extent[0]
    # of a pole's load beside an edge the root of a step is lost, and its width over that of the contact
    step = 1 / (count[0] * truth.area)
    sharp = truth.highest == np.inf
    assert carried == pytest.approx(load, rel=2 * step**0.5 if sharp else 4 * step)
    touching = (pressure > 1e-9 * pressure.max()).mean()
    assert touching == pytest.approx(truth.area, rel=4 * step)
    if not sharp:
        # a parabola's top, half a step away
        assert pressure.max() == pytest.approx(truth.highest, rel=10 * step)
        assert pressure.max() <= truth.highest * (1 + 1e-9)
    means = truth(case)
    assert means.pressure.sum() * case.grid.cell_area / case.grid.period == pytest.approx(load)
    assert means.pressure.shape == case.grid.cells


if __name__ == "__main__":
    KNOWN.write_text(json.dumps(of_today(), indent=0) + "\n", encoding="utf-8")
