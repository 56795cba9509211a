import numpy as np
import pytest

from studies.reference.line_contact import A
from tests.accuracy.case import AccuracyCase, ClosedForm
from tests.accuracy.matrix import matrix


def test_a_contact_lies_on_its_grid_in_many_cells() -> None:
    """The half-width is that of Hertz's line contact, or the contact radius under a sphere."""
    for name, case in matrix().items():
        hertz = case.scene.hertz
        half_width = A if hertz is None else hertz.half_width
        if case.kind not in {"1-10 cells in contact", "full contact", "near full contact"}:
            assert 2.2 * half_width <= case.grid.extent[0] <= 12 * half_width, name
            assert case.grid.cell_size[0] < half_width / 2, name
        assert case.grid.length <= 40 * half_width, name
        assert case.problem().undeformed_gap.shape == case.grid.cells, name


CLOSED = [name for name, case in matrix().items() if isinstance(case.find_truth, ClosedForm)]


@pytest.mark.cases(100)
@pytest.mark.parametrize("name", CLOSED)
def test_a_closed_form_carries_its_load_on_its_area_up_to_its_peak_pressure(name: str) -> None:
    """Sampled at points that fall anywhere: the load to the fraction of them at an edge or beside a pole."""
    case: AccuracyCase = matrix()[name]
    truth = case.find_truth
    count = (1008, 1012 if case.grid.cells[1] > 1 else 1)
    places = [(np.arange(n) + 0.5) / n - 0.5 for n in count]
    x, y = (fraction * side for fraction, side in zip(places, case.grid.extent, strict=True))
    pressure = np.broadcast_to(truth.pressure(x[:, None], y), count)
    load = case.scene.largest_load
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
    assert means.pressure.sum() * case.grid.cell_area / case.grid.length == pytest.approx(load)
    assert means.pressure.shape == case.grid.cells
