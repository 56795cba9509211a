"""The answer for a dry contact: its solution, the bounds of its errors, and its numbers.

The errors follow from the contact itself by laws, and from the same scene on 1 / k of the cells along each axis. That
is solved when a bound is first asked for. A contact may be a frame, the state at one instant of an evolution. An output
is a further result that the scene names, such as the stress below the surface; its fields are called derived.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Any

from contactstudy.accuracy.bound import is_highest_beside_edge, lawful_edges
from contactstudy.accuracy.coarser import coarse_solution, coarsened, comparable
from contactstudy.accuracy.estimate import error_estimate
from contactstudy.answers.answer import OF_EDGES, Answer, levels_below, with_nested_bounds
from contactstudy.domain.errors import STATIC_ORDER, ErrorEstimate, ErrorParts, Request
from contactstudy.domain.grid import Grid, Padding, Paddings, edge_fraction
from contactstudy.domain.imports import needed_for
from contactstudy.domain.validation import NotDefined
from contactstudy.io.quantities.contact_quantities import contact_quantities
from contactstudy.io.quantities.quantity import NO_ESTIMATE, Quantities, roller_length
from contactstudy.io.quantities.stress_quantities import stress_quantities
from contactstudy.problem.problem import DependsOnShear, Derived, Field
from contactstudy.scene.scene import PosedScene, Scene, scene_of
from contactstudy.solvers.solution import Counts, Solution

if TYPE_CHECKING:
    import xarray as xr

    from contactstudy.evolution.steady_rolling import SteadyRolling


@dataclass(frozen=True, eq=False, repr=False)
class Contact(Answer, Solution):
    """Dry contact: fields (x, y) of its :class:`Solution`, and what its scene names beside them.

    Parameters
    ----------
    requested
        Requested relative error of every number, or errors by name.
    estimate
        Estimate of its errors, where it is known already; None computes it on first access.
    rolling
        Rolling resistance and centroid of a steadily rolling contact; None for others.
    time
        Time [s] of a frame of an evolution; None for others.
    state
        Fields that a frame keeps from one instant to the next, such as the wear depth, by name.
    is_coarse
        Whether the contact is on coarser cells, to compare others with, and has no bounds of its own.
    """

    requested: Request | None = None
    estimate: ErrorEstimate | None = None
    rolling: "SteadyRolling | None" = None
    time: float | None = None
    state: Mapping[str, Field] = field(default_factory=dict)
    is_coarse: bool = False

    @property
    def scene(self) -> Scene | None:
        """Scene of the contact; None for a problem that was not made of one."""
        return scene_of(self.problem)

    @property
    def grid(self) -> Grid:
        """Grid of the fields."""
        return self.problem.grid

    @property
    def padding(self) -> Padding | Paddings | None:
        """Boundary conditions; None for an operator that has none."""
        posed = self.problem.description
        return posed.padding if isinstance(posed, PosedScene) else self.problem.paddings

    @property
    def loaded_length(self) -> float:
        """Length [m] that carries the load. It is that of a roller, or else the period of the grid."""
        return roller_length(self.problem.description) or self.grid.length

    @cached_property
    def error(self) -> ErrorEstimate:
        """Errors by :func:`~contactstudy.accuracy.estimate.error_estimate`; infinite for a contact on coarser cells."""
        if self.is_coarse:
            unknown = ErrorParts(discretisation=inf, reason=NO_ESTIMATE)
            return ErrorEstimate(unknown)
        try:
            if self.rolling is not None and self.estimate is None:
                # the range of an attraction may be chosen for the grid, so that half the cells have another scene
                half = self._below.get(2) if self.adhesion is None else None
                return self.rolling.error_estimate(half)
            if self._depends_on_history or self.status.is_failure or not self.pressure.any():
                return self.estimate or error_estimate(self)
            # the bodies touch: approach and stress get an error too
            estimate = self.estimate or error_estimate(self, coarse=self._on_half_the_cells)
            return self._with_derived(estimate)
        except NotDefined as reason:
            unknown = ErrorParts(discretisation=inf, reason=f"No bound: {reason}")
            return ErrorEstimate(unknown, unknown, unknown, unknown, warnings=(unknown.reason,))

    @property
    def _depends_on_history(self) -> bool:
        """True for a frame with an estimate of its own, since it depends on earlier pressures.

        A frame without one, as in a history of loads with adhesion, is in equilibrium by itself.
        """
        return self.time is not None and self.estimate is not None

    def _with_derived(self, estimate: ErrorEstimate) -> ErrorEstimate:
        """Return `estimate` with warnings of ends and yield, and errors of stresses that no change of grids shows."""
        from contactstudy.accuracy.estimate import stress_error
        from contactstudy.accuracy.plausibility import (
            beyond_strength,
            end_of_half_space,
            stress_margin,
            unrelieved_ends,
        )

        of_ends = () if self.is_coarse else (end_of_half_space(self), unrelieved_ends(self))
        warnings = (*filter(None, of_ends), *estimate.warnings)
        if "von_mises" not in self.derived:
            return replace(estimate, warnings=warnings)
        stress, depths = (self.derived[name].values for name in ("von_mises", "z"))
        # a contact beyond the hardness or first yield of a body is warned of already
        scene = None if beyond_strength(self) else self.scene
        yields = "" if scene is None else stress_margin(scene, self.derived).sentence
        return replace(
            estimate,
            stress=stress_error(self, stress, depths, estimate),
            warnings=(*warnings, *filter(None, (yields,))),
        )

    @cached_property
    def derived(self) -> Mapping[str, Field]:
        """Fields of the outputs that the scene names, such as stress below the surface."""
        fields: dict[str, Field] = {}
        for number, output in enumerate(self.problem.outputs):
            with_shear: Derived = output
            if self.traction is not None and isinstance(output, DependsOnShear):
                with_shear = output.with_shear(self.traction.shear, self.traction.bulk)
            for name, found in with_shear.fields(self.net_pressure).items():
                suffix = self._suffix(number) if name != "component" else ""
                axes = [f"{axis}{suffix}" if axis == "z" else axis for axis in found.dimensions]
                fields[f"{name}{suffix}"] = replace(found, dimensions=tuple(axes))
        return fields

    def derived_at_depths_of(self, other: "Contact") -> Mapping[str, Field]:
        """Return the fields of the outputs at the depths that those of an `other` contact of the scene have chosen."""
        outputs: list[Any] = list(self.problem.outputs)
        for number, output in enumerate(outputs):
            if hasattr(output, "depths"):
                depths = other.derived[f"z{self._suffix(number)}"].values
                outputs[number] = replace(output, depths=tuple(depths))
        return replace(self, problem=replace(self.problem, outputs=tuple(outputs))).derived

    def _suffix(self, number: int) -> str:
        """Return what the names of the output `number` end with: the index of its body if it is the second of a kind."""
        if self.scene is None or number == 0:
            return ""
        output = self.scene.outputs[number]
        is_first = type(output) not in map(type, self.scene.outputs[:number])
        return "" if is_first else f"_{output.body}"  # type: ignore[attr-defined]

    def _with_output_alone(self, number: int) -> "Contact":
        """Return the contact with one of its outputs, for the numbers of its body."""
        posed = self.problem.description
        assert isinstance(posed, PosedScene)
        alone = replace(posed.scene, outputs=(posed.scene.outputs[number],))
        problem = replace(
            self.problem, outputs=(self.problem.outputs[number],), description=replace(posed, scene=alone)
        )
        return replace(self, problem=problem)

    @cached_property
    def quantities(self) -> Quantities:
        """Numbers of the contact by name, with unit and bound."""
        found, error = contact_quantities(self, self.error, self.derived, self.rolling), self.error
        of_stress = dict.fromkeys(found, error.stress)  # added to the bounds of stresses alone
        for number in range(1, len(self.problem.outputs) if found else 0):
            if suffix := self._suffix(number):
                alone = self._with_output_alone(number)
                of_body = stress_quantities(alone.scene, alone.derived, self.grid, alone.error, self.problem.paddings)
                found |= {f"{name}{suffix}": quantity for name, quantity in of_body.items()}
                of_stress |= {f"{name}{suffix}": alone.error.stress for name in of_body}
        if self._depends_on_history or not any(each.reason == NO_ESTIMATE for each in found.values()):
            return found
        unseen = dict.fromkeys((*OF_EDGES, "half_length"), error.contact_area)
        unseen |= {"mean_gap": error.mean_gap, "approach": error.approach}
        # straight edges lie inside their cells by a law of their own, and are compared with such alone
        by_law = frozenset(OF_EDGES if lawful_edges(self) else ())
        below = {
            k: {name: number for name, number in level.quantities.items() if name not in by_law or lawful_edges(level)}
            for k, level in self._below.items()
        }
        return with_nested_bounds(
            found,
            below,
            error.l1,
            frozenset({NO_ESTIMATE}),
            edge_fraction=edge_fraction(self.pressure > 0),
            order=self._order,
            unseen={name: parts.total for name, parts in unseen.items() if parts},
            of_stress={name: parts.total for name, parts in of_stress.items() if parts},
            by_law=by_law,
            at_edge=frozenset({"peak_pressure"} if is_highest_beside_edge(self.pressure) else ()),
        )

    @property
    def _order(self) -> float:
        """Power of the cell size with which the errors of its numbers fall."""
        source = self.problem.source
        ends = source is not None and source.ends_along
        rolls = self.rolling is not None or hasattr(self.traction, "creepage")
        return 1.0 if ends or rolls or self.adhesion is not None else STATIC_ORDER

    @cached_property
    def _below(self) -> "dict[int, Contact]":
        """The contact on 1 / k of the cells along each axis by k, as far as these have a solution."""
        if self.is_coarse or self.status.is_failure:
            return {}
        return levels_below(self._on_coarser_cells)  # type: ignore[return-value]

    @cached_property
    def _on_half_the_cells(self) -> Solution | None:
        """The solution on half of the cells along each axis; None where the problem is not known on them."""
        return coarse_solution(self.problem, self.pressure, self.attraction)

    def _on_coarser_cells(self, factor: int) -> "Contact":
        """Return the contact on 1 / `factor` of the cells along each axis."""
        if self.rolling is not None:
            rolled = self.rolling.solve_on(coarsened(self.grid, factor))
            return contact_answer(rolled.solution, rolling=rolled, is_coarse=True)
        coarse = self._on_half_the_cells
        if factor != 2:
            coarse = coarse_solution(self.problem, self.pressure, self.attraction, factor)
        if (coarse := comparable(coarse)) is None:
            raise NotDefined("There is no solution on coarser cells.")
        return contact_answer(coarse, is_coarse=True)

    @property
    def judged_error(self) -> tuple[str, ErrorParts]:
        """Bound of the pull-off load for a PullOff, else of the pressure in L1."""
        if self.error.pull_off is not None:
            return "in the pull-off load", self.error.pull_off
        return super().judged_error

    @property
    def counts(self) -> Counts:
        """Iterations, FFT convolutions and residual of the solver, and outer iterations where it took some.

        The lagged part of a rolling contact is the displacement that follows from the pressure of the iteration before.
        """
        counts = {
            "iterations": (self.iterations, "solver iterations"),
            "convolutions": (self.convolutions, "FFT convolutions of the full grid"),
            "residual": (self.residual, "residual of the solver"),
        }
        lagged = None if self.rolling is None else self.rolling.lagged
        for part, name in ((self.adhesion, "attraction"), (lagged, "lagged part")):
            if part is not None:
                taken = part.outer_iterations, f"outer iterations over the {name}"
                counts["outer_iterations"] = taken
        return counts

    def to_dataset(self) -> "xr.Dataset":
        """Return fields (x, y) and quantities with units, long names, bounds, errors by cause and the scene.

        The attribute ``scene`` is the scene as TOML with grid and padding, which :func:`~contactstudy.read_scene` reads
        back, unless heights were given as an array or a shape is the user's own.
        """
        with needed_for("Contact.to_dataset"):
            from contactstudy.io.dataset import contact_dataset

        dataset = contact_dataset(self, self.error, self.quantities, self.derived)
        return dataset.assign_attrs(accuracy=self.accuracy)

    def dataset_to_draw(self) -> "xr.Dataset":
        """Return the dataset with the loop of force and displacement of a contact that frets, of seven solves a step."""
        dataset = self.to_dataset()
        from contactstudy.io.dataset import fretting_loop

        return dataset.assign(fretting_loop(self))


def contact_answer(solution: Solution, **further_fields: Any) -> Contact:
    """Return `solution` as an answer, with `further_fields` of :class:`Contact`."""
    return Contact(**{field.name: getattr(solution, field.name) for field in fields(Solution)}, **further_fields)
