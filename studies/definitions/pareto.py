"""Cost of accuracy: every mode, n, period, grid, tolerance and solver, as solved and corrected."""

from collections.abc import Mapping
from dataclasses import replace

import xarray as xr

import contactstudy as cs
from contactstudy.accuracy.contact_edge import corrected_pressure
from studies.definitions.solvers import SOLVERS
from studies.model.axis import Axis, one_of
from studies.model.case import Case, number
from studies.model.study import Point
from studies.reference import line_contact
from studies.reference.line_contact import LINE

points = (
    *line_contact.axes(
        padding=(*line_contact.PADDINGS, LINE),
        images=(1, 6),
        period=(0.6, 2.4, 9.6),
        # at 2.4 half-widths across, the edge falls elsewhere in its cell on each of them
        grid=(32, 56, 88, 136),
    ),
    # not "tolerance", which Dataset.sel takes for its own
    Axis("solver_tolerance", (1e-4, 1e-6, 1e-8), "residual to which the solver goes"),
    Axis("solver", tuple(SOLVERS), "solver"),
)


def scene_at(point: Point) -> Case:
    """Return the sweeps' line contact with a solver and a tolerance, with one cell along the length for "line"."""
    solver = SOLVERS[one_of("solver", point["solver"], SOLVERS)]
    lined = point["padding"] == LINE
    # one computation for all periods
    fixed: Point = {"padding": "exact", "period": line_contact.WIDTH} if lined else {}
    case = line_contact.scene_at({**point, **fixed})
    grid = replace(case.grid, cells=(case.grid.cells[0], 1)) if lined else case.grid
    options = cs.SolveOptions(float(point["solver_tolerance"]), solver=solver)
    return replace(case, grid=grid, options=options)


def measures(case: Case, solution: cs.Solution) -> Mapping[str, xr.Variable]:
    """Return the sweeps' errors against Hertz, and the L1 error of the pressure corrected at the edge."""
    hertz = case.scene.hertz
    assert hertz is not None
    true = hertz.pressure(case.grid.x)[:, None]
    corrected = corrected_pressure(solution.pressure)
    return {
        **line_contact.measures(case, solution),
        "corrected_error_l1": number(
            line_contact.l1_error(corrected, true, line_contact.load_on(case.grid)),
            "relative L1 error of the pressure, corrected at the edge",
        ),
    }
