import numpy as np

import contactstudy as cs
from studies.definitions.effect_cost import P_H, YIELD, scene_at


def test_one_cell_along_gives_the_pressure_of_many() -> None:
    one, many = (
        scene_at({"effect": f"smooth, {dimension}", "grid": 128}) for dimension in ("1-D", "2-D")
    )
    assert (one.grid.cells, many.grid.cells) == ((128, 1), (128, 32))
    line, plane = (cs.solve(whole.prepare(), tolerance=1e-12).pressure for whole in (one, many))
    np.testing.assert_allclose(plane, np.broadcast_to(line, plane.shape), atol=1e-9 * line.max())


def test_the_row_of_yield_yields_on_a_quarter_of_the_cells() -> None:
    whole = scene_at({"effect": YIELD, "grid": 128})
    assert whole.grid.cells == (32, 1)
    half, full = whole.run(whole.prepare()).frames
    # Hertz's peak is 1.77 and 2.5 times the yield stress: first yield is at 1.794
    assert not (half.coupled_state["equivalent0"] > 0).any()
    assert (full.coupled_state["equivalent0"] > 0).any()
    assert full.peak_pressure < P_H
