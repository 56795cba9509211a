"""A study of a scene: its fields that vary, its cases, and the grids that they share."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from os import PathLike
from pathlib import Path

import contactstudy as cs
from contactstudy import InvalidInput, MeasuredSurface, Roughness, Scene
from contactstudy.answers.answer import surface_notes
from contactstudy.domain.device import available_bytes
from contactstudy.domain.errors import DEFAULT_ERROR, PRESSURE
from contactstudy.domain.grid import Padding, Paddings, cells_text
from contactstudy.domain.validation import readable, whole_quotient
from contactstudy.io.scene_files.structuring import scene_text
from contactstudy.planning.grid_requirements import (
    grid_requirements,
    halvable_count,
    measured_length_scales,
    with_random_extents,
)
from contactstudy.planning.planned import MEMORY_FRACTION, memory
from contactstudy.scene.shapes.shape import length_scales_of
from contactstudy.scene_file import SceneFile, tables_of
from studies.model.axis import Axis, Value
from studies.model.case import Case, Computation
from studies.model.plain_text import counted
from studies.model.study import Point, Study
from studies.scene_study.document import Table, tables, varied_scenes, with_other_values
from studies.scene_study.measures import measures

# Number of points that are all planned. Of more, every n-th by width is, and the widest: up to 13 in all. The same of
# scenes that change in time, whose plans solve some contacts: up to 4.
MAX_PLANNED, MAX_PLANNED_IN_TIME = 8, 3
DIFFERENT_SURFACES = (
    "random surfaces differ between grids, because the shortest of their periods does not divide all: give "
    "Roughness an extent whose length divides all periods for one surface"
)


def on_shared_grids(points: Sequence[SceneFile]) -> tuple[list[Case], tuple[str, ...]]:
    """Return every point on its grid, and notes on the grids.

    Points with the same grid and plan settings in their file share a grid, with the width of the widest and the
    cells of the finest; rollers of other lengths have their own. Random surfaces without an extent get the largest
    width and the shortest period, so that each is the same surface at all points.

    Raises
    ------
    InvalidInput
        If a surface does not fit its grid.
    """
    points, notes = _with_random_extents(points)
    groups: dict[object, list[int]] = {}
    for number, point in enumerate(points):
        settings = point.plan_settings if point.grid is None else None
        # each roller of its own length is planned alone, but for one random surface on all
        is_random = any(isinstance(shape, Roughness) for shape in point.scene.shapes)
        length = None if is_random else point.scene.roller_length
        groups.setdefault((settings, point.grid, length), []).append(number)
    grids: dict[int, cs.Grid] = {}
    for numbers in groups.values():
        chosen, about = _shared([points[number] for number in numbers])
        grids.update(zip(numbers, chosen, strict=True))
        notes += about
    extent = _common_extent([grid.extent for grid in grids.values()])
    shapes = [shape for point in points for shape in point.scene.shapes]
    if any(isinstance(shape, Roughness) and shape.extent is None for shape in shapes):
        notes.append(DIFFERENT_SURFACES if extent is None else _extent_note(extent))
    placed = [_case_on(point, grids[number], extent) for number, point in enumerate(points)]
    _check(placed)
    return placed, tuple(dict.fromkeys(notes))


def _with_random_extents(points: Sequence[SceneFile]) -> tuple[Sequence[SceneFile], list[str]]:
    """Return `points` whose random surfaces have one extent, that of the widest plan, if all can; and a note on it."""
    is_planned = all(
        point.grid is None and point.scene.lubrication is None and point.scene.hertz is not None for point in points
    )
    shapes = [shape for point in points for shape in point.scene.shapes]
    if not is_planned or not any(scales.longest_across for scales in length_scales_of(shapes)):
        return points, []
    extent = _common_extent([grid_requirements(point.scene).extent(point.plan_settings.period) for point in points])
    if extent is None:
        return points, []
    placed = [replace(point, scene=with_random_extents(point.scene, extent)) for point in points]
    return placed, [_extent_note(extent)]


def _case_on(point: SceneFile, grid: cs.Grid, extent: tuple[float, float] | None) -> Case:
    """Return one point on its grid, with random surfaces of the common extent.

    Where the file gives its grid and no error, none is requested, and each step goes from one instant to the next.
    """
    scene = with_random_extents(point.scene, extent) if extent else point.scene
    padding = point.padding or grid_requirements(scene).padding()
    steps = point.time_steps if scene.method.takes_times else None
    error = point.plan_settings.error or (DEFAULT_ERROR if point.grid is None else None)
    return Case(scene, grid, padding, point.options, steps, error)


def _check(cases: Sequence[Case]) -> None:
    """Raise InvalidInput if the grid of a case cannot hold a surface that has a size."""
    kinds = Roughness, MeasuredSurface
    pairs = [(shape, case.grid) for case in cases for shape in case.scene.shapes if isinstance(shape, kinds)]
    for shape, grid in dict.fromkeys(pairs):
        if isinstance(shape, MeasuredSurface):
            nx, ny = grid.cells
            shape.gap(grid if shape.extent is None else replace(grid, cells=(min(nx, 4), min(ny, 4))))
        elif shape.extent is not None and shape.rms:
            whole_quotient("Roughness.extent[1]", shape.extent[1], grid.length)


def _shared(points: Sequence[SceneFile]) -> tuple[list[cs.Grid], list[str]]:
    """Return the grid of each point, and notes on them: one grid for all where one suits all.

    The points have the same grid and plan settings in their file.
    """
    first = points[0]
    if first.grid is not None:
        note = f"grid {_size_text(first.grid)}, given, for {counted(len(points), 'point')}"
        return [first.grid] * len(points), [note]
    if any(point.scene.hertz is None for point in points):
        return [_planned_grid(point) for point in points], ["each measured surface is solved on its own points"]
    if any(point.scene.lubrication is not None for point in points):
        note = "each film has its own grid, because inlet length and cell size depend on the film thickness"
        return [_planned_grid(point) for point in points], [note]
    requirements = [grid_requirements(point.scene) for point in points]
    by_width = sorted(range(len(points)), key=lambda number: requirements[number].half_width)
    most = MAX_PLANNED_IN_TIME if any(point.scene.method.takes_times for point in points) else MAX_PLANNED
    step = 1 if len(points) <= most else len(points) // (most - 1)
    planned = [_planned_grid(points[number]) for number in dict.fromkeys([*by_width[::step], by_width[-1]])]
    width = max(grid.extent[0] for grid in planned)
    periods = {grid.length for grid in planned}
    measured = [
        shape for point in points for shape in point.scene.shapes
        if isinstance(shape, MeasuredSurface) and shape.extent is not None
    ]  # fmt: skip
    notes = []
    narrowest = min((shape.extent[0] for shape in measured if shape.extent), default=width)
    if narrowest < width:
        notes.append(
            f"the contact may become {readable(width)} wide, but a measured surface is {readable(narrowest)} wide, "
            "so the grid has that width; a contact that reaches its edge has the status CONTACT_AT_EDGE"
        )
        width = narrowest
    # a grid covers the middle of a longer measured surface
    period = min(periods) if measured else max(periods)
    is_common = len(periods) == 1 or measured
    if not is_common and any(requirement.period_fault(period) for requirement in requirements):
        separate = f"no common period for {counted(len(points), 'point')}: each has its own grid"
        return [_planned_grid(point) for point in points], [separate, *notes]
    across = halvable_count(width / min(grid.cell_size[0] for grid in planned))
    varying = [grid for grid in planned if grid.cells[1] > 1]
    along = max((halvable_count(period / grid.cell_size[1]) for grid in varying), default=1)
    finest = cs.Grid((across, along), (width, period))
    padding = first.padding or requirements[0].padding()
    grid = within_memory(finest, padding, MEMORY_FRACTION * available_bytes())
    if grid != finest:
        notes.append(
            f"the common grid would need {across} x {along} cells and {memory(finest, padding) / 1e9:.3g} GB, and "
            f"this machine has {available_bytes() / 1e9:.3g} GB: it is the finest that fits; give "
            "fewer values, a larger plan.error, or a grid"
        )
    shared = f"grid {_size_text(grid)}, planned once for {counted(len(points), 'point')}"
    return [grid] * len(points), [shared, *notes]


def within_memory(grid: cs.Grid, padding: Padding | Paddings, bytes_at_most: float) -> cs.Grid:
    """Return `grid`, or the finest of the same extent and aspect ratio whose solve holds within `bytes_at_most`."""
    needed = memory(grid, padding)
    while needed > bytes_at_most and max(grid.cells) > 2:
        shrink = (bytes_at_most / needed) ** (1 if grid.cells[1] == 1 else 0.5) * 0.99
        across, along = (max(2, int(count * shrink)) for count in grid.cells)
        grid = cs.Grid((across, along if grid.cells[1] > 1 else 1), grid.extent)
        needed = memory(grid, padding)
    return grid


def _planned_grid(point: SceneFile) -> cs.Grid:
    """Return the grid that is planned for a point: for its pressure, where its file names no numbers."""
    settings = point.plan_settings
    error = settings.error
    if error is None and measured_length_scales(point.scene) is None:
        error = DEFAULT_ERROR
    if isinstance(error, float):
        error = {PRESSURE: error}
    return replace(point, plan_settings=replace(settings, error=error)).plan().grid


def _common_extent(extents: Sequence[tuple[float, float]]) -> tuple[float, float] | None:
    """Return the largest width and the shortest period [m] of some extents; None unless that period divides all."""
    width, period = max(width for width, _ in extents), min(length for _, length in extents)
    divides = all(abs(length / period - round(length / period)) <= 1e-9 for _, length in extents)
    return (width, period) if divides else None


def _extent_note(extent: tuple[float, float]) -> str:
    """Return the extent of random surfaces in words."""
    size = " x ".join(map(readable, extent))
    return f"random surfaces have the extent {size} at all points"


def _size_text(grid: cs.Grid) -> str:
    """Return the cells and the extent of a grid in words."""
    return f"{cells_text(grid.cells)} over {readable(grid.extent[0])} x {readable(grid.extent[1])}"


def study_of(
    scene: Scene | SceneFile | str | PathLike[str],
    vary: Mapping[str, object] | Sequence[Mapping[str, object]] | None = None,
    *,
    name: str | None = None,
    folder: str | PathLike[str] | None = None,
) -> Study:
    """Return the :class:`~studies.model.study.Study` of a scene over other values of its fields.

    The load is the last axis. Random surfaces and the grid are the same at all points where they can be.

    Parameters
    ----------
    scene
        A scene, what :func:`~contactstudy.read_scene` reads, or the path of a file.
    vary
        Values by the paths of fields in a scene file, such as ``load.per_length``, ``shapes.1.rms`` or ``padding``;
        ``surfaces`` and ``tiles`` vary the measured surface of the scene. Values are a sequence, or a text as on the
        command line. Other fields that the file varies keep the values that it gives them. In a sequence of mappings,
        which stands for all that varies, the fields of one mapping change together.
    name
        Name of the study; if None, that of the file with "-sweep", or "scene" for one that is in no file.
    folder
        Folder that relative paths of surface files start from; if None, that of the scene file.

    Raises
    ------
    InvalidInput
        For a field that the scene lacks and values that it cannot have, and where nothing varies.
    """
    raw, own_keys, text, source = read_tables(scene)
    groups = list(vary) if isinstance(vary, Sequence) else with_other_values(raw, own_keys, vary or {}, source)
    if not any(groups):
        raise InvalidInput(
            f'{source} has nothing to vary: give a field and its values, such as load.per_length = "50 N/mm,100 N/mm", '
            "in a table [vary] of the file, with --vary or with vary; contactstudy solve takes a scene as it is."
        )
    axes, points, together = varied_scenes(raw, groups, Path(folder or Path(source).parent), source)
    files = list(points.values())
    placed, notes = on_shared_grids(files)
    cases = dict(zip(points, placed, strict=True))
    digests = {
        tuple(shape.digest for shape in file.scene.shapes if isinstance(shape, MeasuredSurface)) for file in files
    }
    surfaces = surface_notes(files[0].scene) if len(digests) == 1 else []
    # not the name of the scene, which contactstudy solve gives to its file
    name = name or (f"{Path(source).stem}-sweep" if isinstance(scene, str | PathLike) else source)
    return Study(
        name,
        f"{name}: {', '.join(axis.long_name for axis in axes)}",
        axes,
        partial(case_at, [axis.name for axis in axes], cases),
        measures,
        times="none",
        notes=(*notes, *surfaces, *together),
        attributes={
            "scene": f"# {', '.join(path for group in groups for path in group)} vary along the axes; here they have "
            f"the values of the scene that is varied.\n{text}"
        },
    )


def axes_of(path: Path, vary: Mapping[str, object] | None = None) -> tuple[Axis, ...]:
    """Return the axes of what a scene file varies, or of `vary` alone, without planning any grid."""
    raw, groups, _, source = read_tables(path)
    return varied_scenes(raw, groups if vary is None else [vary], path.parent, source)[0]


def case_at(names: Sequence[str], cases: Mapping[tuple[Value, ...], Computation], point: Point) -> Computation:
    """Return the case at a point of the axes with these names; raise InvalidInput for one that the study lacks."""
    values = tuple(point[name] for name in names)
    if values not in cases:
        raise InvalidInput(f"{dict(point)!r} is not a point of the study: give its values when the study is made.")
    return cases[values]


def read_tables(
    scene: Scene | SceneFile | str | PathLike[str],
) -> tuple[Table, Sequence[Mapping[str, object]], str, str]:
    """Return the tables of a scene, the fields and values that it varies, its text, and its path, or "scene".

    The text of a scene with a shape or a body from outside the core is its ``repr``, as a comment.
    """
    if isinstance(scene, str | PathLike):
        raw, groups = tables_of(Path(scene))
        return raw, groups, Path(scene).read_text(encoding="utf-8"), str(scene)
    if not isinstance(scene, Scene | SceneFile):
        raise InvalidInput(f"scene is {scene!r}: give a Scene, a SceneFile or the path of a scene file.")
    described = SceneFile(scene) if isinstance(scene, Scene) else scene
    try:
        text = scene_text(described.scene)
    except InvalidInput as error:  # a shape or a body that is not of the core
        text = f"# {error}\n# {described.scene!r}\n"
    return tables(described), described.vary, text, "scene"
