"""Fretting: partial slip under a sequence of tangential forces or displacements, or under one."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Paddings
from contactstudy.domain.units import Metres, Newtons, NewtonsPerMetre, Pascals, Seconds, readable
from contactstudy.domain.validation import FINITE, BodyIndex, at_least, valid, validated
from contactstudy.elasticity.tangential import ShearResponse, shear_response
from contactstudy.scene.friction.friction_law import (
    SAMPLES,
    FrictionCoefficient,
    bulk_compliance,
    check_force,
    check_similar,
    check_static,
    check_tangential_response,
    force_per_length,
    mean_over_grid,
    shearable,
    transmitted_force,
)
from contactstudy.scene.loads.load_history import ChangingLoad, PiecewiseLinear, Times, check_not_decreasing
from contactstudy.scene.solids.bodies import SceneContext
from contactstudy.solvers.friction.coulomb import BulkStress
from contactstudy.solvers.friction.fretting import FrettingShear, PartialSlipShear


@dataclass(frozen=True)
class FrettingHistory(PiecewiseLinear):
    """Forces [N/m] or displacements [m] along x at instants [s], linear between them."""

    times: tuple[float, ...]
    values: tuple[float, ...]

    def compared_with(self, load: object) -> list[float]:
        """Return the times [s] at which this is compared with `load`: equal intervals, and the instants of both."""
        times = np.linspace(self.start, self.end, SAMPLES).tolist()
        return sorted({*times, *self.times, *getattr(load, "times", ())})


@validated
class Fretting:
    """Partial slip under tangential forces that follow one another.

    Where a force reverses, reverse slip starts at the edge of the contact, opposed by the residual traction (Johnson
    1985, sect. 7.4). Under a constant load the answer is the contact under the last force; its traction has the loop of
    force and displacement, and the slip and the energy lost since the previous occurrence of that force. With `times`
    the scene changes in time, also its load, and ``Wear(coefficient, speed=0.0)`` wears by the slip.

    Parameters
    ----------
    coefficient
        Coefficient of friction, above 0 and below 1.
    forces
        Tangential forces along x on the first body, over the length that the load acts on [N/m], one after the other,
        starting from 0; each smaller in magnitude than the coefficient times the load. See :meth:`cycle`.
    times
        Instants [s] of the forces, which are linear in between; None under a constant load.
    displacements
        Rigid displacements along x [m] of the second against the first body in place of the forces, with `times` and
        under a constant load: a positive one makes a positive tangential traction on the first body. Above a limit the
        contact slides fully (gross slip, ``stick_fraction`` 0). They are relative to the datum, a point at the distance
        of twice the equivalent radius (without a curved shape the width of the grid), or with images along both axes to
        the mean.
    period
        Duration of one cycle [s], with `times`. A force step that takes n half periods stands for n half cycles: slip
        and wear of one are counted n times (cycle jump). None counts each force once.
    bulk_stresses
        Stresses of one whole body along x [Pa], tension positive, one for each force, in phase with the forces or not
        (fretting fatigue). A strain of ``(1 - nu^2) / E`` times their change adds to the slip of a step, and the last
        one to the stress below the surface. Without `times`; None for none.
    bulk_body
        Index (0 or 1) of the body with the bulk stress.

    Raises
    ------
    InvalidInput
        For other values; in a scene with elastically dissimilar bodies, with one that yields, or that roll.
    """

    sticks: ClassVar[bool] = True

    coefficient: FrictionCoefficient
    forces: tuple[Annotated[NewtonsPerMetre, FINITE], ...] | None = None
    times: Times | None = None
    displacements: tuple[Annotated[Metres, FINITE], ...] | None = None
    period: Seconds | None = None
    bulk_stresses: tuple[Annotated[Pascals, FINITE], ...] | None = None
    bulk_body: BodyIndex = 0

    def check_together(self) -> None:
        """Check that forces or displacements are given, and that times go with them."""
        if (self.forces is None) == (self.displacements is None):
            raise InvalidInput(
                "Fretting.forces and Fretting.displacements are both given or both None: give one of them."
            )
        name = "forces" if self.displacements is None else "displacements"
        values = getattr(self, name)
        if not values:
            raise InvalidInput(f"Fretting.{name} is (): give some, such as (1e4, -1e4, 1e4).")
        if self.times is not None:
            if len(self.times) != len(values):
                raise InvalidInput(
                    f"Fretting.times has {len(self.times)} instants and Fretting.{name} {len(values)}: give one time "
                    "for each."
                )
            check_not_decreasing("Fretting.times", self.times)
        elif self.displacements is not None:
            raise InvalidInput("Fretting.times is None together with displacements: give times [s].")
        if self.bulk_stresses is not None and self.times is not None:
            raise InvalidInput(
                "Fretting.bulk_stresses are given together with times: leave the times out, or the stresses."
            )
        if self.bulk_stresses is not None and len(self.bulk_stresses) != len(values):
            raise InvalidInput(
                f"Fretting.bulk_stresses has {len(self.bulk_stresses)} stresses and Fretting.forces {len(values)}: give "
                "one for each force."
            )
        if self.period is not None and self.times is None:
            raise InvalidInput(
                "Fretting.period is given without times: give the times [s] of the forces, or leave period out."
            )

    @property
    def history(self) -> "FrettingHistory | None":
        """Forces [N/m] or displacements [m] over time; None without times."""
        if self.times is None:
            return None
        values = self.displacements if self.forces is None else self.forces
        assert values is not None
        return FrettingHistory(self.times, values)

    @classmethod
    def cycle(cls, coefficient: float, amplitude: float, steps: int = 1, bulk_stress: float = 0.0) -> "Fretting":
        """Return one cycle of fretting, from 0 to the `amplitude` [N/m], to its opposite, and to the amplitude again.

        Each half cycle takes equal `steps`. One is exact where nothing varies along the length. A bulk stress with an
        amplitude of `bulk_stress` [Pa] is in phase.
        """
        count = valid("Fretting.cycle.steps", steps, Annotated[int, at_least(1)])
        down = [1 - 2 * (n + 1) / count for n in range(count)]
        down[-1] = -1.0
        parts = (1.0, *down, *(-part for part in down))
        stresses = tuple(bulk_stress * part for part in parts) if bulk_stress else None
        forces = tuple(amplitude * part for part in parts)
        return cls(coefficient, forces, bulk_stresses=stresses)

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if the contact cannot stick, or its traction is not supported."""
        if self.times is None or scene.rolling is not None:
            check_static(scene, "Fretting")
        if scene.wear is not None and scene.wear.speed != 0:
            raise InvalidInput(
                f"Wear.speed is {scene.wear.speed!r} together with Fretting: wear then follows from the slip of "
                "the contact, give a speed of 0 m/s."
            )
        if self.displacements is not None and isinstance(scene.load, ChangingLoad):
            raise InvalidInput(
                "Scene.load changes in time together with Fretting.displacements: the traction locked in by a rising "
                "pressure follows from forces only, give Fretting.forces, or a LineLoad."
            )
        check_tangential_response(scene, "Fretting")
        check_similar(scene, "Fretting")
        if self.bulk_stresses is not None:
            bulk_compliance(scene, self.bulk_body, "Fretting.bulk_stresses")
        for place, force, load in self._forces_and_loads(scene):
            limit = transmitted_force(scene, self.coefficient, load)
            if force and not abs(force) < limit:
                raise InvalidInput(
                    f"Fretting.forces{place} is {readable(force, 'N m-1')}, where friction transmits less than "
                    f"{readable(limit, 'N m-1')}: the contact would slide fully, give a smaller force, or displacements."
                )

    def _forces_and_loads(self, scene: SceneContext) -> Iterator[tuple[str, float, float]]:
        """Yield an index or a time in words, the force and the load there [N/m]."""
        load, history = scene.load, self.history
        if self.forces is None:
            return
        if history is None:
            yield from ((f"[{number}]", force, scene.largest_load) for number, force in enumerate(self.forces))
            return
        for time in history.compared_with(load):
            pressed = load.at(time) if isinstance(load, ChangingLoad) else scene.largest_load
            yield f" at {time:g} s", history.at(time), pressed

    def solver(self, scene: SceneContext, gap: Array, grid: Grid, paddings: Paddings, datum: float) -> FrettingShear:
        """Return the solver of this scene on a grid."""
        assert self.forces is not None
        forces = tuple(mean_over_grid(force, scene, grid, paddings) for force in self.forces)
        response = self.response(scene, grid, paddings, datum)
        if not any(self.bulk_stresses or ()):
            return FrettingShear(self.coefficient, forces, response)
        compliance = bulk_compliance(scene, self.bulk_body, "Fretting.bulk_stresses", paddings)
        bulk = BulkStress(0.0, self.bulk_body, compliance)
        return FrettingShear(self.coefficient, forces, response, bulk, self.bulk_stresses or ())

    @staticmethod
    def response(scene: SceneContext, grid: Grid, paddings: Paddings, datum: float) -> ShearResponse:
        """Return the displacement of both bodies of `scene` under tangential traction."""
        return shear_response(shearable(scene.solids), grid, paddings, datum)


@validated
class PartialSlip:
    """Partial slip under a tangential force that friction holds back.

    The bodies are pressed first, then loaded tangentially, and never unloaded. The traction is that of
    :class:`~contactstudy.Fretting` with this one force, whose answer also has the slip and the energy lost.

    Parameters
    ----------
    coefficient
        Coefficient of friction, above 0 and below 1.
    tangential
        Force along x on the first body, over the length that the load acts on [N/m]; of either sign, less than the
        coefficient times the load, and beside adhesion times the sum of the load and of the attraction.
    total
        The same on the whole length of a roller [N], in place of `tangential`.
    bulk_stress
        Stress of one whole body along x [Pa], tension positive, which rises with the force (fretting fatigue). A strain
        of ``(1 - nu^2) / E`` times this adds to the slip, and its stress to that below the surface.
    bulk_body
        Index (0 or 1) of the body with the bulk stress.

    Raises
    ------
    InvalidInput
        For other values; in a scene with elastically dissimilar bodies, a change in time, or rolling.
    """

    sticks: ClassVar[bool] = True

    coefficient: FrictionCoefficient
    tangential: Annotated[NewtonsPerMetre, FINITE] | None = None
    total: Annotated[Newtons, FINITE] | None = None
    bulk_stress: Annotated[Pascals, FINITE] = 0.0
    bulk_body: BodyIndex = 0

    def check_together(self) -> None:
        """Check that one force is given."""
        if (self.tangential is None) == (self.total is None):
            raise InvalidInput(
                "PartialSlip.tangential and PartialSlip.total are both given or both None: give a force along x [N/m], "
                "or on the whole of a roller [N]."
            )

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if the contact cannot stick, or its traction is not supported."""
        check_static(scene, "PartialSlip")
        check_tangential_response(scene, "PartialSlip")
        check_similar(scene, "PartialSlip")
        check_force(scene, self, scene.largest_load, "a smaller force, or Sliding")
        if self.bulk_stress:
            bulk_compliance(scene, self.bulk_body, "PartialSlip.bulk_stress")

    def solver(self, scene: SceneContext, gap: Array, grid: Grid, paddings: Paddings, datum: float) -> PartialSlipShear:
        """Return the solver of this scene on a grid: that of fretting with one force."""
        force = force_per_length(self, scene)
        assert force is not None
        stresses = (self.bulk_stress,) if self.bulk_stress else None
        fretting = Fretting(self.coefficient, (force,), bulk_stresses=stresses, bulk_body=self.bulk_body)
        return PartialSlipShear(fretting.solver(scene, gap, grid, paddings, datum))
