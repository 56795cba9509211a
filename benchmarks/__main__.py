"""Run benchmarks without asv: ``python -m benchmarks [speed | peers] [--cells 128]``."""

import argparse
from collections.abc import Iterator
from itertools import product
from typing import Any

from benchmarks.peers import Peers
from benchmarks.speed import Solve, least_seconds

SUITES: dict[str, Any] = {"speed": Solve, "peers": Peers}


def results(suite: Any, cells: list[int]) -> Iterator[str]:
    """Yield a line for each choice of parameters, on grids of some numbers of cells, or on all."""
    for values in product(*suite.params[:-1], cells or suite.params[-1]):
        line = ", ".join(map(str, values))
        benchmark = suite()
        try:
            benchmark.setup(*values)
        except NotImplementedError as reason:
            yield f"{line}: left out, {reason}"
            continue
        seconds = least_seconds(suite.timer, lambda: benchmark.time_solve(*values))  # noqa: B023
        tracked = {
            name.removeprefix("track_"): getattr(benchmark, name)(*values)
            for name in dir(suite)
            if name.startswith("track_")
        }
        numbers = "; ".join(f"{name.replace('_', ' ')} {value:.3g}" for name, value in tracked.items())
        yield f"{line}: {1e3 * seconds:.3g} ms of processor time; {numbers}"


def main() -> None:
    """Print the results."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("suite", nargs="*", metavar="speed|peers", help="suites, by default speed")
    parser.add_argument("--cells", type=int, nargs="+", default=[], help="numbers of cells across")
    options = parser.parse_args()
    for name in options.suite or ["speed"]:
        for line in results(SUITES[name], options.cells):
            print(line, flush=True)


if __name__ == "__main__":
    main()
