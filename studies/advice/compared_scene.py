"""A scene whose settings are compared: its extent and own boundary conditions, its answers and their bounds."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, sqrt
from pathlib import Path

import contactstudy as cs
from contactstudy.domain.device import available_bytes
from contactstudy.domain.errors import ErrorEstimate, ErrorParts
from contactstudy.domain.fields import Array
from contactstudy.domain.identity import digest
from contactstudy.domain.reuse import caching
from contactstudy.io.quantities.contact_quantities import contact_quantities
from contactstudy.io.quantities.film_quantities import film_quantities
from contactstudy.planning.cost import memory
from contactstudy.planning.grid_requirements import grid_requirements
from contactstudy.planning.plan import MEMORY_FRACTION
from studies.advice.nested_grids import unit_of
from studies.reference.line_contact import HERTZ, SCENE, WIDTH, relative_l1

# Relative error of the coarse plan that gives extent and ratio of cells where a scene has none.
QUICK_ERROR = 0.2
# Cells and tolerance of the solutions from which the ratio of cells follows, how often it is changed at most, and the
# factor below which a change ends it.
TRIAL_CELLS, TRIAL_TOLERANCE, TRIALS, BALANCE_RATIO = 2**11, 1e-4, 4, 1.3
# Largest ratio of cells across over cells along of grids that are not balanced by solutions.
MAX_ASPECT = 16
# Factor by which a width is made larger that the contact or its attraction reaches the end of.
WIDENING, TOO_NARROW = 1.5, (cs.Status.CONTACT_AT_EDGE, cs.Status.ATTRACTION_AT_EDGE)
# Quantities whose change by a padding is reported, and what they are called.
REPORTED = {
    "peak_pressure": "peak pressure",
    "contact_area": "contact area",
    "mean_gap": "mean gap",
    "largest_von_mises": "largest von Mises stress",
    "stick_fraction": "stick fraction",
    "traction_coefficient": "traction coefficient",
    "rolling_resistance": "rolling resistance",
    "pull_off": "pull-off load",
    "central_film": "central film",
    "minimum_film": "minimum film",
    "friction_coefficient": "coefficient of friction",
}
UNBOUNDED = ErrorEstimate(ErrorParts(discretisation=inf))
Answer = cs.Contact | cs.LubricatedContact | cs.Evolution


@dataclass(frozen=True)
class Setting:
    """Way to solve a scene: padding, cells (across, along) and tolerance of the solver."""

    padding: cs.Padding | cs.Paddings
    cells: tuple[int, int]
    tolerance: float


@dataclass(frozen=True)
class ComparedScene:
    """Scene whose settings are compared, on one extent.

    Attributes
    ----------
    name
        Name for people.
    scene
        The scene, with random surfaces of the extent.
    extent
        Width and length [m] of every grid.
    boundary
        The boundary of the scene itself: all images, or free ends.
    unit
        Cells of which every grid has a multiple, see :func:`~studies.advice.nested_grids.unit_of`.
    options
        Options of a solve beside the tolerance.
    times
        Instants of a scene that changes in time; None for others.
    text
        The scene as TOML, which tells stored measurements of two scenes apart.
    notes
        A sentence for each choice.
    """

    name: str
    scene: cs.Scene
    extent: tuple[float, float]
    boundary: cs.Padding | cs.Paddings
    unit: tuple[int, int]
    options: cs.SolveOptions = field(default_factory=cs.SolveOptions)
    times: cs.TimeSteps | None = None
    text: str = ""
    notes: tuple[str, ...] = ()

    def grid(self, cells: tuple[int, int]) -> cs.Grid:
        """Return the grid with a number of cells."""
        return cs.Grid(cells, self.extent)

    def solve(self, setting: Setting) -> Answer:
        """Return the answer at a setting, posed and solved again."""
        with caching(None):
            return cs.solve(
                self.scene,
                self.grid(setting.cells),
                setting.padding,
                times=self.times,
                options=replace(self.options, tolerance=setting.tolerance),
            )

    def fits(self, cells: tuple[int, int]) -> bool:
        """Return whether this machine's memory holds a solve under the scene's own boundary conditions."""
        return memory(self.grid(cells), self.boundary) <= MEMORY_FRACTION * available_bytes()

    @property
    def is_free(self) -> bool:
        """True if the scene itself ends along its length, so that no image belongs to it."""
        return isinstance(self.boundary, tuple)

    @cached_property
    def exact(self) -> "cs.analytic.HertzLine | None":
        """Hertz's line contact where it is the exact solution: a smooth elastic cylinder under a load; else None."""
        scene = self.scene
        is_loaded = scene.adhesion is None and not isinstance(scene.load, cs.Approach)
        is_contact_alone = _is_at_rest(scene) and not scene.outputs
        if scene.hertz is None or self.is_free or not (is_contact_alone and is_loaded):
            return None
        requirements = grid_requirements(scene)
        hertz = requirements.hertz
        is_elastic = scene.hardness > hertz.peak_pressure
        fits = 2 * hertz.half_width < self.extent[0]
        return hertz if requirements.is_smooth and fits and is_elastic else None


def last_of(answer: Answer) -> cs.Contact | cs.LubricatedContact:
    """Return an answer, or the last frame under pressure of one that is an evolution."""
    if not isinstance(answer, cs.Evolution):
        return answer
    pressed = [frame for frame in answer.frames if frame.pressure.any()]
    return pressed[-1] if pressed else answer.frames[-1]


def pressure_of(answer: Answer) -> Array:
    """Return the pressure (x, y) [Pa] of an answer, at its end if it is an evolution."""
    return last_of(answer).pressure


def failure_of(answer: Answer) -> str:
    """Return a sentence on an answer that did not converge; empty if it did."""
    good = answer.status in (cs.Status.CONVERGED, cs.Status.PRECISION_LIMIT)
    return "" if good else str(answer.status)


def numbers_of(answer: Answer) -> dict[str, float]:
    """Return the numbers of an answer in SI units by name, without their bounds, which would cost further solutions."""
    last = last_of(answer)
    if isinstance(last, cs.LubricatedContact):
        table = film_quantities(last, UNBOUNDED)
    else:
        table = contact_quantities(last, UNBOUNDED, last.derived, last.rolling)
    return {name: quantity.value for name, quantity in table.items() if name in REPORTED}


def bounds_of(answer: Answer) -> dict[str, float]:
    """Return bounds on the relative errors of an answer by its cells and steps, infinite where there is none."""
    names = {"l1": "pressure_l1"}
    return {
        names.get(name, name): sum(
            part for cause, part in parts.by_cause.items() if cause not in ("images", "residual")
        )
        for name, parts in last_of(answer).error
        if name == "l1" or name in REPORTED
    }


def bound_by_cells(answer: Answer) -> float:
    """Return the bound on the relative L1 error of an answer's pressure that is not by its steps in time."""
    causes = last_of(answer).error.l1.by_cause
    return sum(
        part for cause, part in causes.items() if cause not in ("images", "residual", "steps")
    )


def time_discretisation_error_of(answer: Answer) -> float:
    """Return the bound on the relative L1 error of an answer's pressure by its steps in time, 0 without any."""
    return last_of(answer).error.l1.by_cause.get("steps", 0.0)


@dataclass(frozen=True)
class SceneText:
    """A scene as its file describes it, before any grid is chosen.

    Attributes
    ----------
    name, text
        Name for people, and the scene as TOML.
    file
        The scene with its grid, padding and settings, if it has some.
    """

    name: str
    text: str
    file: cs.SceneFile

    @property
    def key(self) -> str:
        """Text that is equal for equal scenes alone."""
        file = self.file
        solved = file.scene, file.grid, file.padding, file.options, file.time_steps
        return digest((*solved, file.plan_settings.period))

    def subject(self, error: float = QUICK_ERROR) -> "ComparedScene":
        """Return the scene on its extent, for a relative error; one below 0.2 gives the extent that 0.2 gives."""
        return compared_scene(self.file, self.name, self.text, error)


def scene_in(path: Path) -> SceneText:
    """Return the scene in a TOML file."""
    described = cs.read_scene(path)  # raises InvalidInput for an invalid file
    return SceneText(path.stem, path.read_text(encoding="utf-8"), described)


def paper_scene(period: float = WIDTH) -> SceneText:
    """Return the paper's steel cylinder, with a period in half-widths."""
    a = HERTZ.half_width
    file = cs.SceneFile(SCENE, grid=cs.Grid((128, 128), (WIDTH * a, period * a)))
    return SceneText("the paper's cylinder", f"# the paper's cylinder, L = {period:g} a\n", file)


def compared_scene(
    described: cs.SceneFile, name: str, text: str = "", error: float = QUICK_ERROR
) -> ComparedScene:
    """Return the scene of a file as a subject.

    Parameters
    ----------
    described
        The scene with its grid, padding and settings, if it has some.
    name
        Name for people.
    text
        The scene as TOML.
    error
        Error that is requested; a quick grid is planned for it, or for 0.2.

    Raises
    ------
    InvalidInput
        If the scene has neither a width of its own nor a grid, searches its pull-off load, attracts at short range, or
        repeats across.
    """
    scene = described.scene
    if isinstance(scene.load, cs.PullOff):
        raise cs.InvalidInput(
            f"{name} searches the pull-off load, by many solves a setting: give it a load per length to compare "
            "paddings and grids."
        )
    if scene.adhesion is not None and scene.adhesion.range is None:
        raise cs.InvalidInput(
            f"{name} has an attraction of short range, which every grid replaces by a range of its own, so that grids "
            "solve different contacts: give [adhesion] a range to compare them."
        )
    repeats_across = isinstance(described.padding, tuple) and described.padding[0].wraps
    if scene.hertz is not None and repeats_across:
        raise cs.InvalidInput(
            f"{name} repeats across the contact, and the settings that are compared do not: leave out padding_across."
        )
    at_rest = _is_at_rest(scene)
    notes = []
    padding = described.padding or cs.ExactPeriodicity()
    if described.grid is not None:
        grid = described.grid
    elif scene.hertz is None:
        raise cs.InvalidInput(
            f"{name} has no curved shape, so that it has no width of its own: give it a [grid]."
        )
    elif at_rest:
        period = described.plan_settings.period
        grid = grid_requirements(scene).grid(max(error, QUICK_ERROR), period)
    else:
        grid = described.plan().grid
    if scene.hertz is not None:
        requirements = grid_requirements(scene)
        padding = requirements.padding()
        if check := requirements.period_check(grid.length):
            notes.append(check)
    elif not isinstance(padding, tuple):
        padding = cs.ExactPeriodicity()
    shapes = tuple(
        replace(shape, extent=grid.extent)
        if isinstance(shape, cs.Roughness) and shape.extent is None
        else shape
        for shape in scene.shapes
    )
    subject = ComparedScene(
        name,
        replace(scene, shapes=shapes),
        grid.extent,
        padding,
        unit_of(_with_limited_aspect(grid.cells)),
        described.options,
        described.time_steps if scene.takes_times else None,
        text,
        tuple(notes),
    )
    is_balanced = described.grid is None and at_rest
    return with_balanced_cells(subject, grid.cells) if is_balanced else subject


def _with_limited_aspect(cells: tuple[int, int]) -> tuple[int, int]:
    """Return cells with at most `MAX_ASPECT` times as many across as along, so that the coarsest grids are quick."""
    across, along = cells
    return (min(across, MAX_ASPECT * along) if along > 1 else across), along


def _is_at_rest(scene: cs.Scene) -> bool:
    """Return whether a scene is a dry contact that neither rolls nor changes in time."""
    return scene.lubrication is None and not scene.rolls and scene.time_dependent_field is None


def with_balanced_cells(subject: ComparedScene, cells: tuple[int, int]) -> ComparedScene:
    """Return the scene on an extent that holds the contact, with cells that add equally to the error along each axis.

    Two solutions on some thousand cells, each with twice the cells along one axis, give the contributions.
    """
    ratio = cells[0] / cells[1]
    if cells[1] == 1:
        return subject
    for _ in range(TRIALS):
        along = max(4, round(sqrt(TRIAL_CELLS / ratio)))
        trial = max(4, round(ratio * along)), along
        answers = [
            subject.solve(Setting(subject.boundary, tried, TRIAL_TOLERANCE))
            for tried in (trial, (2 * trial[0], trial[1]), (trial[0], 2 * trial[1]))
        ]
        widest = grid_requirements(subject.scene).known_width
        width = min(WIDENING * subject.extent[0], widest)
        if answers[0].status in TOO_NARROW and width > subject.extent[0]:
            subject = replace(subject, extent=(width, subject.extent[1]))
            continue
        pressure, finer_across, finer_along = map(pressure_of, answers)
        gain = relative_l1(pressure, finer_across) / (relative_l1(pressure, finer_along) or 1.0)
        factor = min(max(gain**0.8, 1 / 4), 4.0)
        ratio *= factor
        if 1 / BALANCE_RATIO < factor < BALANCE_RATIO:
            break
    return replace(subject, unit=unit_of((round(1000 * ratio), 1000)))
