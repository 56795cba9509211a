"""A pytest plugin, ``-p tests.part_of_cases``: of each test with several cases one in so many.

``PART_OF_CASES=2/3`` runs the second, fifth, eighth case of each such test, and every test with one case; so
runs with 1/3, 2/3 and 3/3 have run every case together. For machines that differ in less than their arithmetic.
"""

import os
from collections import Counter

import pytest

PART, OF = (int(number) for number in os.environ.get("PART_OF_CASES", "1/2").split("/"))


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Deselect the other cases, in the order in which they stand."""
    cases = Counter(_function(item) for item in items)
    seen: Counter[str] = Counter()
    chosen, others = [], []
    for item in items:
        function = _function(item)
        seen[function] += 1
        here = cases[function] == 1 or (seen[function] - PART) % OF == 0
        (chosen if here else others).append(item)
    items[:] = chosen
    config.hook.pytest_deselected(items=others)


def _function(item: pytest.Item) -> str:
    return item.nodeid.partition("[")[0]
