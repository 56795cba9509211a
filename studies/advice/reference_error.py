"""L1 error of the pressure of a case against a reference."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache, partial
from math import isfinite

import numpy as np
import xarray as xr

import contactstudy as cs
from studies.model.axis import Value
from studies.model.case import Answer, Case, Computation, dimensionless
from studies.model.study import Point, Study
from studies.reference.line_contact import relative_l1


def last_of(answer: Answer) -> cs.Contact | cs.LubricatedContact:
    """Return an answer, or the last frame under pressure of one that is an evolution."""
    if not isinstance(answer, cs.Evolution):
        return answer
    pressed = [frame for frame in answer.frames if frame.pressure.any()]
    return pressed[-1] if pressed else answer.frames[-1]


@lru_cache(maxsize=8)
def answer_of(reference: Case) -> Answer:
    """Return the answer of a reference, solved once in each process for all cases."""
    return reference.run()


def pressure_error(case: Case, answer: Answer) -> Mapping[str, xr.Variable]:
    """Return the relative L1 error of an answer's pressure, at its end if it is an evolution, against the reference.

    The bound of the reference's own error stands beside it. Both are left out without a reference, and for one of
    another extent, or whose cells neither nest in those of the case nor are a third of their size.
    """
    reference, grid = case.reference, case.grid
    if reference is None:
        return {}
    nests = all(
        fine % cells == 0 or fine >= 3 * cells for fine, cells in zip(reference.grid.cells, grid.cells, strict=True)
    )
    if not (nests and np.allclose(grid.extent, reference.grid.extent, 1e-9, 0.0)):
        return {}
    true = answer_of(reference)
    error = relative_l1(last_of(answer).pressure, last_of(true).pressure)
    measured = {"pressure_error_l1": dimensionless(error, "relative L1 error of the pressure")}
    # a film would take further solves
    if isinstance(true, cs.Contact) and isfinite(true.error.l1.total):
        what = "bound of the relative L1 error of the reference, which the error of the pressure may be off by"
        measured["reference_error_l1"] = dimensionless(float(true.error.l1.total), what)
    return measured


def against(study: Study, axis: str, value: Value) -> Study:
    """Return the study of a scene with errors against the value of an axis, at which it has none."""
    return replace(
        study,
        case_at=partial(_with_reference, study.case_at, axis, value),
        attributes={**study.attributes, "reference": f"{axis}={value}"},
    )


def _with_reference(case_at: Callable[[Point], Computation], axis: str, value: Value, point: Point) -> Computation:
    """Return the case at a point, with that at a value of an axis as its reference."""
    case, reference = case_at(point), case_at({**point, axis: value})
    assert isinstance(case, Case)
    assert isinstance(reference, Case)
    return case if case == reference else replace(case, reference=reference)
