"""Times that can be trusted: one case at a time, one thread, in turns, every sample kept."""

from collections.abc import Callable, Iterator, Mapping
from time import perf_counter, process_time

import numpy as np
from threadpoolctl import threadpool_limits

from studies.model.case import Computation
from studies.model.timing_samples import Sample

THREADS = 1
# What a process does but once (imports, memory from the system) is done by an untimed run of the longest
# case of each kind that is shorter than this; in a longer one it is lost.
WARM_UP = 0.3
WAVE = np.outer(np.cos(np.arange(128.0)), np.sin(np.arange(128.0)))


def time_once(case: Computation) -> Sample:
    """One run of ``case``, against the wall clock and the processor's."""
    before = _reference_time()
    wall, cpu = perf_counter(), process_time()
    prepared = case.prepare()
    ready, ready_cpu = perf_counter(), process_time()
    case.run(prepared)
    done, done_cpu = perf_counter(), process_time()
    pace = max(before, _reference_time())
    return Sample(ready - wall, done - ready, ready_cpu - cpu, done_cpu - ready_cpu, THREADS, pace)


def _reference_time() -> float:
    """Seconds of a transform of 128 x 128 cells, the least of three."""
    least = np.inf
    for _ in range(3):
        start = perf_counter()
        np.fft.irfft2(np.fft.rfft2(WAVE))
        least = min(least, perf_counter() - start)
    return float(least)


def time_cases(
    cases: Mapping[str, Computation],
    missing: Mapping[str, int],
    expected: Mapping[str, float],
    kinds: Mapping[str, str],
    taken: Callable[[str, Sample], object],
) -> None:
    """``missing[key]`` samples of each case, case after case in turns, each given to ``taken``.

    ``expected`` seconds and ``kinds`` decide which cases are run untimed before; what a case raises leaves
    it without times.
    """
    with threadpool_limits(THREADS):
        failed = set()
        untimed = [(-1, key) for key in warm_ups({key: expected[key] for key in missing}, kinds)]
        for turn, key in (*untimed, *rounds(missing)):
            if key in failed:
                continue
            try:
                sample = time_once(cases[key])
            except Exception:  # noqa: BLE001 (it was computed before, so this is chance, and no sample)
                failed.add(key)
            else:
                if turn >= 0:
                    taken(key, sample)


def warm_ups(expected: Mapping[str, float], kinds: Mapping[str, str]) -> list[str]:
    """Of each kind the longest case below ``WARM_UP``, by their keys."""
    found: dict[str, str] = {}
    for key, seconds in sorted(expected.items(), key=lambda one: one[1]):
        if seconds < WARM_UP:
            found[kinds[key]] = key
    return list(found.values())


def rounds(missing: Mapping[str, int]) -> Iterator[tuple[int, str]]:
    """Every case once, then every case again, for as long as one lacks a sample."""
    for turn in range(max(missing.values(), default=0)):
        yield from ((turn, key) for key, count in missing.items() if turn < count)
