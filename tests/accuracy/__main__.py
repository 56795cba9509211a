"""Error bounds beside true errors on contacts of every kind: ``python -m tests.accuracy [--seed N]``.

Margins of the estimates may be set on every other contact of the matrix (calibration). The rest of the matrix and
random contacts validate them.
"""

import argparse
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from math import inf, isnan
from typing import NamedTuple

import numpy as np

import contactstudy as cs
from tests.accuracy.case import errors
from tests.accuracy.matrix import matrix
from tests.accuracy.random_scenes import NAMES, random_case

METRICS = ("l1", "peak_pressure", "contact_area", "mean_gap")


class Judged(NamedTuple):
    """True error and bound of one quantity of a contact, and whether a bound that is missing has a reason."""

    contact: str
    use: str
    metric: str
    error: float
    bound: float
    has_reason: bool


def use_of(name: str) -> str:
    """Return the use of a contact: of the matrix every other one is for calibration."""
    if name in NAMES:
        return "random"
    return "validation" if int(name.rpartition(" ")[2]) % 2 else "calibration"


def judged(name: str, seed: int = 1) -> list[Judged]:
    """Return the true errors of a contact, nan where one is not known, and their bounds."""
    case = random_case(name, seed) if name in NAMES else matrix()[name]
    solution = cs.solve(case.problem())
    true, estimate = errors(solution, case.truth()), solution.error
    parts = {metric: getattr(estimate, metric).total for metric in METRICS}
    return [
        Judged(name, use_of(name), metric, getattr(true, metric), bound, bool(estimate.warnings))
        for metric, bound in parts.items()
    ]


def summary(rows: Iterable[Judged]) -> str:
    """Return the fraction of finite bounds that hold, their median over the error, and how many are missing."""
    known = [row for row in rows if not isnan(row.error)]
    finite = [row for row in known if row.bound < inf]
    holds = 100 * float(np.mean([row.bound >= row.error for row in finite])) if finite else np.nan
    ratios = [row.bound / row.error for row in finite if row.error > 0]
    ratio = float(np.median(ratios)) if ratios else np.nan
    return f"{holds:5.1f} % hold, {ratio:5.2g} times the error, {len(known) - len(finite):3d} missing"


def main() -> None:
    """Print the summaries by quantity and use, and the errors beyond their bounds."""
    parser = argparse.ArgumentParser(prog="python -m tests.accuracy", description=__doc__)
    parser.add_argument("--seed", type=int, default=1, help="choice of the random contacts")
    parser.add_argument("--only", default="", help="contacts whose name begins so")
    options = parser.parse_args()
    names = [name for name in (*matrix(), *NAMES) if name.startswith(options.only)]
    with ProcessPoolExecutor() as pool:
        of_names = pool.map(partial(judged, seed=options.seed), names, chunksize=4)
        rows = [row for rows in of_names for row in rows]
    for metric in METRICS:
        for use in ("calibration", "validation", "random"):
            chosen = [row for row in rows if (row.metric, row.use) == (metric, use)]
            if chosen:
                print(f"{metric:15s} {use:12s} {len(chosen):4d} contacts: {summary(chosen)}")
    for row in rows:
        if row.bound < row.error:
            print(f"beyond its bound: {row.contact}, {row.metric}: {row.error:.2g} > {row.bound:.2g}")
        if row.bound == inf and not row.has_reason:
            print(f"missing without a reason: {row.contact}, {row.metric}")


if __name__ == "__main__":
    main()
