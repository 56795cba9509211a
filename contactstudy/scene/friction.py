"""Motion of the surfaces against each other: friction of sliding and fretting bodies, rolling without and with it, wear.

Tangential traction is that on the first body, along x where nothing else is said. Two bodies are elastically *similar*
if it never changes the gap between them (Dundurs' beta of zero).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise, product
from math import inf, isinf
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from contactstudy.analytic import HertzLine
from contactstudy.domain import validation
from contactstudy.domain.grid import Array, Grid, Paddings, is_free
from contactstudy.domain.validation import InvalidInput, at_least, readable, valid, validated
from contactstudy.elasticity import tangential
from contactstudy.elasticity.convolution import GeneralConvolution
from contactstudy.scene import loads
from contactstudy.scene.shapes.shape import LengthScales, Shape, gap_of, length_scales_of
from contactstudy.scene.solids import bodies
from contactstudy.scene.solids.bodies import Body, HalfSpace, SceneContext
from contactstudy.scene.solids.coated import CoatedHalfSpace
from contactstudy.scene.solids.inelastic import rolling_bodies
from contactstudy.solvers.coulomb import FullSliding
from contactstudy.solvers.fretting import FrettingShear, PartialSlipShear
from contactstudy.solvers.solution import Creepage
from contactstudy.solvers.tractive_rolling import ShearPressureCoupling, TractiveShear

# Coefficient of a law with stick: without friction nothing sticks.
FrictionCoefficient = Annotated[validation.Number, validation.BELOW_ONE]
# Instants at which a force is compared with the friction limit under a load that changes. Between two of them a load of
# one sinusoidal cycle differs from a straight line by 1.2e-4 of its amplitude.
SAMPLES = 201


def has_proportional_compliances(solids: tuple[Body, ...], gap: Array, paddings: Paddings) -> bool:
    """Return whether the tangential compliance is in proportion to the normal one, under an undeformed `gap` (x, y).

    Tangential traction along x then displaces the surface along x as pressure does along z. That is so of bodies
    without coating in plane strain, and for a Poisson's ratio of 0.
    """
    if any(map(bodies.is_layered, solids)):
        return False
    materials = (material for solid in solids for material in _materials(solid))
    if all(material.compliance * material.poisson_ratio == 0 for material in materials):
        return True
    return paddings[1].window is None and bool((gap == gap[:, :1]).all())


def dundurs(solids: tuple[Body, ...]) -> float:
    """Return Dundurs' beta of the instantaneous response of two bodies, 0 for two equal bodies of any kind.

    ``beta = (a1 - a2) / (2 (b1 + b2))`` with a = (1 - 2 nu) / G and b = (1 - nu) / G of either body, where nu is
    Poisson's ratio and G the shear modulus (Johnson 1985, eq. 5.3). For coated bodies it is the value of largest
    magnitude between any two of their materials, those of the layers and of the substrates.

    Raises
    ------
    InvalidInput
        For bodies whose response to traction is not known.
    """
    first, second = solids
    if first == second:
        return 0.0
    return max((_dundurs(*pair) for pair in product(_materials(first), _materials(second))), key=abs)


def _dundurs(first: HalfSpace, second: HalfSpace) -> float:
    """Return Dundurs' beta of two materials; 0 if both are rigid, since neither is displaced."""
    a1, a2 = (
        (1 - 2 * solid.poisson_ratio) * (1 + solid.poisson_ratio) / solid.youngs_modulus for solid in (first, second)
    )
    total = first.compliance + second.compliance
    return (a1 - a2) / (2 * total) if total else 0.0


def _materials(solid: Body) -> tuple[HalfSpace, ...]:
    """Return the material of a body, or those of its layers and its substrate.

    Raises InvalidInput for a body of another kind, whose response to traction is not known.
    """
    if isinstance(solid, CoatedHalfSpace):
        return *solid.layers, solid.substrate
    body: Any = getattr(solid, "instantaneous", solid)
    if hasattr(body, "poisson_ratio"):
        return (HalfSpace(body.youngs_modulus, body.poisson_ratio),)
    raise InvalidInput(
        f"Scene.solids are given together with friction, and the response to traction of a {type(solid).__name__} is "
        "not known: give a HalfSpace or a CoatedHalfSpace."
    )


def are_similar(solids: tuple[Body, ...]) -> bool:
    """Return whether tangential traction between two bodies never changes the gap."""
    first, second = solids
    if first == second:
        return True
    # displacement along the normal under traction along x, from any datum; with the sign -1 what changes the gap
    of_first, of_second = (body.shear_compliance(datum=1.0)["x"] for body in shearable(solids))
    if any(map(bodies.creeps, solids)):  # bodies that are equal at first differ once they have crept
        return not any((*of_first.values(), *of_second.values()))
    return not tangential.summed_responses(-1, of_first, of_second)


def shearable(solids: tuple[Body, ...]) -> tuple[tangential.ShearableBody, ...]:
    """Return bodies that respond to tangential traction as `solids` do; one that creeps responds as at first.

    Raises :class:`~contactstudy.InvalidInput` for a body whose response is not known.
    """
    at_first = (getattr(solid, "instantaneous", solid) for solid in solids)
    return tuple(body if isinstance(body, tangential.ShearableBody) else _materials(body)[0] for body in at_first)


def shear_coupling(
    solids: tuple[Body, ...], axes: str, grid: Grid, paddings: Paddings, datum: float
) -> list[GeneralConvolution]:
    """Return the change of the gap by traction along each of the `axes` ("x" or "xy"), none for two similar bodies.

    The `datum` [m] is the distance from the axis at which the surface does not move.
    """
    if solids[0] == solids[1]:
        return []
    first, second = shearable(solids)
    return tangential.normal_displacement(first, second, axes, grid, paddings, datum)


def refuse_gross_slip(
    scene: SceneContext, field: str, force: float | None, coefficient: float, load: float, remedy: str
) -> None:
    """Raise InvalidInput for a tangential `force` [N/m] that friction does not transmit under a `load` [N/m].

    Nothing is refused where the largest force is known only with the pressure, at a given approach or beside an
    attraction; the law then refuses a larger one once the normal contact is solved. The message names the `field`.
    """
    is_known = scene.adhesion is None and not isinstance(scene.load, loads.Approach)
    if force and is_known and abs(force) >= coefficient * load:
        raise InvalidInput(
            f"{field} is {readable(force, 'N m-1')}: friction transmits less than "
            f"{readable(coefficient * load, 'N m-1')}, give {remedy}."
        )


def bulk_compliance(scene: SceneContext, body: int, field: str, paddings: Paddings | None = None) -> float:
    """Return the strain along x over a bulk stress along x [1/Pa] of a body whose strain along y is prevented.

    The `body` is an index in ``Scene.solids``.

    Raises
    ------
    InvalidInput
        For a body that is no elastic half-space, in a sentence that begins with the `field`, and for `paddings` with
        images across.
    """
    solid = scene.solids[body]
    if type(solid) is not HalfSpace or getattr(solid, "free_faces", inf) < inf or not solid.compliance:
        raise InvalidInput(
            f"{field} acts on Scene.solids[{body}], a {type(solid).__name__}: give the index of an elastic HalfSpace "
            "without free_faces."
        )
    if paddings is not None and not is_free(paddings[0]):
        raise InvalidInput(
            "Scene.friction has a bulk stress with images across, between which no stretch is periodic: leave "
            "padding_across out."
        )
    return solid.compliance


def check_force(scene: SceneContext, law: Any, load: float, remedy: str) -> None:
    """Refuse a ``tangential`` or ``total`` force of a `law` that friction does not transmit under a `load` [N/m]."""
    name = "tangential" if law.total is None else "total, over the length of the roller,"
    field, force = f"{type(law).__name__}.{name}", force_per_length(law, scene)
    refuse_gross_slip(scene, field, force, law.coefficient, load, remedy)


def force_per_length(law: Any, scene: SceneContext) -> float | None:
    """Return the tangential force of a `law` [N/m] over the length that the load acts on; None where it gives none.

    It is the law's ``tangential``, or its ``total`` [N] over the length of the roller.

    Raises
    ------
    InvalidInput
        For a total force where no roller has a length.
    """
    if law.total is None:
        return law.tangential  # type: ignore[no-any-return]
    if scene.roller_length is None:
        raise InvalidInput(
            f"{type(law).__name__}.total is {law.total!r}, and no roller has a length: give tangential [N/m], or a "
            "FiniteLength among the shapes."
        )
    return float(law.total / scene.roller_length)


def mean_over_grid(force: float, scene: SceneContext, grid: Grid, paddings: Paddings) -> float:
    """Return the mean along `grid` [N/m] of a tangential `force` [N/m] that acts on the length of the load."""
    return force * scene.loaded_length(grid, paddings) / grid.length


@validated
class Sliding:
    """Full sliding: the second body slides to larger x over the first one.

    The tangential traction is the coefficient times the pressure, along +x on the first body, along -x on the second.
    Between elastically dissimilar bodies (Dundurs' beta) traction makes the pressure asymmetric; between similar ones
    the pressure is that without friction.

    Parameters
    ----------
    coefficient
        Coefficient of friction, at least 0 and below 1.
    standing
        Index (0 or 1) in ``Scene.solids`` of the body on which the contact stands still, such as a slider or a block,
        which wears and creeps in one place. None for a contact that moves over both bodies.

    Raises
    ------
    InvalidInput
        For other coefficients; in a scene with repeated rolling, or with dissimilar bodies one of which creeps or that
        roll.
    """

    coefficient: Annotated[validation.Number, validation.FROM_ZERO_BELOW_ONE]
    standing: validation.BodyIndex | None = None

    def solver(self, scene: SceneContext, grid: Grid, paddings: Paddings, datum: float) -> FullSliding:
        """Return the solver of this scene on a grid, with the coupling of traction and normal displacement."""
        if self.coefficient == 0:
            return FullSliding(self.coefficient, None)
        coupling = shear_coupling(scene.solids, "x", grid, paddings, datum)
        return FullSliding(self.coefficient, coupling[0] if coupling else None)


@dataclass(frozen=True)
class FrettingHistory(loads.PiecewiseLinear):
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
        contact slides fully (gross slip, ``stick_fraction`` 0). Displacements are relative to the datum, a point at the
        distance of twice the equivalent radius (without a curved shape the width of the grid). With images along both
        axes they are relative to the mean.
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

    #: A part of the contact may stick.
    sticks: ClassVar[bool] = True

    coefficient: FrictionCoefficient
    forces: tuple[Annotated[validation.NewtonsPerMetre, validation.FINITE], ...] | None = None
    times: loads.Times | None = None
    displacements: tuple[Annotated[validation.Metres, validation.FINITE], ...] | None = None
    period: validation.Seconds | None = None
    bulk_stresses: tuple[Annotated[validation.Pascals, validation.FINITE], ...] | None = None
    bulk_body: validation.BodyIndex = 0

    def check_together(self) -> None:
        """Check that forces or displacements are given, and that times go with them."""
        if (self.forces is None) == (self.displacements is None):
            raise InvalidInput(
                "Fretting.forces and Fretting.displacements are both given or both None: give one of them."
            )
        name, values = "forces", self.forces
        if values is None:
            name, values = "displacements", self.displacements or ()
        if not values:
            raise InvalidInput(f"Fretting.{name} is (): give some, such as (1e4, -1e4, 1e4).")
        for given in ("times", "bulk_stresses"):
            if (numbers := getattr(self, given)) is not None:
                loads.check_one_each(f"Fretting.{given}", numbers, name, values)
        for given in ("displacements", "period"):
            if getattr(self, given) is not None and self.times is None:
                raise InvalidInput(f"Fretting.{given} is given without times: give times [s], or leave it out.")
        if self.times is not None:
            loads.check_not_decreasing("Fretting.times", self.times)
            if self.bulk_stresses is not None:
                raise InvalidInput("Fretting.bulk_stresses are given together with times: leave one of them out.")

    @property
    def history(self) -> "FrettingHistory | None":
        """Forces [N/m] or displacements [m] over time; None without times."""
        values = self.forces or self.displacements or ()
        return None if self.times is None else FrettingHistory(self.times, values)

    @classmethod
    def cycle(cls, coefficient: float, amplitude: float, steps: int = 1, bulk_stress: float = 0.0) -> "Fretting":
        """Return one cycle of fretting, from 0 to the `amplitude` [N/m], to its opposite, and to the amplitude again.

        Each half cycle takes equal `steps`. One is exact where nothing varies along the length. A bulk stress with an
        amplitude of `bulk_stress` [Pa] is in phase.
        """
        count = valid("Fretting.cycle.steps", steps, Annotated[int, at_least(1)])
        down = np.linspace(1, -1, count + 1)[1:].tolist()
        fractions = (1.0, *down, *(-fraction for fraction in down))
        stresses = tuple(bulk_stress * fraction for fraction in fractions) if bulk_stress else None
        return cls(coefficient, tuple(amplitude * fraction for fraction in fractions), bulk_stresses=stresses)

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if the contact cannot stick, or its traction is not supported."""
        shearable(scene.solids)
        if self.bulk_stresses is not None:
            bulk_compliance(scene, self.bulk_body, "Fretting.bulk_stresses")
        for place, force, load in self._forces_and_loads(scene):
            remedy = "a smaller force, or displacements"
            refuse_gross_slip(scene, f"Fretting.forces{place}", force, self.coefficient, load, remedy)

    def _forces_and_loads(self, scene: SceneContext) -> Iterator[tuple[str, float, float]]:
        """Yield the index of each force, or an instant, in words, with the force and the load there [N/m]."""
        load, history = scene.load, self.history
        if history is None:
            for number, force in enumerate(self.forces or ()):
                yield f"[{number}]", force, scene.largest_load
        elif self.forces is not None:
            for time in history.compared_with(load):
                pressed = load.at(time) if isinstance(load, loads.ChangingLoad) else scene.largest_load
                yield f" at {time:g} s", history.at(time), pressed

    def solver(self, scene: SceneContext, grid: Grid, paddings: Paddings, datum: float) -> FrettingShear:
        """Return the solver of this scene on a grid."""
        assert self.forces is not None
        forces = tuple(mean_over_grid(force, scene, grid, paddings) for force in self.forces)
        response = self.response(scene, grid, paddings, datum)
        if not any(self.bulk_stresses or ()):
            return FrettingShear(self.coefficient, forces, response)
        compliance = bulk_compliance(scene, self.bulk_body, "Fretting.bulk_stresses", paddings)
        return FrettingShear(self.coefficient, forces, response, self.bulk_stresses or (), self.bulk_body, compliance)

    @staticmethod
    def response(scene: SceneContext, grid: Grid, paddings: Paddings, datum: float) -> tangential.ShearResponse:
        """Return the displacement of both bodies of `scene` under tangential traction."""
        return tangential.shear_response(shearable(scene.solids), grid, paddings, datum)


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
        Force along x on the first body over the whole length of a roller [N], in place of `tangential`.
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

    #: A part of the contact may stick.
    sticks: ClassVar[bool] = True

    coefficient: FrictionCoefficient
    tangential: Annotated[validation.NewtonsPerMetre, validation.FINITE] | None = None
    total: Annotated[validation.Newtons, validation.FINITE] | None = None
    bulk_stress: Annotated[validation.Pascals, validation.FINITE] = 0.0
    bulk_body: validation.BodyIndex = 0

    def check_together(self) -> None:
        """Check that one force is given."""
        if (self.tangential is None) == (self.total is None):
            raise InvalidInput(
                "PartialSlip.tangential and PartialSlip.total are both given or both None: give a force along x [N/m], "
                "or on the whole of a roller [N]."
            )

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if the contact cannot stick, or its traction is not supported."""
        shearable(scene.solids)
        check_force(scene, self, scene.largest_load, "a smaller force, or Sliding")
        if self.bulk_stress:
            bulk_compliance(scene, self.bulk_body, "PartialSlip.bulk_stress")

    def solver(self, scene: SceneContext, grid: Grid, paddings: Paddings, datum: float) -> PartialSlipShear:
        """Return the solver of this scene on a grid: that of fretting with one force."""
        force = force_per_length(self, scene)
        assert force is not None
        stresses = (self.bulk_stress,) if self.bulk_stress else None
        fretting = Fretting(self.coefficient, (force,), bulk_stresses=stresses, bulk_body=self.bulk_body)
        return PartialSlipShear(fretting.solver(scene, grid, paddings, datum))


# Pressure of passes over a body that yields, by the names that :class:`Rolling` explains.
RollingPressure = Literal["solved", "elastic"]


@validated
class Rolling:
    """Rolling: the contact moves to larger x, steadily over both bodies, or repeatedly over one that yields.

    Heights stand still in the frame of the contact: those that vary across slide over the body that creeps or yields.

    Parameters
    ----------
    speed
        Speed of the contact [m/s], at least zero. Rolling is steady, after all transients. At infinite speed the bodies
        respond instantaneously. None with passes, which do not depend on it.
    passes
        Number of passes over a body that yields, at least 1; None rolls steadily.
    pressure
        Pressure of the passes: "solved" together with the plastic strain, or that of the "elastic" contact throughout,
        as Merwin & Johnson (1963) assume.
    distance
        Distance of each pass [m]. None rolls until the plastic strain left behind is steady.
    steady
        A pass is steady when the plastic strain that it leaves changes by less than this many yield strains (Y / E)
        while the contact rolls by its half-width. Half or twice the default changes the residual stress by about 1 %.

    Raises
    ------
    InvalidInput
        If neither speed nor passes are given, or both, if a setting of passes is given without passes, or if a value is
        outside these limits; in a scene with heights that move with a body.
    """

    speed: Annotated[validation.MetresPerSecond, validation.FROM_ZERO_TO_INFINITE] | None = None
    passes: Annotated[int, at_least(1)] | None = None
    pressure: RollingPressure = "solved"
    distance: validation.Metres | None = None
    steady: validation.Number = 5e-3

    def check_together(self) -> None:
        """Check that rolling is either steady or by passes, and that a setting of passes has them."""
        if (self.speed is None) == (self.passes is None):
            raise InvalidInput(
                f"Rolling.speed is {self.speed!r} and its passes {self.passes!r}: give a speed of at least 0 m/s, or "
                "passes, which do not depend on one."
            )
        if self.passes is None:
            for name in ("pressure", "distance", "steady"):
                if (value := getattr(self, name)) != getattr(Rolling, name):
                    raise InvalidInput(
                        f"Rolling.{name} is {value!r} without passes, to which alone it applies: give passes, or leave "
                        "it out."
                    )


# Speeds of TractiveRolling, which is not defined at rest.
NOT_ZERO = validation.Limits("other than 0", lambda x: validation.MIN_SIZE <= abs(x) <= validation.MAX_SIZE)
# Fewest widths of the contact by which it rolls while the load changes: what it rolls over is steady after one or two.
MIN_WIDTHS = 10.0


def check_slow(name: str, speed: float, load: loads.ChangingLoad, hertz: HertzLine | None) -> None:
    """Raise InvalidInput for a `load` that changes too fast for rolling by `name` to be steady at each instant."""
    if hertz is None:
        return
    duration = getattr(load, "period", inf) / 4  # from the mean load to the largest
    if isinstance(load, loads.PiecewiseLinear):
        steps = zip(pairwise(load.times), pairwise(load.values), strict=True)
        duration = min((end - start for (start, end), (a, b) in steps if a != b), default=inf)
    widths = abs(speed) * duration / (2 * hertz.half_width)
    if widths < MIN_WIDTHS:
        raise InvalidInput(
            f"Scene.load changes within {duration:g} s together with {name}, while the contact rolls by {widths:.2g} of "
            f"its widths: rolling is steady under a load that changes over {MIN_WIDTHS:g} or more, give slower changes, "
            "or a higher speed."
        )


# Warning of traction under heights that vary across, which a real surface would carry through the contact.
STATIONARY_HEIGHTS = "The heights are fixed in the frame of the contact: traction under moving heights is not computed."


@validated
class TractiveRolling:
    """Steady rolling with creepage: a part of the contact sticks, the rest slips.

    The contact moves over both bodies, to larger x at a positive speed, and material enters it ahead. Heights are fixed
    in the frame of the contact: profiles, roller ends, circumferential lay. Creepage is the rigid-body velocity of the
    second body relative to the first, over the rolling speed: a positive one makes a positive tangential traction on
    the first body. Between dissimilar bodies traction changes the pressure, and they slip under the normal load alone.
    Bodies that creep follow pressure and traction with their delay, which makes a rolling resistance.

    Parameters
    ----------
    coefficient
        Coefficient of friction, above 0 and below 1.
    longitudinal
        Creepage along x; None where a force is given.
    tangential
        Force along x on the first body, over the length that the load acts on [N/m], of either sign, less than the
        coefficient times the load. The longitudinal creepage follows from it. None where `longitudinal` is given.
    lateral
        Creepage along y.
    spin
        Rotation of the second body against the first about z, from x to y, over the distance rolled [1/m]. Its slip
        grows along the length, so that a roller must end or be crowned on the grid.
    speed
        Speed of rolling [m/s], not 0; negative if the contact moves to smaller x. Power is proportional to its size,
        and how far a body creeps in the contact follows from it.
    total
        Force along x on the first body over the whole length of a roller [N], in place of `tangential`.

    Raises
    ------
    InvalidInput
        For other values; in a scene with bodies that yield, heights that move with a body, a load that changes too
        fast to roll steadily, or spin of an endless contact.
    """

    #: Friction transmits a traction while the contact rolls steadily.
    is_steady: ClassVar[bool] = True
    #: A part of the contact may stick.
    sticks: ClassVar[bool] = True

    coefficient: FrictionCoefficient
    longitudinal: Annotated[validation.Number, validation.ANY_SIGN] | None = None
    tangential: Annotated[validation.NewtonsPerMetre, validation.ANY_SIGN] | None = None
    lateral: Annotated[validation.Number, validation.ANY_SIGN] = 0.0
    spin: Annotated[validation.Spin, validation.ANY_SIGN] = 0.0
    speed: Annotated[validation.MetresPerSecond, NOT_ZERO] = 1.0
    total: Annotated[validation.Newtons, validation.ANY_SIGN] | None = None

    def check_together(self) -> None:
        """Check that one creepage or force along x is given, and that the contact rolls."""
        given = [n for n in ("longitudinal", "tangential", "total") if getattr(self, n) is not None]
        if len(given) != 1:
            raise InvalidInput(
                f"TractiveRolling has {' and '.join(given) or 'none'} of longitudinal, tangential and total: give one, "
                "the creepage along x, the force along x [N/m], or that on the whole of a roller [N]."
            )

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if steady rolling is not defined in this scene."""
        shearable(scene.solids)
        least = scene.largest_load
        if isinstance(scene.load, loads.ChangingLoad):
            check_slow("TractiveRolling", self.speed, scene.load, scene.hertz)
            least = min(loads.turning_values(scene.load))
        self._refuse_endless(_rollers(scene))
        check_force(scene, self, least, "less, or a longitudinal creepage")

    def solver(self, scene: SceneContext, grid: Grid, paddings: Paddings, datum: float) -> TractiveShear:
        """Return the solver of this scene on a grid.

        Raises
        ------
        InvalidInput
            If the padding across wraps, so that material that leaves the contact would enter it again, or if it spins
            and no roller ends or is crowned on the grid.
        """
        gaps = [np.atleast_2d(gap_of(shape, grid)) for shape in _rollers(scene)]
        self._refuse_endless([np.ptp(gap, axis=1) for gap in gaps])
        if paddings[0].wraps:
            raise InvalidInput(
                f"padding[0] is {paddings[0]!r} together with TractiveRolling: material that leaves the contact would "
                "enter it again one period later: give ZeroPadding across."
            )
        solids = rolling_bodies(scene.solids, (self.speed, self.speed))
        sheared, force = shearable(solids), force_per_length(self, scene)
        has_waves = any(not isinf(scales.shortest_wavelengths[0]) for scales in length_scales_of(scene.shapes))
        coupling = shear_coupling(solids, "xy", grid, paddings, datum)
        return TractiveShear(
            self.coefficient,
            Creepage(self.longitudinal or 0.0, self.lateral, self.spin),
            None if force is None else mean_over_grid(force, scene, grid, paddings),
            self.speed,
            cache(lambda on: tangential.shear_response(sheared, on, paddings, datum)),
            ShearPressureCoupling(*coupling) if coupling else None,
            STATIONARY_HEIGHTS if has_waves else "",  # heights of a real surface would travel with it
        )

    def _refuse_endless(self, rollers: Sequence[Any]) -> None:
        """Raise InvalidInput for spin without `rollers`: shapes that end or crown one, or on a grid their drops [m]."""
        if self.spin and not any(map(np.any, rollers)):
            raise InvalidInput(
                f"TractiveRolling.spin is {self.spin!r} in a contact without end, where its slip grows along the length "
                "without limit: give a roller that ends or is crowned on the grid, such as a FiniteLength or a Crown."
            )


def _rollers(scene: SceneContext) -> list[Shape]:
    """Return the shapes that may end or crown a roller."""
    unknown = LengthScales(roller=inf)  # taken for a shape that does not name its length scales
    return [s for s in scene.shapes if getattr(s, "length_scales", unknown).roller]


@validated
class Wear:
    """Sliding wear after Archard (1953), ``dw/ds = coefficient p``.

    A body loses a depth w [m] along a sliding distance s [m], under the pressure p; on a boundary film under the
    pressure of asperities. Its coating becomes thinner, and its plastic strain comes nearer to the surface; of a coating
    that is worn through the answer ends with the status WORN_THROUGH. A body that turns through the contact wears alike
    all round, so that only its profile along the length changes. A scene with wear changes in time; see
    :func:`~contactstudy.solve`.

    Parameters
    ----------
    coefficient
        Specific wear rate k [1/Pa], the wear coefficient over the hardness, at least zero.
    speed
        Sliding speed [m/s], at least zero, so that ``ds = speed dt``; zero only where slip or a film gives it.
    body
        Index (0 or 1) of the wearing body in ``Scene.solids``.
    circumference
        Circumference [m] of the wearing body, or length of its track, where it moves through the contact, as in rolling
        and as a ring below a block; None where the contact stands still on it. Beside friction that says which body
        that is (:class:`~contactstudy.Sliding`), and beside rolling or a film, both must agree.

    Raises
    ------
    InvalidInput
        If a number is outside these limits; in a scene whose motion contradicts it, or whose bodies do not touch.
    """

    coefficient: Annotated[validation.SpecificWearRate, validation.AT_LEAST_ZERO]
    speed: Annotated[validation.MetresPerSecond, validation.AT_LEAST_ZERO]
    body: validation.BodyIndex = 0
    circumference: validation.Metres | None = None

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if the motion of `scene` gives another sliding or turning."""
        film, is_tractive = scene.lubrication, getattr(scene.friction, "is_steady", False)
        standing = getattr(scene.friction, "standing", None)
        # whether the wearing body turns, and by what; the circumference says it where nothing else does
        turns, by = self.circumference is not None, ""
        if film is not None:
            turns, by = film.contact_speeds[self.body] != 0, "Scene.lubrication"
        elif is_tractive or standing is not None:
            turns, by = is_tractive or standing != self.body, "Scene.friction"
        elif scene.rolling is not None:
            turns, by = True, "Scene.rolling"
        if turns and self.circumference is None:
            raise InvalidInput(
                f"Wear.circumference is None, and the wearing body turns by {by}, so that it wears alike all round: "
                "give its circumference."
            )
        if not turns and self.circumference is not None:
            raise InvalidInput(
                f"Wear.circumference is {self.circumference!r}, and the wearing body does not turn: leave it out."
            )
        slips = film is not None or is_tractive or getattr(scene.friction, "times", None) is not None
        if self.speed == 0 and not slips:
            raise InvalidInput(
                "Wear.speed is 0, and nothing else in the scene gives a sliding, so that nothing wears: give a speed "
                "above 0 m/s, Fretting with times, TractiveRolling or a film, or leave wear out."
            )

    @property
    def rate_per_pressure(self) -> float:
        """Wear rate per pressure ``k v`` [m/(Pa s)]."""
        return self.coefficient * self.speed
