"""What every answer has: status, grid, error, quantities, and the ways to read them."""

from base64 import b64encode
from collections.abc import Mapping
from html import escape
from io import BytesIO
from itertools import islice
from math import isfinite
from typing import TYPE_CHECKING

from contactstudy.accuracy.image_errors import IMAGES_REMEDY
from contactstudy.domain.errors import ErrorEstimate, ErrorParts
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.domain.units import readable
from contactstudy.io.quantities.quantity import Quantities, as_text
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Status

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
# Quantities in a representation, which has ten lines with the accuracy and the status.
SHOWN = 8


# Numbers of a solver with their meaning, by name.
Counts = Mapping[str, tuple[float, str]]


class Answer:
    """Members that every answer of :func:`~contactstudy.solve` has.

    Attributes
    ----------
    requested
        Requested relative error; None without a request.
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

    if TYPE_CHECKING:

        @property
        def requested(self) -> float | None: ...  # noqa: D102
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

    def plot(self, dataset: "xr.Dataset | None" = None) -> "Figure":
        """Return a picture of the fields, of the `dataset` from :meth:`to_dataset` if it is given."""
        raise NotImplementedError

    @property
    def judged_error(self) -> tuple[str, ErrorParts]:
        """Name of the error measure of the requested accuracy, and its bound by cause."""
        return "in L1", self.error.l1

    @property
    def met(self) -> bool | None:
        """True if the bound meets the requested accuracy; None without a request."""
        if self.requested is None:
            return None
        return self.judged_error[1].total <= self.requested

    @property
    def accuracy(self) -> str:
        """Sentence on the accuracy, such as ``1 % met: 0.7 % in L1``."""
        measure, parts = self.judged_error
        bound = parts.total
        reached = f"{100 * bound:.2g} % {measure}" if isfinite(bound) else f"no bound {measure}"
        if self.requested is None:
            return f"error at most {reached}" if isfinite(bound) else reached
        why = "" if self.met else parts.reason or self.error.l1.reason
        if not (why or isfinite(bound)):
            why = next(iter(self.error.warnings), "")
        elif not (why or self.met):
            cause = max(parts.by_cause, key=parts.by_cause.__getitem__)
            why = f"most of it is by {REMEDIES[cause]}"
        verdict = "met" if self.met else "not met"
        return f"{100 * self.requested:g} % {verdict}: {reached}{f'; {why}' * bool(why)}"

    @property
    def work(self) -> str:
        """Solver statistics, in one line."""
        return ", ".join(f"{label} {value:.3g}" for value, label in self.counts.values())

    def summary(self) -> str:
        """Return accuracy, warnings, quantities with their bounds, status, extent, surfaces and work as text."""
        size = "  extent {} x {}".format(*map(readable, self.grid.extent))
        warnings = (f"  warning: {warning}" for warning in self.error.warnings)
        surfaces = (f"  {note}" for note in surface_notes(getattr(self, "scene", None)))
        status = f"  {self.status}"
        return "\n".join(
            (self.accuracy, *warnings, as_text(self.quantities), status, size, *surfaces, f"  {self.work}")
        )  # fmt: skip

    def __repr__(self) -> str:
        """Return accuracy, status and the first quantities with their bounds, in at most ten lines."""
        shown = dict(islice(self.quantities.items(), SHOWN))
        cells = " x ".join(map(str, self.grid.cells))
        head = f"{type(self).__name__}: {self.accuracy}"
        return f"{head}\n  {self.status.name}, {cells} cells\n{as_text(shown)}"

    def _repr_html_(self) -> str:
        """Return the representation beside a small picture, for notebooks."""
        return f"<pre>{escape(repr(self))}</pre>{_image(self)}"


def surface_notes(scene: Scene | None) -> list[str]:
    """Return a sentence for each measured surface of a scene, on how it was prepared."""
    shapes = scene.shapes if scene else ()
    return [
        f"shapes[{number}]: {getattr(shape, 'description', '')}"
        for number, shape in enumerate(shapes)
        if hasattr(shape, "digest")
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
