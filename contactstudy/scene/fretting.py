"""Fretting: a tangential force that swings beside a constant load."""

from dataclasses import dataclass

import numpy as np

from contactstudy.domain.checks import (
    InvalidInput,
    each,
    finite,
    set_fields,
    suggest_fields,
    whole,
)
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Paddings
from contactstudy.domain.units import NewtonsPerMetre, Number
from contactstudy.elasticity.tangential import shear_response
from contactstudy.scene.bodies import HalfSpace
from contactstudy.scene.friction import ALIKE, FrictionContact, check_still, coefficient, dundurs
from contactstudy.solvers.fretting import SwingingShear


@suggest_fields
@dataclass(frozen=True)
class Fretting:
    """Partial slip under tangential forces that follow one another, beside a constant load.

    Where a force turns back, slip begins anew at the edge of the contact against the shear that is left there. The
    answer is the contact under the last force; its traction has the loop of force and displacement, and the slip and
    the energy lost since the last force acted before.

    Parameters
    ----------
    coefficient
        Coefficient of friction, above 0 and below 1.
    forces
        Forces along x on the first body [N/m], of either sign and less than the coefficient times the load, from none
        on; see :meth:`cycle`.

    Raises
    ------
    InvalidInput
        For other values; in a scene with bodies that are unlike in shear or coated, or a change in time.
    """

    coefficient: Number
    forces: tuple[NewtonsPerMetre, ...]

    def __post_init__(self) -> None:
        remedy = "give a tuple of forces along x [N/m], such as (1e4, -1e4, 1e4)"
        if not isinstance(self.forces, tuple | list) or not self.forces:
            raise InvalidInput(f"Fretting.forces is {self.forces!r}: {remedy}.")
        forces = each("Fretting.forces", self.forces, finite, "give a force along x [N/m]")
        set_fields(
            self, coefficient=coefficient("Fretting", self.coefficient, zero=False), forces=forces
        )

    @classmethod
    def cycle(cls, coefficient: float, amplitude: float, steps: int = 1) -> "Fretting":
        """Return fretting from none to the `amplitude` [N/m], back to its opposite, and up again.

        Each half cycle takes equal `steps`. One is exact where nothing varies along the length.
        """
        count = whole("Fretting.cycle.steps", steps, 1, "give at least one step a half cycle")
        down = [amplitude * (1 - 2 * (n + 1) / count) for n in range(count)]
        down[-1] = -amplitude
        return cls(coefficient, (amplitude, *down, *(-force for force in down)))

    def check(self, scene: FrictionContact) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if part of the contact cannot stick, or is not known to."""
        check_still(scene, "Fretting")
        for number, solid in enumerate(scene.solids):
            if not isinstance(solid, HalfSpace):
                raise InvalidInput(
                    f"Scene.solids[{number}] is a {type(solid).__name__} beside Fretting: its response to shear is "
                    "not known, give a HalfSpace."
                )
        if abs(beta := dundurs(scene.solids)) > ALIKE:
            raise InvalidInput(
                f"Scene.solids are unlike in shear (Dundurs' beta {beta:.3g}) beside Fretting: pressing them makes "
                "them slip already, give bodies of one material."
            )
        most = self.coefficient * scene.load.largest
        for number, force in enumerate(self.forces):
            if not abs(force) < most:
                raise InvalidInput(
                    f"Fretting.forces[{number}] is {force!r}: friction bears less than {most:g} N/m, beyond which "
                    "the bodies slide without end, give less."
                )

    def law(
        self, scene: FrictionContact, gap: Array, grid: Grid, paddings: Paddings, datum: float
    ) -> SwingingShear:
        """Return the law for this scene on a grid."""
        bodies = tuple(
            (solid.compliance, solid.poisson_ratio)
            for solid in scene.solids
            if isinstance(solid, HalfSpace)
        )
        shares = np.array(self.forces) / (self.coefficient * scene.load.largest)
        response = shear_response(bodies, grid, paddings, datum)
        return SwingingShear(self.coefficient, tuple(shares.tolist()), response)

    def explanation(self, scene: FrictionContact, *, varies: bool, paddings: Paddings) -> str:
        """Return a sentence on the solves of the shear."""
        return (
            f"friction: fretting by Newton's method, {len(self.forces)} steps of 20 to 80 applications of the "
            "response, four transforms each, beside the normal solve."
        )
