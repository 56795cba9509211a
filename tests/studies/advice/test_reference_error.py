import numpy as np

import contactstudy as cs
from studies.advice.reference_error import against
from studies.scene_study.study_of import study_of

STEEL = cs.HalfSpace(210e9, 0.3)
WAVY = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(0.01), cs.Waviness(1e-7, along=1e-4)))
EXTENT = (4e-4, 1e-4)


def test_it_is_the_l1_norm_of_the_difference_to_cell_means_where_cells_nest() -> None:
    file = cs.SceneFile(WAVY, grid=cs.Grid((16, 16), EXTENT), padding=cs.ExactPeriodicity())
    swept = study_of(file, {"grid.cells": [[16, 16], [32, 32], [24, 24]]})
    (axis,) = swept.axes
    coarse, unnested, reference = (
        next(value for value in axis.values if str(value).startswith(f"[{cells}")) for cells in (16, 24, 32)
    )
    study = against(swept, axis.name, reference)
    pressures, errors, bounds = {}, {}, {}
    for value in (coarse, unnested, reference):
        case = study.case_at({axis.name: value})
        solved = case.run(None)
        pressures[value] = solved.pressure
        measured = study.measures(case, solved)
        errors[value] = measured.get("pressure_error_l1")
        bounds[value] = solved.error.l1.total, measured.get("reference_error_l1")
    means = pressures[reference].reshape(16, 2, 16, 2).mean((1, 3))
    by_hand = np.abs(pressures[coarse] - means).sum() / means.sum()
    np.testing.assert_allclose(errors[coarse], by_hand, rtol=1e-12)
    assert errors[unnested] is None
    assert errors[reference] is None
    np.testing.assert_allclose(bounds[coarse][1], bounds[reference][0], rtol=1e-12)
