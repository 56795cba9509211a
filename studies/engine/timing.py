"""Times that can be trusted: one case at a time, one thread, in rounds, every sample kept."""

from collections.abc import Callable, Iterator, Mapping
from itertools import chain

from studies.model.outcome import Failure, Sample

# What a process does but once (imports, memory from the system) is done by an untimed run of the longest
# case of each kind that is shorter than this; in a longer one it is lost.
WARM_UP = 0.3


def longest(expected: float, limit: float | None) -> float:
    """The time [s] after which a timed run of a case that took ``expected`` is given up."""
    found = 5 + 10 * expected
    return found if limit is None else min(found, limit)


def time_cases(
    missing: Mapping[str, int],
    expected: Mapping[str, float],
    kinds: Mapping[str, str],
    time_once: Callable[[str], Sample | Failure | None],
    taken: Callable[[str, Sample], object],
    failed: Callable[[str, Failure], object],
) -> None:
    """``missing[key]`` samples of each case, case after case in rounds, each given to ``taken``.

    ``expected`` seconds and ``kinds`` decide which cases are run untimed before; a case whose ``time_once``
    gives a failure is given to ``failed``, and is left without further times.
    """
    given_up = set()
    untimed = [(-1, key) for key in warm_ups({key: expected[key] for key in missing}, kinds)]
    for turn, key in chain(untimed, rounds(missing)):
        if key in given_up:
            continue
        sample = time_once(key)
        if isinstance(sample, Failure):
            given_up.add(key)
            failed(key, sample)
        elif sample is not None and turn >= 0:
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
