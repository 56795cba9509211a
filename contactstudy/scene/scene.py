"""A scene: load, bodies, shapes and effects that a user names of a contact, and the problem that they make on a grid.

What it names decides on the method by which it is solved: see :mod:`~contactstudy.scene.combinations`. x runs across
the contact, y along its length.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, log2, pi, prod, sqrt
from operator import is_
from typing import TYPE_CHECKING, Annotated, Any, Protocol, runtime_checkable

import numpy as np

from contactstudy.analytic import HertzEllipse, HertzLine
from contactstudy.domain.errors import InNotebook
from contactstudy.domain.grid import Grid, Padding, Paddings, across_and_along, is_free
from contactstudy.domain.validation import OR_INFINITE, Example, Hardness, InvalidInput, valid, validated
from contactstudy.elasticity.convolution import Convolution, padded_cells, superposed
from contactstudy.problem.constraint import Constraint, Control, PrescribedApproach, PrescribedLoad
from contactstudy.problem.problem import AdhesionSolver, Derived, OuterSolver, Problem, Scales, refuse_too_large
from contactstudy.scene import loads
from contactstudy.scene.combinations import STATIC, Method, changing_field, method_of, named_by, refuse_pairs
from contactstudy.scene.shapes.roller import FiniteLength
from contactstudy.scene.shapes.shape import (
    Shape,
    ShapesSource,
    check_width,
    curvature_of,
    curvatures_of,
    ends_along,
    length_scales_of,
    summed_gap,
    with_extent_of,
)
from contactstudy.scene.solids import bodies
from contactstudy.scene.solids.bodies import Body, check_free_faces, creeps

if TYPE_CHECKING:
    from contactstudy.scene.adhesion import Adhesion
    from contactstudy.scene.friction import Rolling, Wear
    from contactstudy.scene.lubrication import Lubrication
    from contactstudy.solvers.adhesion import AdhesiveSolver


AnyLoad = loads.ConstantLoad | loads.ChangingLoad | loads.Approach | loads.PullOff


@runtime_checkable
class Output(Protocol):
    """Further result of a solution, as a value in ``Scene.outputs``."""

    def check(self, solids: tuple[Body, ...]) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if the output is not defined for these bodies."""

    def of(self, solids: tuple[Body, ...], grid: Grid, paddings: Paddings) -> Derived:
        """Return the output for these bodies on `grid`; fields are computed on first access."""


@runtime_checkable
class Friction(Protocol):
    """Friction law, as a value in ``Scene.friction``; its ``check(scene)``, if it has one, may refuse a scene."""

    def solver(self, scene: "Scene", grid: Grid, paddings: Paddings, datum: float) -> OuterSolver:
        """Return the solver of a scene with this friction on a grid, which has the solver of the pressure inside it.

        The `datum` [m] is the distance from the axis at which the surface does not move.
        """


# Least approach over the width of the grid that gives the scale of pressure between flat bodies, so that an approach of
# 0 m has one too: from 1e-9 to 1e-3 the answer is the same to 1e-8.
MIN_APPROACH_RATIO = 1e-6
# Sum of the curvatures over the largest of them below which the sum is rounding: the convex body has the radius of the
# hollow one.
CONFORMING = 1e-9
# Length of the grid of a point contact over that of its ellipse of contact, which must not reach the end rows: with 1.1
# it does on the coarsest grids.
LENGTH_OVER_ELLIPSE = 1.2


@validated
class Scene(InNotebook):
    """Line contact of two bodies, and the effects in it.

    Its effects determine what :func:`~contactstudy.solve` computes: a contact at rest, in time, rolling, or lubricated.

    Parameters
    ----------
    load
        Load, such as :class:`~contactstudy.LineLoad` or :class:`~contactstudy.TotalLoad`, one that changes in time, or
        an :class:`~contactstudy.Approach` or the :class:`~contactstudy.PullOff`, of which the load is a result.
    solids
        Two bodies, such as :class:`~contactstudy.HalfSpace`, at most one of them rigid.
    shapes
        Contributions to the undeformed gap, which add up.
    hardness
        Largest pressure [Pa] that the softer body carries, infinite for no limit. Where it is reached the body yields
        by the ``dent`` of the solution, without a gap. The dent is not remembered, so that scenes in which pressures
        fall again are refused.
    outputs
        Further results, such as :class:`~contactstudy.SubsurfaceStress`, one of each kind; of a contact at rest also one
        of each body. Fields and quantities of the second end with the index of its body, such as ``von_mises_1``.
    wear
        Sliding wear, or None.
    rolling
        Steady rolling, or passes over a body that yields, or None.
    friction
        Law that adds tangential traction to the pressure, such as :class:`~contactstudy.Sliding`, or None.
    lubrication
        Lubricant between the bodies and the motion that draws it in, or None for a dry contact.
    adhesion
        Attraction between the surfaces, or None.

    Raises
    ------
    InvalidInput
        If a value is of another kind, both bodies are rigid, or two effects cannot be combined.
    """

    load: AnyLoad
    solids: tuple[Annotated[Body, Example("HalfSpace(210e9, 0.3)")], Annotated[Body, Example("HalfSpace(210e9, 0.3)")]]
    shapes: tuple[Annotated[Shape, Example("Cylinder(radius=0.01)")], ...] = ()
    hardness: Annotated[Hardness, OR_INFINITE] = inf
    outputs: tuple[Annotated[Output, Example("SubsurfaceStress(depths=(1e-4,))")], ...] = ()
    wear: "Wear | None" = None
    rolling: "Rolling | None" = None
    friction: Annotated[Friction, Example("Sliding(coefficient=0.1)")] | None = None
    lubrication: "Lubrication | None" = None
    adhesion: "Adhesion | None" = None

    def check_together(self) -> None:
        """Check what the effects of the scene must have in common, and refuse two that cannot be combined."""
        bodies.contact_modulus(self.solids)  # refuses two rigid bodies
        for number, shape in enumerate(self.shapes):
            valid(f"Scene.shapes[{number}].curvature", curvature_of(shape), float)
        self._check_curvatures()
        refuse_pairs(self)
        effects = self.rolling, self.friction, self.lubrication, self.adhesion, self.wear
        for part in (self.load, *effects, *self.solids):
            getattr(part, "check", lambda _: None)(self)
        self._check_outputs()
        if self.free_length < inf:
            check_free_faces(self.free_length, self.shapes, self.hertz)

    def _check_curvatures(self) -> None:
        """Check that a hollow body has room for the other."""
        across, _ = self.curvatures
        sharpest = max((abs(curvatures_of(shape)[0]) for shape in self.shapes), default=0.0)
        if across < 0 or 0 <= across < CONFORMING * sharpest:
            raise InvalidInput(
                f"Scene.shapes have curvatures that add up to {across:.4g} 1/m: the hollow body must have the larger "
                "radius, give that of a hollow body below 0 m and a convex one that fits into it."
            )

    def _check_outputs(self) -> None:
        """Check the outputs, of each kind of which there may be one, in a contact at rest one of each body."""
        given = set()
        for number, output in enumerate(self.outputs):
            kind = type(output), getattr(output, "body", None) if self.method is STATIC else None
            if kind in given:
                raise InvalidInput(
                    f"Scene.outputs[{number}] is {output!r}, the second of its kind: give one, or in a contact at rest "
                    "one of each body."
                )
            given.add(kind)
            output.check(self.solids)

    @cached_property
    def named(self) -> frozenset[str]:
        """Effects that the scene names, in the words of :mod:`~contactstudy.scene.combinations`."""
        return named_by(self)

    @property
    def method(self) -> Method:
        """Method by which :func:`~contactstudy.solve` solves the scene."""
        return method_of(self)

    @property
    def radius(self) -> float | None:
        """Equivalent radius R [m] of a line contact, 1/R the sum of its curvatures; None of flats, and of a ball."""
        curvature = sum(map(curvature_of, self.shapes))
        return 1 / curvature if curvature > 0 else None

    @property
    def curvatures(self) -> tuple[float, float]:
        """Sums of the curvatures of the shapes (across, along) [1/m]."""
        each = list(map(curvatures_of, self.shapes))
        return sum(across for across, _ in each), sum(along for _, along in each)

    @property
    def is_point_contact(self) -> bool:
        """True if a total load presses bodies that are curved both ways and have no length."""
        is_total = isinstance(self.load, loads.TotalLoad) and self.load.length is None
        return is_total and min(self.curvatures) > 0 and self._shortest_roller is None

    @property
    def ellipse(self) -> HertzEllipse | None:
        """Smooth point contact, where a coated body has its modulus at the semi-axis across; None of a line contact."""
        if not self.is_point_contact:
            return None
        total, (across, along) = self.load.total, self.curvatures  # type: ignore[union-attr]

        def half_width(modulus: float) -> float:
            return HertzEllipse(total, across, along, modulus).semi_axes[0]

        return HertzEllipse(total, across, along, bodies.modulus_at_own_width(half_width, self.solids))

    @property
    def free_length(self) -> float:
        """Length [m] of the shortest body with free faces, at which contact ends; infinite without such a body."""
        return min(getattr(solid, "free_faces", inf) for solid in self.solids)

    @property
    def ended_shapes(self) -> tuple[Shape, ...]:
        """Contributions to the undeformed gap, and the end of the contact at free faces."""
        if self.free_length == inf:
            return self.shapes
        return (*self.shapes, FiniteLength(self.free_length))

    @property
    def _shortest_roller(self) -> float | None:
        """Length [m] of the shortest body with free faces, else of the shortest that the shapes end; None if endless."""
        if self.free_length < inf:
            return self.free_length
        lengths = [d.roller for d in length_scales_of(self.shapes) if 0 < d.roller < inf]
        return min(lengths, default=None)

    @property
    def roller_length(self) -> float | None:
        """Length of the roller [m], None if it is endless.

        It is that of the shortest body with free faces, else that of its total load, or of the shortest that the
        shapes end. Of a point contact it is the length of the grid that it needs.
        """
        shortest = self._shortest_roller
        if (ellipse := self.ellipse) is not None:
            # the gap beside the ellipse, curvature_along (y^2 - semi_axis^2) / 2, reaches the sum of the heights
            heights = sum(scales.height for scales in length_scales_of(self.shapes))
            reach = ellipse.semi_axes[1] ** 2 + 2 * heights / ellipse.curvature_along
            return 2 * LENGTH_OVER_ELLIPSE * sqrt(reach)
        return self.load.length_on(shortest) if isinstance(self.load, loads.TotalLoad) else shortest

    @property
    def largest_load(self) -> float:
        """Largest load over time [N/m], a total load over the length of its roller; 0 where an approach is given."""
        if not isinstance(self.load, loads.TotalLoad):
            return self.load.largest
        length = self.roller_length
        assert length is not None
        return self.load.total / length

    def loaded_length(self, grid: Grid, padding: Padding | Paddings) -> float:
        """Return the length [m] on which loads and forces per length act: that of a roller, else the period of `grid`.

        A roller that periodic images continue without end has no other length than the period. Of one that `grid` cuts
        off, only the part on it is loaded, but by the whole of a total load.
        """
        length = self.roller_length
        if length is None or self.repeats(padding):
            return grid.length
        return length if isinstance(self.load, loads.TotalLoad) else min(length, grid.length)

    def repeats(self, padding: Padding | Paddings) -> bool:
        """Return whether `padding` makes a roller infinite: it repeats the length, and no shape may end or crown it.

        A shape that does not name its length scales may.
        """
        scales = [getattr(shape, "length_scales", None) for shape in self.shapes]
        is_free_along = is_free(across_and_along(padding)[1])
        return not is_free_along and all(of_shape and not of_shape.roller for of_shape in scales)

    def mean_load(self, grid: Grid, padding: Padding | Paddings) -> float:
        """Return the mean along the period of `grid` [N/m] of the largest load over time."""
        return self.largest_load * self.loaded_length(grid, padding) / grid.length

    @property
    def reference_load(self) -> float:
        """Load [N/m] for the scales, the largest, or that of a smooth line at an approach; of adhesion if more."""
        largest = self.largest_load
        if isinstance(self.load, loads.Approach) and self.radius is not None:
            width = self.load.estimated_half_width(self.radius)
            modulus = bodies.contact_modulus(self.solids, width or None)
            largest = pi / 4 * modulus * width**2 / self.radius  # Hertz
        adhesion = self.adhesion
        return largest if adhesion is None else max(largest, adhesion.reference_load(self))

    def under(self, load: float) -> "Scene":
        """Return the scene under a constant load [N/m], on the same length."""
        if isinstance(self.load, loads.TotalLoad) and (length := self.roller_length):
            return replace(self, load=replace(self.load, total=load * length))
        return replace(self, load=loads.LineLoad(load))

    @property
    def contact_modulus(self) -> float:
        """Contact modulus E* [Pa] of both bodies; a coated body enters with its coating alone."""
        return bodies.contact_modulus(self.solids)

    @property
    def hertz(self) -> HertzLine | None:
        """Smooth line contact of the reference load, these bodies and the equivalent radius; None if one is missing.

        Coated bodies enter with the modulus that they have at the half-width of this contact, which is an estimate. Of a
        point contact it is the line contact with the same half-width and peak pressure.
        """
        if (ellipse := self.ellipse) is not None:
            return ellipse.line
        load, radius = self.reference_load, self.radius
        if radius is None or load <= 0:
            return None
        return bodies.hertz_line(load, radius, self.solids)

    def scales(self, grid: Grid) -> Scales:
        """Return the scales of the problem: Hertz's half-width a and peak pressure p, and the gap ``p a / E*``.

        Without a curved shape they are the width of the grid and the mean pressure, or that of the approach or of the
        adhesion. The pressure is rounded to a power of two, so that scaling a pressure or a hardness is exact.
        """
        if (hertz := self.hertz) is not None:
            length, pressure = hertz.half_width, hertz.peak_pressure
        else:
            length = grid.extent[0]
            pressure = self.reference_load / length
            if isinstance(self.load, loads.Approach):
                pressure = bodies.contact_modulus(self.solids, length) * max(
                    abs(self.load.approach) / length, MIN_APPROACH_RATIO
                )
            if self.adhesion is not None:
                pressure = max(pressure, self.adhesion.reference_pressure(self, length))
        gap = pressure * length / bodies.contact_modulus(self.solids, length)
        return Scales(length, 2.0 ** round(log2(pressure)), gap)

    def datum(self, grid: Grid) -> float:
        """Return the distance [m] that displacements count from where infinitely many images leave that open.

        It is that of an Approach that gives one, else twice the radius, at any load and on any grid; without a curved
        shape the width of `grid`.
        """
        of_radius = loads.DATUM_OVER_RADIUS * self.radius if self.radius else grid.extent[0]
        return getattr(self.load, "datum", None) or of_radius

    @property
    def histories(self) -> tuple[Any, ...]:
        """Load, speed of a film, and forces of friction, those that change in time and have an ``end`` [s]."""
        speed = getattr(self.lubrication, "mean_speed", None)
        given = self.load, speed, getattr(self.friction, "history", None)
        return tuple(history for history in given if hasattr(history, "end"))

    @property
    def rolls(self) -> bool:
        """True for `Rolling`, and for `TractiveRolling` of a body that creeps, whose response depends on speed."""
        return self.rolling is not None or self.rolling_speed is not None

    @property
    def has_tractive_rolling(self) -> bool:
        """True if friction transmits a traction in steady rolling."""
        return bool(getattr(self.friction, "is_steady", False))

    @property
    def rolling_speed(self) -> float | None:
        """Speed [m/s] along x of steady `Rolling`, or of `TractiveRolling` of a body that creeps; None for others."""
        if self.rolling is not None:
            return self.rolling.speed
        is_delayed = self.has_tractive_rolling and any(map(creeps, self.solids))
        return self.friction.speed if is_delayed else None  # type: ignore[union-attr]

    @property
    def contact_speeds(self) -> tuple[float, float]:
        """Speed [m/s] along x of a steady contact over each body; 0 of one at rest, and over the `standing` body."""
        standing, speed = getattr(self.friction, "standing", None), self.rolling_speed or 0.0
        return 0.0 if standing == 0 else speed, 0.0 if standing == 1 else speed

    @property
    def has_approach(self) -> bool:
        """True where the approach of the bodies is defined; it is not for bodies that creep as they roll.

        Delayed displacement counts from about the distance that the contact moves during the delay: relative to a datum
        it falls without limit with the logarithm of the speed.
        """
        return not (self.rolls and any(map(creeps, self.solids)))

    def problem(
        self, grid: Grid, padding: Padding | Paddings, adhesion_solver: "AdhesiveSolver | None" = None
    ) -> Problem:
        """Return the problem of this scene on a grid.

        Parameters
        ----------
        grid
            Cells and their size.
        padding
            Padding along the length, or a tuple (across, along).
        adhesion_solver
            Solver of the attraction that another grid has chosen; None chooses one for this grid.

        Raises
        ------
        InvalidInput
            If the arguments are of another kind, the scene changes in time, rolls or has a film, memory does not
            suffice, or no pressure leads to the approach.
        """
        valid("grid", grid, Grid)
        if self.method is not STATIC:
            changing = changing_field(self)
            reason = f"{changing} changes in time" if changing else f"Scene is {self.method.kind}"
            raise InvalidInput(
                f"{reason}, which takes more than one problem: call contactstudy.solve(scene, grid, padding), with "
                "times where it changes."
            )
        paddings = across_and_along(padding)
        refuse_too_large(grid, prod(padded_cells(grid, paddings)))
        if paddings[0].wraps:
            check_width(self.shapes, grid.extent[0])
        heights = summed_gap(self.ended_shapes, grid)
        gap = heights if heights.shape == grid.cells else np.broadcast_to(heights, grid.cells).copy()
        datum = self.datum(grid)
        # the sum of the pressures of all cells [Pa]
        control: Control = PrescribedLoad(self.mean_load(grid, padding) * grid.length / grid.cell_area)
        if isinstance(self.load, loads.Approach):
            self.load.check_on(gap, grid, paddings, datum)
            control = PrescribedApproach(self.load.approach)
        if adhesion_solver is None and self.adhesion is not None:
            adhesion_solver = self.adhesion.solver_on(self, heights, grid)
        attraction = 0.0 if adhesion_solver is None else adhesion_solver.law.strength
        varies = self.free_length < inf or bool((heights != heights[:, :1]).any())
        source = replace(self.source_with(grid, padding, adhesion_solver), sampled=(grid, heights))
        return Problem(
            grid=grid,
            undeformed_gap=gap,
            operator=self._operator(datum, grid, paddings),
            # a hardness limits the pressure less the attraction
            constraint=Constraint(self.hardness + attraction),
            control=control,
            scales=self.scales(grid),
            paddings=paddings,
            # outer cells that contact should not reach, where the surface goes on beyond them
            open_edges=(0, -1) if is_free(paddings[0]) else (),
            open_ends=(0, -1) if is_free(paddings[1]) and varies and not source.ends_along else (),
            source=source,
            outputs=tuple(output.of(self.solids, grid, paddings) for output in self.outputs),
            description=PosedScene(self, grid, padding),
            friction=None if self.friction is None else self.friction.solver(self, grid, paddings, datum),
            adhesion=self._adhesion_solver(adhesion_solver),
            covered_fractions=source.covered_fractions(grid),
        )

    def _operator(self, datum: float, grid: Grid, paddings: Paddings) -> Convolution:
        """Return the operator of both bodies on `grid`."""
        weights = bodies.response(self.solids, datum)
        if self.free_length == inf:
            return superposed(weights, grid, paddings)
        from contactstudy.elasticity.free_faces import between_faces  # only where they are named

        if not all(map(is_free, paddings)):
            raise InvalidInput(
                f"padding is {paddings!r}: bodies with free faces end along the length and have no images, give "
                "ZeroPadding() along both axes."
            )
        return between_faces(weights, grid, paddings)

    def _adhesion_solver(self, solver: "AdhesiveSolver | None") -> AdhesionSolver | None:
        """Return the solver of the attraction, or the search for the pull-off with it."""
        if solver is None or not isinstance(self.load, loads.PullOff):
            return solver
        from contactstudy.solvers.adhesion import PullOffSearch  # imported only where it is named

        return PullOffSearch(solver, self.load.error)

    def source_with(self, grid: Grid, padding: Padding | Paddings, solver: "AdhesiveSolver | None") -> ShapesSource:
        """Return the source from which the problem is made on other grids.

        Shapes without an extent of their own get that of `grid`. All problems share the `solver` of the attraction.
        """
        shapes = with_extent_of(self.shapes, grid)
        # a scene that stays the same is not checked again
        unchanged = all(map(is_, shapes, self.shapes))
        scene = self if unchanged else replace(self, shapes=shapes)
        ended = scene.ended_shapes
        return ShapesSource(ended, ends_along(ended, grid), lambda on: scene.problem(on, padding, solver))


@dataclass(frozen=True)
class PosedScene:
    """Scene with the grid and the padding on which a problem was made of it."""

    scene: Scene
    grid: Grid
    padding: Padding | Paddings


def scene_of(problem: Problem) -> Scene | None:
    """Return the scene that a problem was made of; None for a problem that was not made of one."""
    posed = problem.description
    return posed.scene if isinstance(posed, PosedScene) else None
