import decimal
import locale
import os
import random
import sys
import warnings
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.engine.workers.interpreter_state import InterpreterState, restored_state
from tests.studies.conftest import quiet
from tests.studies.engine.trouble import Square, study_of


def measures(case: Square, result: float) -> Mapping[str, object]:
    """Reads all that a case may leave behind, and leaves something else behind."""
    number = int(case.number)
    seen = {
        "of_numpy": float(np.random.random()),  # noqa: NPY002
        "of_random": random.random(),
        "folder": os.getcwd(),  # noqa: PTH109
        "variable": os.environ.get("LEFT", "none"),
        "divide": np.geterr()["divide"],
        "filters": sum(getattr(one[1], "pattern", "").isdigit() for one in warnings.filters),
        "digits": decimal.getcontext().prec,
        "join": xr.get_options()["arithmetic_join"],
        "printed": np.get_printoptions()["precision"],
        "path": len(sys.path),
        "depth": sys.getrecursionlimit(),
        "place": locale.setlocale(locale.LC_ALL),
    }
    os.chdir("/")
    os.environ["LEFT"] = str(number)
    np.seterr(divide="raise")
    warnings.filterwarnings("error", message=str(number))
    decimal.getcontext().prec = 5 + number
    xr.set_options(arithmetic_join="outer")
    np.set_printoptions(precision=number + 1)
    np.random.seed(number)  # noqa: NPY002
    random.seed(number)
    sys.path.append(str(number))
    sys.setrecursionlimit(2000 + number)
    locale.setlocale(locale.LC_ALL, "C")
    return seen


@pytest.mark.cases(1)
@pytest.mark.parametrize("workers", [0, 1])
def test_an_answer_does_not_depend_on_the_cases_before_it(workers: int, tmp_path: Path) -> None:
    orders = [[0, 1, 2, 3, 4, 5], [5, 3, 1, 0, 4, 2], [3]]
    answers = [
        run(
            study_of(Square, numbers, measures, "none"),
            tmp_path / str(place),
            options=RunOptions(workers=workers),
            log=quiet,
        )
        for place, numbers in enumerate(orders)
    ]
    first = answers[0]
    assert len(set(first["of_numpy"].values.tolist())) == 6
    for other in answers[1:]:
        same = first.sel(number=other["number"])
        for name in ("of_numpy", "of_random", "folder", "variable", "divide", "filters", "digits",
                     "join", "printed", "path", "depth", "place"):  # fmt: skip
            assert (same[name] == other[name]).all(), name


def test_the_caller_s_own_state_is_as_it_was_after_a_block() -> None:
    np.random.seed(7)  # noqa: NPY002
    before = InterpreterState.now()
    expected = np.random.RandomState(7).random()
    with restored_state() as interpreter_state:
        interpreter_state.restore("one")
        measures(Square(1.0), 1.0)
    assert repr(InterpreterState.now()) == repr(before)
    assert np.random.random() == expected  # noqa: NPY002
