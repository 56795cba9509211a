from collections.abc import Iterator

import pytest
from threadpoolctl import threadpool_limits


@pytest.fixture(autouse=True)
def one_thread() -> Iterator[None]:
    """Dense matrices of a few hundred cells lose more to a busy neighbour than a second thread gains."""
    with threadpool_limits(1):
        yield
