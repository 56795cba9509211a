"""What a comparison in a test takes for equal."""

import numpy as np
import pytest


def test_a_small_number_is_compared_to_a_part_of_itself() -> None:
    assert pytest.approx(2e-13) != 3e-13
    assert pytest.approx(2e-13, rel=1e-3) == 2.001e-13
    assert pytest.approx(np.array([1.0, 2e-13])) != np.array([1.0, 3e-13])
    assert pytest.approx({"length": 2e-13}) != {"length": 3e-13}
    assert pytest.approx(2e-13, abs=2e-13) == 3e-13
    assert pytest.approx(0.0) == 1e-13
