from math import inf

import contactstudy as cs
from contactstudy.scene.shapes.detail import Detail


def test_a_plain_cylinder_has_no_detail() -> None:
    """No wave, nothing that repeats, no roller's end, no height and no slope."""
    nothing = Detail()
    assert nothing.finest == (inf, inf)
    assert (nothing.repeat, nothing.longest, nothing.roller) == (0, 0, 0)
    assert (nothing.height, nothing.slope) == (0, 0)
    assert cs.Cylinder(0.01).detail == nothing
