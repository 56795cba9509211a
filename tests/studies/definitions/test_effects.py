from studies.definitions.effect_cost import P_H, YIELD, scene_at


def test_the_row_of_yield_yields_on_a_quarter_of_the_cells() -> None:
    whole = scene_at({"effect": YIELD, "grid": 128})
    assert whole.grid.cells == (32, 1)
    half, full = whole.run(whole.prepare()).frames
    # Hertz's peak is 1.77 and 2.5 times the yield stress: first yield is at 1.794
    assert not (half.coupled_state["equivalent0"] > 0).any()
    assert (full.coupled_state["equivalent0"] > 0).any()
    assert full.peak_pressure < P_H
