"""The answer for a scene that changes in time, or rolls repeatedly: a sequence of answers (frames) with times.

A frame is the answer for one instant, or after one pass. Bounds of its errors by the cells are known at once for some
methods. Those of others, and of numbers of the whole evolution, follow from the same evolution on coarser cells.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import inf
from re import sub
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from contactstudy.accuracy.error_terms import NO_BOUND_OF_STATES
from contactstudy.answers.answer import NO_COARSER, Answer, Coarser, levels_below, solved_or_none, with_nested_bounds
from contactstudy.answers.contact import Contact, contact_answer
from contactstudy.domain.errors import ErrorEstimate, ErrorParts, Request
from contactstudy.domain.grid import Array, Grid, Padding, Paddings, edge_fraction
from contactstudy.domain.imports import needed_for
from contactstudy.domain.validation import readable
from contactstudy.io.quantities.evolution_quantities import evolution_quantities, history_quantities, passes_quantities
from contactstudy.io.quantities.quantity import NO_ESTIMATE, Quantities, Quantity
from contactstudy.problem.problem import DependsOnStrain, Field
from contactstudy.scene.scene import PosedScene, Scene
from contactstudy.scene.shapes.shape import left_out, shortest_wavelengths, standing_heights, unresolved
from contactstudy.solvers.solution import Counts, Status, worst

if TYPE_CHECKING:
    import xarray as xr

    from contactstudy.answers.lubricated_contact import LubricatedContact
    from contactstudy.evolution.evolve_lubricated import FilmTrajectory
    from contactstudy.evolution.repeated_rolling import RepeatedRolling
    from contactstudy.evolution.time_stepper import Frame, Trajectory

# A frame: a dry contact, or a film.
AnyFrame = TypeVar("AnyFrame", "Contact", "LubricatedContact")

NO_BOUND_OF_PASSES = (
    "No bound: the discretisation error of repeated rolling is not estimated. It is of first order in the cell width: "
    "solve again with half the cell width and compare."
)
NO_BOUND_OF_FILMS = "No bound for the discretisation error of a film at one instant: solve bounds that of all together."
# Reasons for which a number has no bound until it is compared with solutions on coarser cells; these then give the
# bound.
BY_GRIDS = frozenset({NO_ESTIMATE, NO_BOUND_OF_STATES, NO_BOUND_OF_FILMS})
# Outcomes of steps after which nothing is known of the error: later instants follow from a state that is no equilibrium.
WITHOUT_EQUILIBRIUM = (Status.NOT_CONVERGED, Status.FILM_NOT_CONVERGED, Status.SHEAR_BEYOND_YIELD, Status.WORN_THROUGH)


def _by_size(l1: ErrorParts) -> tuple[float, bool, float]:
    """Return the key by which L1 errors of instants are sorted: total, whether it has no bound at all, error by steps.

    Errors of films by their cells are infinite at one instant and bounded for all together; other infinite errors have
    no bound.
    """
    return l1.total, l1.reason != NO_BOUND_OF_FILMS, l1.steps or 0.0


@dataclass(frozen=True, eq=False, repr=False)
class Evolution(Answer):
    """Contacts at several instants, or after several passes of a contact that rolls.

    Parameters
    ----------
    frames
        Answer at each instant, or after each pass: a contact or a lubricated contact.
    times
        The instants [s] (time,); the numbers of the passes where a contact rolls repeatedly.
    posed
        The scene with grid and padding.
    requested
        Requested relative error of every number, or errors by name, of cells and steps together.
    trajectory
        Recorded frames of a dry contact; None for others.
    films
        Recorded instants of a film; None for others.
    passes
        Recorded passes of a repeatedly rolling contact; None for others.
    coarser
        Solves the scene again for bounds by comparison, ``coarser(k, width)``: on 1 / k of the cells along each axis,
        over a multiple of the width, with steps k times as long; None where bounds take no other solution.
    """

    frames: "tuple[Contact | LubricatedContact, ...]"
    times: Array
    posed: PosedScene
    requested: Request | None = None
    trajectory: "Trajectory | None" = None
    films: "FilmTrajectory | None" = None
    passes: "RepeatedRolling | None" = None
    coarser: Coarser | None = None

    @property
    def status(self) -> Status:
        """The worst status of all steps."""
        return worst([frame.status for frame in self.frames])

    @property
    def scene(self) -> Scene:
        """The scene."""
        return self.posed.scene

    @property
    def grid(self) -> Grid:
        """Grid of the fields."""
        return self.posed.grid

    @property
    def padding(self) -> Padding | Paddings:
        """Boundary conditions."""
        return self.posed.padding

    @property
    def pressure(self) -> Array:
        """Pressure (time, x, y) [Pa]."""
        return np.stack([frame.pressure for frame in self.frames])

    def over_time(self, quantity: str) -> Array:
        """Return a quantity of every frame (time,) in its SI unit, such as ``"peak_pressure"``."""
        return np.array([frame.quantities[quantity].value for frame in self.frames])

    @cached_property
    def error(self) -> ErrorEstimate:
        """Estimate of the errors by cause at the instant of the largest L1 error, with the warnings of all instants.

        That of a film by its cells and its inlet is the largest of all instants, from films on coarser and wider grids.
        """
        # separated bodies have no pressure, hence no relative error
        touching = [frame for frame in self.frames if frame.pressure.any() or frame.status.is_failure]
        by_pressure = sorted(touching or self.frames, key=lambda frame: -frame.pressure.max())
        estimates = [frame.error for frame in by_pressure]
        largest = max((estimate.l1 for estimate in estimates), key=_by_size)
        # of sentences that differ by their numbers alone, only that of the highest pressure is kept
        sentences: dict[str, str] = {}
        for sentence in (text for estimate in estimates for text in estimate.warnings):
            sentences.setdefault(sub(r"[\d.]+", "", sentence), sentence)
        warnings = tuple(sentences.values())
        if self.status in WITHOUT_EQUILIBRIUM:
            largest = replace(largest, residual=inf, reason=str(self.status))
            warnings = (largest.reason, *warnings)
        elif largest.reason == NO_BOUND_OF_FILMS and self.coarser is not None:
            largest = self._l1_of_films(largest)
            warnings = *filter(None, (largest.reason,)), *(text for text in warnings if text != NO_BOUND_OF_FILMS)
        else:
            return replace(next(estimate for estimate in estimates if estimate.l1 is largest), warnings=warnings)
        return ErrorEstimate(largest, warnings=warnings)

    @cached_property
    def quantities(self) -> Quantities:
        """Extremes over time, final values, and permanent changes such as wear and residual stress, by name."""
        quantities = self._quantities
        if self.coarser is None or not any(quantity.reason in BY_GRIDS for quantity in quantities.values()):
            return quantities
        below = {k: level.quantities for k, level in self._below.items()}
        return with_nested_bounds(
            quantities,
            below,
            self.error.l1,
            BY_GRIDS,
            edge_fraction=0.0 if self.films else edge_fraction(self.frames[-1].pressure > 0),
            wider=self._wider.quantities if self._wider else None,
            zone_edge=self._zone_edge,
        )

    @cached_property
    def _plastic_fields(self) -> Mapping[str, Field]:
        """Strain and residual stress (time, component, z, x, y) by name, the last coupled state of bodies that yield."""
        if self.trajectory is not None and self.trajectory.coupled is not None:
            last_frame = self.trajectory.frames[-1]
            return self.trajectory.coupled.over_time([last_frame.coupled_state])
        return {}

    @property
    def _zone_edge(self) -> float:
        """Fraction of the cells of a body's plastic zone that lie at the edge of the zone; the largest of all bodies.

        The zone is seen along y: a cell (z, x) belongs to it that has yielded anywhere along the length.
        """
        zones = (
            field.values[-1].any(axis=-1)
            for name, field in self._plastic_fields.items()
            if name.startswith("equivalent_plastic_strain")
        )
        return max(map(edge_fraction, zones), default=0.0)

    @cached_property
    def _below(self) -> "dict[int, Evolution]":
        """The evolution on 1 / k of the cells, with longer steps, by k as far as there is one."""
        return levels_below(self.coarser) if self.coarser else {}  # type: ignore[return-value]

    @cached_property
    def _wider(self) -> "Evolution | None":
        """Films on half the cells over twice the width, which tell the error due to the inlet; None without films."""
        if self.films is None or self.coarser is None:
            return None
        return solved_or_none(self.coarser, 2, 2)  # type: ignore[return-value]

    def _l1_of_films(self, known: ErrorParts) -> ErrorParts:
        """Return the largest L1 error of the pressure of films over all instants, with a `known` error by the steps.

        Where evolutions on other grids have other instants, as where one ends early, the last ones are compared.
        """
        from contactstudy.answers.lubricated_contact import l1_of_films

        wider: Any = self._wider
        if 2 not in self._below or wider is None:
            return replace(known, reason=NO_COARSER)
        levels: dict[int, Any] = {1: self} | self._below
        all_frames = len({len(level.frames) for level in (*levels.values(), wider)}) == 1
        of_frames = [
            l1_of_films({k: level.frames[number] for k, level in levels.items()}, wider.frames[number], known)
            for number in (range(len(self.frames)) if all_frames else (-1,))
        ]
        cells, inlet = (max(getattr(parts, cause) for parts in of_frames) for cause in ("discretisation", "inlet"))
        return replace(known, discretisation=cells, inlet=inlet, reason="")

    @property
    def _quantities(self) -> dict[str, Quantity]:
        """Quantities by name, without the bounds that follow from solutions on coarser cells."""
        if self.passes is not None:
            last = self.frames[-1].quantities["peak_pressure"]
            return {"peak_pressure": last} | passes_quantities(self.passes)
        numbers = evolution_quantities(
            [frame.quantities for frame in self.frames],
            self.times.tolist(),
            self.frames[-1].state,
            self._plastic_fields,
            self.posed,
            self.error.l1,
            self.films.ranges if self.films else {},  # of all steps
        )
        if self.trajectory is not None and self.scene.adhesion is not None:
            errors = [frame.quantities["approach"].bound for frame in self.frames]
            numbers = history_quantities(self.trajectory.frames, errors, self.scene.load) | numbers
        return numbers

    @property
    def counts(self) -> Counts:
        """Number of instants or passes, work that they took, and the largest residual of their contacts."""
        recorded = self.trajectory or self.films or self.passes
        assert recorded is not None
        residual = max(frame.residual for frame in self.frames)
        return {**recorded.counts, "residual": (residual, "largest residual")}

    def to_dataset(self) -> "xr.Dataset":
        """Return fields over (time, x, y) and quantities with units, long names, bounds and the scene."""
        with needed_for("Evolution.to_dataset"):
            from contactstudy.io import dataset as labels

        if self.passes is not None:
            dataset = labels.passes_dataset(self.passes)
        elif self.trajectory is not None:
            dataset = labels.evolution_dataset(self.trajectory, self.frames)
        else:
            dataset = labels.over_time(self.times, [frame.to_dataset() for frame in self.frames])
        dataset.attrs.pop("warnings", None)  # of the first instant by itself
        if self.films is not None and self.error.warnings:
            dataset.attrs["warnings"] = " ".join(self.error.warnings)
        return labels.with_quantities(dataset, self.quantities).assign_attrs(accuracy=self.accuracy)


def evolution_answer(trajectory: "Trajectory", requested: Request | None = None) -> Evolution:
    """Return the frames of a dry contact as an answer, up to that in which a coating is worn through."""
    posed, times = trajectory.description, trajectory.times
    frames = _until_worn_through(posed.scene, times, (_frame(trajectory, frame) for frame in trajectory.frames))
    if frames[-1].status is Status.WORN_THROUGH:  # no stress in a coating that is gone
        frames[-1] = replace(frames[-1], problem=replace(frames[-1].problem, outputs=()))
    kept = replace(trajectory, frames=trajectory.frames[: len(frames)])
    return Evolution(tuple(frames), kept.times, posed, requested, kept)


def _until_worn_through(scene: Scene, times: Array, frames: Iterable[AnyFrame]) -> list[AnyFrame]:
    """Return the answers at instants, `times` [s], up to the first with the coating worn through, whose status says so.

    Where the coating is thinner than at first, the errors have no bound, since its response is that of its first
    thickness.
    """
    body = 0 if scene.wear is None else scene.wear.body
    solid = scene.solids[body]
    # only a coated body has interfaces; the thickness of others is that of a plate
    thickness = getattr(solid, "thickness", inf) if getattr(solid, "interfaces", ()) else inf
    kept: list[AnyFrame] = []
    for number, frame in enumerate(frames):
        worn = frame.state.get("wear_depth")
        deepest = 0.0 if worn is None else float(worn.values.max())
        if deepest >= thickness:
            since = "at" if not number else f"between {times[number - 1]:g} s and"
            reason = f"No bound: the coating of solids[{body}] is worn through {since} {times[number]:g} s."
            kept.append(_unbounded(replace(frame, status=Status.WORN_THROUGH), reason))
            break
        if thickness < inf and deepest > 0:
            lost = f"is thinner by up to {readable(deepest)} than the {readable(thickness)} that its response is for"
            frame = _unbounded(frame, f"No bound: the coating of solids[{body}] {lost}.")
        kept.append(frame)
    return kept


def _unbounded(frame: AnyFrame, reason: str) -> AnyFrame:
    """Return an answer whose errors by the cells are infinite, for a `reason` that its warnings say first."""
    parts: dict[str, Any] = {name: replace(part, discretisation=inf, reason=reason) for name, part in frame.error}
    warnings = reason, *frame.error.warnings
    return replace(frame, estimate=replace(frame.error, warnings=warnings, **parts))


def _frame(trajectory: "Trajectory", frame: "Frame") -> Contact:
    """Return a recorded frame of a trajectory as an answer; its gap includes wear depth and residual displacement.

    The errors of a frame without an estimate are those of a contact at rest, with those by the steps where it has worn.
    """
    contact = contact_answer(frame, time=frame.time, state=frame.fields, rolling=frame.rolling, estimate=frame.estimate)
    if frame.estimate is None:
        worn = frame.fields.get("wear_depth")
        has_worn = worn is not None and worn.values.any()
        return _with_steps(contact, frame.errors_by_steps) if has_worn else contact
    if trajectory.coupled is None:
        return contact
    residual = partial(trajectory.coupled.residual_stress, frame.coupled_state)
    outputs = tuple(
        output.with_residual_stress(residual) if isinstance(output, DependsOnStrain) else output
        for output in frame.problem.outputs
    )
    return replace(contact, problem=replace(frame.problem, outputs=outputs))


def _with_steps(contact: Contact, by_steps: Mapping[str, float]) -> Contact:
    """Return a contact that has worn with its relative time-discretisation errors `by_steps`, by quantity, added.

    Quantities without such an error, as gap, approach and stress, which depend on the wear depth itself, have no bound.
    """
    estimate = contact.error
    unknown = ErrorParts(discretisation=inf, reason=NO_BOUND_OF_STATES)
    with_steps: dict[str, Any] = {
        name: replace(parts, steps=by_steps[name]) if name in by_steps else unknown for name, parts in estimate
    }
    return replace(contact, estimate=replace(estimate, **with_steps))


def passes_answer(rolled: "RepeatedRolling", requested: Request | None = None) -> Evolution:
    """Return the passes of a contact under repeated rolling as an answer, whose numbers are compared with coarser cells.

    The errors of the fields have no bound.
    """
    unknown = ErrorParts(discretisation=inf, reason=NO_BOUND_OF_PASSES)
    shapes, grid = rolled.description.scene.shapes, rolled.description.grid
    unresolved_waves = unresolved(shortest_wavelengths(shapes), grid)
    of_heights = standing_heights(shapes), unresolved_waves, *left_out(shapes, grid)
    warnings = (NO_BOUND_OF_PASSES, *filter(None, of_heights))
    estimate = ErrorEstimate(unknown, peak_pressure=unknown, contact_area=unknown, mean_gap=unknown, warnings=warnings)
    frames = tuple(
        contact_answer(replace(each_pass.solution, status=each_pass.status), estimate=estimate)
        for each_pass in rolled.passes
    )
    numbers = np.arange(1.0, len(frames) + 1)
    return Evolution(frames, numbers, rolled.description, requested, passes=rolled)


def films_answer(films: "FilmTrajectory", requested: Request | None = None) -> Evolution:
    """Return the instants of a film as an answer, up to that in which a coating is worn through.

    The errors by the steps are those of `films`; those by the cells follow from other solutions.
    """
    from contactstudy.answers.lubricated_contact import film_answer

    first = films.contacts[0]
    posed = PosedScene(first.scene, first.grid, first.padding)
    unresolved_waves = unresolved(shortest_wavelengths(first.scene.shapes), first.grid)
    frames = []
    for contact, time, steps in zip(films.contacts, films.times, films.time_discretisation_errors, strict=True):
        l1 = ErrorParts(discretisation=inf, steps=float(steps), reason=NO_BOUND_OF_FILMS)
        warnings = (*filter(None, (unresolved_waves,)), NO_BOUND_OF_FILMS)
        frames.append(film_answer(contact, time=time, estimate=ErrorEstimate(l1, warnings=warnings)))
    kept = _until_worn_through(first.scene, np.array(films.times), frames)
    errors = films.time_discretisation_errors[: len(kept)]
    films = replace(
        films, contacts=films.contacts[: len(kept)], times=films.times[: len(kept)], time_discretisation_errors=errors
    )
    return Evolution(tuple(kept), np.array(films.times), posed, requested, films=films)
