"""What every answer has: status, grid, quantities, their bounds, and whether these keep a requested error.

A quantity is a number of an answer, such as the peak pressure, with its unit and the bound of its error; it is known by
a name. Where a law gives the error of a number, by straight edges, the peak or images, that is its bound. All others
are bounded by the same scene on a half, a third and a quarter of the cells, with longer steps. A request is the error
not to exceed, for all numbers or by name. The error in L1 is the mean absolute error of the pressure over the mean
pressure. What each kind of answer computes is in its own module.
"""

import re
from base64 import b64encode
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from io import BytesIO
from itertools import combinations, islice
from math import ceil, inf, isfinite, prod
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from contactstudy.accuracy.error_terms import IMAGES_REMEDY
from contactstudy.accuracy.plausibility import beyond_half_space
from contactstudy.domain import errors
from contactstudy.domain.errors import PRESSURE, ErrorEstimate, ErrorParts, InNotebook, Request
from contactstudy.domain.grid import Grid, cells_text
from contactstudy.domain.imports import needed_for
from contactstudy.domain.validation import InvalidInput, NotDefined, readable
from contactstudy.io.quantities.quantity import MAX_RELATIVE, RELATIVE_TO_ZERO, Quantities, Quantity, as_text, per_cent
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Counts, Status

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

NO_COARSER = "No bound: there is no solution on half the cells to compare with, give more."
# In the names of largest stresses.
OF_STRESS = "von_mises", "safety_factor", "shear_stress", "orthogonal_shear"
# Numbers that depend on where in their cells the edges of a contact lie.
OF_EDGES = "contact_area", "half_width", "mean_pressure", "contact_fraction"
# At the beginning of the names of numbers that plastic strain alone leaves behind.
BY_YIELD = "dent_depth", "shoulder_height", "highest_residual_stress", "lowest_residual_stress"
# Ends of the names of numbers at the edge of a plastic zone, a contact or its stick zone. Beside it fields fall like
# the square root of the distance.
AT_EDGE = "highest_residual_stress", "surface_tension", "largest_shear"
# In the name of a depth, before the index of a body where it has one.
DEPTH = re.compile(r"_depth(?=(_\d)?$)")
# Factor on the change between grids of numbers that have a law of their own too; the larger bound of both counts. It is
# half of `errors.MARGIN` for a peak pressure and a third for a pull-off, since the law bounds them as well.
BESIDE_LAW = {"peak_pressure": 0.75, "pull_off": 0.5} | dict.fromkeys(
    ("traction_coefficient", "creepage", "frictional_power", "largest_slip", "friction_energy"), errors.MARGIN
)
# Power of the cell size with which errors fall of a pressure that is highest beside an edge, as at a flat with rounded
# edges. It rises like the inverse square root of the distance, down to the rounding.
RISING_ORDER = 0.5
NO_COARSER_YIELD = "No bound: nothing yields on half the cells, give more."


def widened(grid: Grid, factor: int) -> Grid:
    """Return a grid with the same cells over `factor` times the width."""
    (nx, ny), (width, length) = grid.cells, grid.extent
    return Grid((factor * nx, ny), (factor * width, length))


def with_nested_bounds(
    quantities: Quantities,
    below: Mapping[int, Quantities],
    l1: ErrorParts,
    replaced: frozenset[str],
    *,
    edge_fraction: float = 0.0,
    order: float = 1.0,
    wider: Quantities | None = None,
    zone_edge: float = 0.0,
    unseen: Mapping[str, float] = MappingProxyType({}),
    of_stress: Mapping[str, float] = MappingProxyType({}),
    by_law: frozenset[str] = frozenset(),
    at_edge: frozenset[str] = frozenset(),
) -> dict[str, Quantity]:
    """Return quantities with bounds by their changes between grids, where their reasons are some of those `replaced`.

    A bound is a margin times the largest change, or times the least change that counts if that is more; errors by other
    causes than the cells are added. Numbers with a law of their own keep its bound, or that by their change if it is
    larger.

    Parameters
    ----------
    quantities
        The numbers of an answer.
    below
        Numbers on 1 / k of the cells along each axis, by k.
    l1
        Error of the pressure, whose causes but the cells add to each bound.
    replaced
        Reasons of numbers without a bound that get one.
    edge_fraction
        Fraction of the cells in contact that lie at its edge: the boundary of a stick zone is known to a row of cells,
        and a rolling resistance to half of this fraction.
    order
        Power of the cell size with which errors fall; beside an edge it is `EDGE_ORDER` at most.
    wider
        Numbers of a film on half the cells over twice the width; None elsewhere. Their change from half the
        cells over the same width shows the error of a finite inlet.
    zone_edge
        Fraction of the cells of a plastic zone that lie at its edge.
    unseen
        Relative errors that no change shows, by name, beside which half of the least change by `l1` is enough. Other
        numbers have the causes of `l1` but the cells in their place.
    of_stress
        Relative errors that no change of a largest stress shows, by name, beside those causes.
    by_law
        Names of numbers with a law of their own, which need no solution on coarser cells.
    at_edge
        Names of numbers that rise up to an edge, where their law does not hold.
    """
    other_causes = l1.total - (l1.discretisation or 0.0) if isfinite(l1.total) else inf
    bounded = dict(quantities)
    for name, quantity in quantities.items():
        if isfinite(quantity.bound) or quantity.reason not in replaced:
            continue
        values = {1: quantity.value} | {k: level[name].value for k, level in below.items() if name in level}
        coarser = list(values.values())[1:]
        if not coarser and name not in by_law:
            bounded[name] = replace(quantity, reason=NO_COARSER)
        elif name.startswith(BY_YIELD) and quantity.value and not any(coarser):
            bounded[name] = replace(quantity, reason=NO_COARSER_YIELD)
        elif not isfinite(other_causes):
            bounded[name] = replace(quantity, reason=l1.reason or quantity.reason)
        else:
            size = abs(quantity.value)
            by_l1 = errors.FLOOR * (l1.discretisation or 0.0) / (2 if name in unseen and name not in by_law else 1)
            floor = max(by_l1, quantity.least_change)
            if name.startswith(BY_YIELD):
                floor = max(floor, errors.AREA_FLOOR * zone_edge)
            if name == "rolling_resistance":
                floor = max(floor, errors.AREA_FLOOR * edge_fraction)
            others = unseen.get(name, other_causes)
            if any(stress in name for stress in OF_STRESS):
                floor = max(floor, errors.DEPTH_FLOOR if DEPTH.search(name) else 0.0)
                if "orthogonal" not in name:  # that shear stress is 0 at the surface
                    others += of_stress.get(name, 0.0)
            change = by_changes(values, min(order, errors.EDGE_ORDER) if _is_at_edge(name) else order)
            inlet = 0.0
            if wider is not None and name in wider:
                inlet = max(errors.INLET * abs(values[2] - wider[name].value), errors.FLOOR * (l1.inlet or 0.0) * size)
                others -= l1.inlet or 0.0
            bound = errors.MARGIN * max(change, floor * size) + inlet + others * size
            if name.endswith("stick_fraction"):
                bound = max(bound, edge_fraction)
            # a value that the largest may have as well, elsewhere or between the cells
            reach = max((value for value, _ in quantity.rivals), default=quantity.value)
            bound = max(bound, reach - quantity.value)
            reason = "" if bound else RELATIVE_TO_ZERO
            bounded[name] = replace(quantity, bound=bound or inf, reason=reason)
    for name, margin in BESIDE_LAW.items():
        if name in quantities and isfinite(bound := quantities[name].bound):
            levels = {1: quantities} | dict(below)
            margin, power = (errors.MARGIN, RISING_ORDER) if name in at_edge else (margin, order)
            change = by_changes({k: level[name].value for k, level in levels.items() if name in level}, power)
            bounded[name] = replace(bounded[name], bound=max(bound, margin * change))
    if "pull_off" in bounded and "load_per_length" in bounded:  # the load is that
        bounded["load_per_length"] = replace(bounded["load_per_length"], bound=bounded["pull_off"].bound)
    for name, depth in bounded.items():
        largest = bounded.get(DEPTH.sub("", name), depth)
        if largest is not depth and isfinite(depth.bound):
            # the depth may be that of any value within the bound of the largest
            within = largest.value - largest.bound
            away = [abs(at - depth.value) for value, at in largest.rivals if value >= within]
            bounded[name] = replace(depth, bound=max(depth.bound, *away, 0.0))
    for name in [name for name in bounded if name.startswith("safety_factor_depth")]:  # of the same place as a stress
        depths = [depth for other, depth in bounded.items() if "von_mises_depth" in other]
        same = next((depth for depth in depths if depth.value == bounded[name].value), None)
        if same is not None and isfinite(bounded[name].bound):
            bounded[name] = replace(bounded[name], bound=same.bound, reason=same.reason)
    return bounded


def by_changes(
    values: Mapping[int, Any], order: float, distance: Callable[[Any, Any], float] = lambda a, b: abs(a - b)
) -> float:
    """Return the error of a number, or of a field with a `distance`, by its changes between any two of several grids.

    A change between 1 / j and 1 / k of the cells shows an error that falls with a power `order` of the cell size as
    ``k^order - j^order`` times itself. One change may vanish by chance, the largest of six hardly does.

    Parameters
    ----------
    values
        Values on 1 / k of the cells along each axis, by k; that of k = 1 is the one judged.
    order
        The power.
    distance
        Distance between two values.
    """
    pairs = combinations(sorted(values), 2)
    return max((distance(values[j], values[k]) / (k**order - j**order) for j, k in pairs), default=0.0)


def _is_at_edge(name: str) -> bool:
    """Return whether a number lies at an edge; the name may end with the index of a body."""
    return re.sub(r"_\d$", "", name).endswith(AT_EDGE)


# Ends of the names of numbers for which finer cells are no remedy. The depth of a largest stress is known only to the
# distance between the depths at which stress is computed. Hence the bound of the stress has a least change too.
NOT_BY_CELLS = "safety_factor_depth", "von_mises_depth", "shear_stress_depth", "orthogonal_shear_depth"
# What is in the names of numbers for which no grid is refined unless a request names them. Stresses of fatigue and
# numbers at an edge take many more cells; margins of parts of a coated body follow from their von Mises stress.
NOT_REFINED = "shear_stress", "orthogonal_shear", "_safety_factor", *AT_EDGE
# Names of components, with the whole quantity: the error of a component is relative to the whole, if that is larger.
WHOLE = {"lateral_traction_coefficient": "traction_coefficient"}


@dataclass(frozen=True)
class Judged:
    """Bound of one number of an answer beside the error that is requested of it.

    Attributes
    ----------
    label
        Name for display.
    bound
        Bound of its relative error, or of the error itself where the number is a fraction. Infinite where it has none.
    requested
        Error not to exceed; infinite without a request.
    reason
        Why it has no bound; empty where it has one.
    order
        Power of the cell size with which the bound falls; 0 if finer cells do not lessen it.
    absolute
        The bound as text with its unit where the number is nearly zero beside it; empty elsewhere.
    """

    label: str
    bound: float
    requested: float
    reason: str = ""
    order: float = 1.0
    absolute: str = ""

    @property
    def ratio(self) -> float:
        """Bound over the requested error, or the bound itself without a request."""
        return self.bound / self.requested if isfinite(self.requested) else self.bound

    @property
    def finer(self) -> float:
        """Factor on the cells along an axis with which the bound meets the request.

        It is infinite for a number that finer cells do not help.
        """
        return self.ratio ** (1 / self.order) if self.order else inf

    def __str__(self) -> str:
        """Return the bound and the name, such as ``0.7 % in the half-width``."""
        bound = (self.absolute or per_cent(self.bound)) if isfinite(self.bound) else "no bound"
        return f"{bound} in the {self.label}"


def judged_numbers(quantities: Quantities, request: Request | None) -> dict[str, Judged]:
    """Return the numbers that a request speaks of, by name: all that have an error if it names none.

    A name of the request stands for the number of that name, else for all that end with it. So ``von_mises`` names the
    largest stress of the body, of its coating and of its substrate.

    Raises
    ------
    InvalidInput
        For a name that no number has.
    """
    uncertain = {name: quantity for name, quantity in quantities.items() if _is_uncertain(quantity)}
    if not isinstance(request, Mapping):
        return {name: _judged(name, quantities, inf if request is None else request) for name in uncertain}
    judged: dict[str, Judged] = {}
    for key, requested in request.items():
        if key == PRESSURE:
            continue
        names = [name for name in quantities if _is_named(name, key)]
        if not names:
            known = ", ".join((PRESSURE, *uncertain))
            raise InvalidInput(f"error names {key!r}, which this answer does not have: give some of {known}.")
        names = [key] if key in names else names  # the closest name is the one that is meant
        judged |= {name: _judged(name, quantities, requested) for name in names if name in uncertain}
    return judged


def _is_named(name: str, key: str) -> bool:
    """Return whether `key` is the `name` of a number or its last words, before the index of a body where it has one."""
    return re.sub(r"_\d$", "", name).endswith(f"_{key}") or name == key


def _is_uncertain(quantity: Quantity) -> bool:
    """Return whether a number has a relative error: it is neither exact, nor a formula, nor zero."""
    is_zero = quantity.reason == RELATIVE_TO_ZERO or (isfinite(quantity.bound) and not quantity.value)
    return not (quantity.is_formula or not quantity.bound or is_zero)


def _judged(name: str, quantities: Quantities, requested: float) -> Judged:
    """Return the number `name` of the `quantities`, with a `requested` relative error."""
    quantity = quantities[name]
    whole = quantities.get(WHOLE.get(name, name), quantity)
    scale = 1.0 if quantity.is_fraction else max(abs(quantity.value), abs(whole.value))
    bound = quantity.bound / scale if scale else inf
    label = quantity.label.split(" (")[0] + (" (absolute)" if quantity.is_fraction else "")
    is_of_depths = name.endswith(NOT_BY_CELLS) or errors.MARGIN * quantity.least_change > requested
    order = 0.5 if _is_at_edge(name) else float(not is_of_depths)  # its bound falls like the root of the cell
    absolute = readable(quantity.bound, quantity.unit, 2) if MAX_RELATIVE < bound < inf else ""
    return Judged(label, bound, requested, quantity.reason, order, absolute)


def without_bound(numbers: Iterable[Judged]) -> str:
    """Return which numbers have no bound, with the reason of the first; empty if all have one."""
    unknown = [number for number in numbers if not isfinite(number.bound)]
    if not unknown:
        return ""
    first, others = unknown[0], len(unknown) - 1
    beside = f" and {others} other{'s' if others > 1 else ''}" if others else ""
    why = re.sub(r"^No bound[^:]*: ", "", first.reason).rstrip(".")
    return f"no bound for the {first.label}{beside}: {why}"


def finer_grid(grid: Grid, factor: float) -> Grid:
    """Return a grid of the same extent with `factor` times the cells along each axis that has several."""
    across, along = (count if count == 1 else ceil(count * factor) for count in grid.cells)
    return Grid((across, along), grid.extent)


# What to change where the bound is too large, by the cause of its largest part.
REMEDIES = {
    "images": f"the images that the padding omits: {IMAGES_REMEDY}",
    "discretisation": "the cells: give an error to plan for, or a grid of more cells",
    "residual": "the residual of the solver: give a smaller tolerance",
    "steps": "the steps in time: give them a smaller error",
    "inlet": "the finite inlet: give a wider grid",
    "range": "the range of the attraction: give a grid of more cells",
}
# Lines on quantities in a representation, which has ten with the accuracy and the status.
SHOWN = 8
# Cells of a grid that a solve may be advised to take: their fields fill some 100 GB.
MAX_CELLS = 10**9


class Answer(InNotebook):
    """Members that every answer of :func:`~contactstudy.solve` has: numbers, bounds, a verdict on them, pictures, text.

    Attributes
    ----------
    scene
        Scene that was solved; None for a problem that was not made of one.
    requested
        Requested relative error of every number, or errors by name; None without a request.
    status
        Outcome, with cause and remedy.
    grid, padding
        Cells and boundary conditions of the fields.
    error
        Estimate of the errors by quantity and cause; computed on first access.
    quantities
        Numbers by name, with unit and bound.
    counts
        Solver statistics, as numbers with their meaning by name.
    """

    if TYPE_CHECKING:  # subclasses define these

        @property
        def scene(self) -> Scene | None: ...  # noqa: D102
        @property
        def requested(self) -> Request | None: ...  # noqa: D102
        @property
        def status(self) -> Status: ...  # noqa: D102
        @property
        def grid(self) -> Grid: ...  # noqa: D102
        @property
        def error(self) -> ErrorEstimate: ...  # noqa: D102
        @property
        def quantities(self) -> Quantities: ...  # noqa: D102
        @property
        def counts(self) -> Counts: ...  # noqa: D102

    def to_dataset(self) -> "xr.Dataset":
        """Return fields and quantities with dimensions, units, long names, bounds and the scene."""
        raise NotImplementedError

    def dataset_to_draw(self) -> "xr.Dataset":
        """Return the dataset of :meth:`to_dataset` with what a picture alone shows."""
        return self.to_dataset()

    def plot(self, dataset: "xr.Dataset | None" = None) -> "Figure":
        """Return a picture of the fields as a matplotlib figure.

        Parameters
        ----------
        dataset
            What :meth:`dataset_to_draw` returned, if at hand.
        """
        with needed_for(f"{type(self).__name__}.plot"):
            from contactstudy.io.pictures import picture_of

        figure = picture_of(self.dataset_to_draw() if dataset is None else dataset)
        if figure is None:
            raise InvalidInput("plot.dataset is not that of an answer: give what to_dataset() returned.")
        return figure

    @property
    def judged_error(self) -> tuple[str, ErrorParts]:
        """Name of the main error measure, and its bound by cause."""
        return "in L1", self.error.l1

    @cached_property
    def judged(self) -> dict[str, Judged]:
        """Numbers that the request speaks of with their bounds, by name; all without a request, or with one for all."""
        numbers = judged_numbers(self.quantities, self.requested)
        if isinstance(self.requested, Mapping) and (asked := self.requested.get(PRESSURE)) is not None:
            l1 = self.error.l1
            numbers[PRESSURE] = Judged("pressure in L1", l1.total, asked, l1.reason)
        return numbers

    @property
    def met(self) -> bool | None:
        """True if every number that has a bound, or is named, keeps the requested error; None without a request."""
        if self.requested is None:
            return None
        numbers = self.judged.values()
        if isinstance(self.requested, Mapping):
            return all(number.ratio <= 1 for number in numbers)
        return self._l1_ratio <= 1 and not self._missed

    @property
    def _missed(self) -> list[Judged]:
        """Numbers whose bound is above the request."""
        return [number for number in self.judged.values() if 1 < number.ratio < inf]

    @property
    def _l1_ratio(self) -> float:
        """Bound of the main error measure over the request for all numbers; 0 without one."""
        if self.requested is None or isinstance(self.requested, Mapping):
            return 0.0
        return self.judged_error[1].total / self.requested

    @property
    def accuracy(self) -> str:
        """Sentence on the accuracy, such as ``1 % met by every number: 0.2 % in L1, 0.7 % in the half-width``.

        Before it stands whether the bodies are too small to be half-spaces.
        """
        fault = beyond_half_space(self.scene)
        return f"{fault.rstrip('.')}; as half-spaces: {self._accuracy}" if fault else self._accuracy

    @property
    def _accuracy(self) -> str:
        """Sentence on the accuracy of the scene as it is modelled."""
        numbers = list(self.judged.values())
        measure, parts = self.judged_error
        reached = f"{per_cent(parts.total)} {measure}" if isfinite(parts.total) else f"no bound {measure}"
        bounded = [number for number in numbers if isfinite(number.bound)]
        worst = max(bounded, key=lambda number: number.bound, default=None)
        if worst is not None and worst.bound > parts.total:
            reached += f", {worst}"
        unknown = without_bound(numbers) if isfinite(parts.total) else ""
        if isinstance(self.requested, Mapping):
            asked = ", ".join(f"{number} of {100 * number.requested:g} %" for number in numbers)
            head = f"request {'met' if self.met else 'not met'}: {asked}"
        elif self.requested is None:
            head = f"error at most {reached}" if isfinite(parts.total) else reached
        else:
            if self.met:
                verdict = "met by every number with a bound" if unknown else "met by every number"
            elif self._l1_ratio > 1:
                verdict = "not met"
            else:
                count = f"{len(self._missed)} of {len(bounded)}"
                verdict = f"met {measure}, not by {count} numbers"
            head = f"{100 * self.requested:g} % {verdict}: {reached}"
        is_kept = isfinite(parts.total) if self.requested is None else self.met
        return "; ".join(filter(None, (head, "" if is_kept else self._why, unknown)))

    @property
    def _why(self) -> str:
        """Sentence on what stands in the way of the request, and what it would take."""
        parts = self.judged_error[1]
        if reason := parts.reason or self.error.l1.reason:
            return reason
        if not isfinite(parts.total):
            return next(iter(self.error.warnings), "")
        if not self._missed and self._l1_ratio <= 1:  # what is named has no bound, which says why
            return ""
        if not all(number.order for number in self._missed):
            return "finer cells hardly lessen it: the largest stress may lie between depths, give closer depths"
        factor = max(1.0, self._l1_ratio, *(number.finer for number in self._missed))
        if (cause := self._main_cause) != "discretisation" or factor <= 1:
            return f"most of it is by {REMEDIES[cause]}"
        cells = finer_grid(self.grid, factor).cells
        if prod(cells) > MAX_CELLS:
            return "no grid in reach would meet it"
        return f"about {cells_text(cells)} would meet it"

    @property
    def _main_cause(self) -> str:
        """Cause of the largest part of the main error measure."""
        parts = self.judged_error[1].by_cause
        return max(parts, key=parts.__getitem__)

    @property
    def work(self) -> str:
        """Solver statistics, in one line."""
        return ", ".join(f"{label} {value:.3g}" for value, label in self.counts.values())

    def summary(self) -> str:
        """Return accuracy, warnings, quantities with their bounds, status, extent, surfaces and work as text."""
        size = "extent {} x {}".format(*map(readable, self.grid.extent))
        lines = [f"  {line}" for line in (self.status, size, *surface_notes(self.scene), self.work)]
        if note := getattr(self, "note", ""):
            lines.append(f"  note: {note}")
        return "\n".join((self.accuracy, *self._lines_of_warnings, as_text(self.quantities), *lines))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings that are no reason in the table of quantities, first whether bodies are too small for half-spaces."""
        reasons = {"", *(quantity.reason for quantity in self.quantities.values())}
        every = beyond_half_space(self.scene), *self.error.warnings
        return tuple(warning for warning in every if warning not in reasons)

    @property
    def _lines_of_warnings(self) -> list[str]:
        """Lines with the warnings that the accuracy does not say."""
        return [f"  warning: {warning}" for warning in self.warnings if warning in self.error.warnings]

    def __repr__(self) -> str:
        """Return accuracy, up to two warnings, status and the first quantities with their bounds, in up to ten lines."""
        warnings = self._lines_of_warnings[:2]
        shown = SHOWN - len(warnings)
        counts = range(shown, 0, -1)  # a reason takes a line too: show fewer quantities until the table fits
        tables = (as_text(dict(islice(self.quantities.items(), count))) for count in counts)
        table = next((text for text in tables if text.count("\n") < shown), "")
        head = f"{type(self).__name__}: {self.accuracy}"
        return "\n".join((head, *warnings, f"  {self.status.name}, {cells_text(self.grid.cells)}", table))

    def _rows(self) -> str:
        return repr(self)

    def _repr_html_(self) -> str:
        """Return the representation, for notebooks above a small picture if there are fields and a library to draw."""
        text, file = super()._repr_html_(), BytesIO()
        if not self.quantities:  # no finite fields
            return text
        try:
            self.plot().savefig(file, format="png", dpi=60)
        except ModuleNotFoundError:
            return text
        return (
            f"{text}<img alt='fields of the answer' src='data:image/png;base64,{b64encode(file.getvalue()).decode()}'>"
        )


# Function that solves the same scene on 1 / k of the cells along each axis, and in time with steps k times as long. Its
# arguments are k, and for a film a multiple of the width.
Coarser = Callable[..., Answer]


def levels_below(coarser: Coarser) -> dict[int, Answer]:
    """Return the answers on 1 / k of the cells along each axis by k, those of `COARSER` that have a solution."""
    answers = {factor: solved_or_none(coarser, factor) for factor in errors.COARSER}
    return {factor: answer for factor, answer in answers.items() if answer is not None}


def solved_or_none(coarser: Coarser, *arguments: int) -> Answer | None:
    """Return the answer of `coarser` for its `arguments`, to compare with; None where there is no solution."""
    try:
        answer = coarser(*arguments)
    except (InvalidInput, NotDefined):
        return None
    return None if answer.status.is_failure else answer


def surface_notes(scene: Scene | None) -> list[str]:
    """Return a sentence for each measured surface of a scene, on how it was prepared."""
    shapes = scene.shapes if scene else ()
    return [
        f"shapes[{number}]: {getattr(shape, 'description', '')}"
        for number, shape in enumerate(shapes)
        if hasattr(shape, "digest")  # of measured heights
    ]
