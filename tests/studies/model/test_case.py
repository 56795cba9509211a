"""What a case is solved with, and what is recorded of it."""

import numpy as np

import contactstudy as cs
from contactstudy.io.dataset import flags
from studies.model.case import contact_fraction, solver_status

GRID = cs.Grid((8, 4), (1e-4, 1e-4))


def test_a_status_is_a_flag_of_all_that_there_are() -> None:
    for place, status in enumerate(cs.Status):
        found = solver_status(status, "how it ended")
        assert int(found) == place
        assert found.attrs["flag_meanings"].split()[place] == status.name.lower()
        np.testing.assert_array_equal(found.attrs["flag_values"], np.arange(len(cs.Status)))
    two = flags(("x",), np.array([1, 0]), ("no", "yes"), "whether")
    assert two.dims == ("x",)
    assert two.dtype == np.int8


def test_every_cell_that_bears_is_in_contact_however_little() -> None:
    """A faint load has pressures far below one pascal."""
    fraction = contact_fraction(np.array([[0.0, 1e-9], [0.5, 2e9]]))
    assert float(fraction) == 0.75
    assert fraction.attrs["units"] == "1"
