"""Error bounds beside true errors on contacts of every kind: ``python -m tests.accuracy [--seed N]``.

Margins of the estimates may be set on contacts with a closed form (calibration). Random contacts validate them.
"""

import argparse
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from math import inf, isnan

import numpy as np

from tests.accuracy.case import METRICS, Judged, judged
from tests.accuracy.closed_forms import CLOSED_FORMS
from tests.accuracy.random_scenes import NAMES, random_case

ALL = (*CLOSED_FORMS, *NAMES)


def of_name(name: str, seed: int = 1) -> list[Judged]:
    """Return the true errors and the bounds of a contact."""
    return judged(CLOSED_FORMS[name] if name in CLOSED_FORMS else random_case(name, seed))


def summary(rows: Sequence[Judged]) -> str:
    """Return the fraction of finite bounds that hold, their median over the error, and how many are missing."""
    known = [row for row in rows if not isnan(row.error)]
    finite = [row for row in known if row.bound < inf]
    holds = 100 * float(np.mean([row.bound >= row.error for row in finite])) if finite else np.nan
    ratios = [row.bound / row.error for row in finite if row.error > 0]
    ratio = float(np.median(ratios)) if ratios else np.nan
    return f"{holds:5.1f} % hold, {ratio:5.2g} times the error, {len(known) - len(finite):3d} missing"


def main() -> None:
    """Print the summaries by number, of closed forms and of random contacts, and the errors beyond their bounds."""
    parser = argparse.ArgumentParser(prog="python -m tests.accuracy", description=__doc__)
    parser.add_argument("--seed", type=int, default=1, help="choice of the random contacts")
    parser.add_argument("--only", default="", help="contacts whose name begins so")
    options = parser.parse_args()
    names = [name for name in ALL if name.startswith(options.only)]
    with ProcessPoolExecutor() as pool:
        found = dict(zip(names, pool.map(partial(of_name, seed=options.seed), names, chunksize=4), strict=True))
    for metric in METRICS:
        for use, those in (("closed form", CLOSED_FORMS), ("random", NAMES)):
            rows = [row for name in names if name in those for row in found[name] if row.metric == metric]
            print(f"{metric:15s} {use:12s} {len(rows):4d} contacts: {summary(rows)}")
    for name in names:
        for metric, error, bound, has_reason in found[name]:
            if bound < error:
                print(f"beyond its bound: {name}, {metric}: {error:.2g} > {bound:.2g}")
            if bound == inf and not has_reason:
                print(f"missing without a reason: {name}, {metric}")


if __name__ == "__main__":
    main()
