"""What every answer has: status, grid, error, quantities, and the ways to read them."""

from base64 import b64encode
from collections.abc import Callable, Mapping
from functools import cached_property
from io import BytesIO
from itertools import islice
from math import inf, isfinite, prod
from typing import TYPE_CHECKING

from contactstudy.accuracy.error_terms import IMAGES_REMEDY
from contactstudy.accuracy.plausibility import beyond_half_space
from contactstudy.answers.judgement import Judged, finer_grid, judged_numbers, without_bound
from contactstudy.domain.errors import COARSER, PRESSURE, ErrorEstimate, ErrorParts, InNotebook, Request
from contactstudy.domain.grid import Grid, Padding, Paddings, cells_text
from contactstudy.domain.imports import needed_for
from contactstudy.domain.validation import InvalidInput, NotDefined, readable
from contactstudy.io.quantities.quantity import Quantities, as_text, per_cent
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Counts, Status

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

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
    """Members that every answer of :func:`~contactstudy.solve` has.

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
        def padding(self) -> Padding | Paddings | None: ...  # noqa: D102
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
            from contactstudy.io.pictures.picture import picture_of

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
        """Numbers whose bound is above the request, the worst first."""
        missed = (number for number in self.judged.values() if 1 < number.ratio < inf)
        return sorted(missed, key=lambda number: -number.ratio)

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
            return "; ".join(filter(None, (head, unknown or (self._why if parts.total == inf else ""))))
        else:
            if self.met:
                verdict = "met by every number with a bound" if unknown else "met by every number"
            elif self._l1_ratio > 1:
                verdict = "not met"
            else:
                count = f"{len(self._missed)} of {len(bounded)}"
                verdict = f"met {measure}, not by {count} numbers"
            head = f"{100 * self.requested:g} % {verdict}: {reached}"
        return "; ".join(filter(None, (head, "" if self.met else self._why, unknown)))

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
        factor = max((number.finer for number in self._missed), default=1.0)
        factor = max(factor, self._l1_ratio)
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
        """Return the representation above a small picture, for notebooks."""
        return super()._repr_html_() + _image(self)


# Function of a factor k that solves the same scene on 1 / k of the cells along each axis, in time with steps k times as
# long; a film also over a multiple of the width.
Coarser = Callable[..., Answer]


def levels_below(coarser: Coarser) -> dict[int, Answer]:
    """Return the answers on 1 / k of the cells along each axis by k, those of `COARSER` that have a solution."""
    answers = {factor: solved_or_none(coarser, factor) for factor in COARSER}
    return {factor: answer for factor, answer in answers.items() if answer is not None}


def solved_or_none(coarser: Coarser, *arguments: int) -> Answer | None:
    """Return an answer to compare with; None where there is no solution."""
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


def _image(answer: Answer) -> str:
    """Return a picture of an answer for HTML; empty without finite fields, or without a library that draws."""
    if not answer.quantities:
        return ""
    file = BytesIO()
    try:
        answer.plot().savefig(file, format="png", dpi=60)
    except ModuleNotFoundError:
        return ""
    data = b64encode(file.getvalue()).decode()
    return f"<img alt='fields of the answer' src='data:image/png;base64,{data}'>"
