"""A study from a scene and the fields of it that are varied."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from os import PathLike
from pathlib import Path

from contactstudy import InvalidInput, Scene
from contactstudy.io.scene_file import SceneFile, read_scene, scene_file_of
from contactstudy.io.scene_writer import scene_text
from studies.model.axis import Value, check_count
from studies.model.study import Point, Study
from studies.scene_study.fields import document_of
from studies.scene_study.grids import Posed, posed
from studies.scene_study.measures import measures
from studies.scene_study.scene_case import SceneCase
from studies.scene_study.variation import Variation, variation

ORDER = ("file", "window", "turn")  # what makes a surface comes before what is done with it
MOST = 100_000


def study_of(
    scene: Scene | SceneFile | str | PathLike[str],
    vary: Mapping[str, object],
    *,
    name: str | None = None,
    folder: str | PathLike[str] | None = None,
) -> Study:
    """A :class:`~studies.model.study.Study` of ``scene`` over the values of its fields in ``vary``.

    ``scene`` is a scene, what :func:`~contactstudy.read_scene` reads, or the path of a file. Keys of
    ``vary`` are paths in a scene file, such as ``load.per_length``, ``shapes.1.rms`` or ``padding``; ``surfaces``
    and ``windows`` vary the measured surface of the scene. Values are a sequence, or a text as on the
    command line. The load is the last axis, so that neighbours on it are solved one after the other.
    Raises :class:`~contactstudy.InvalidInput` for a field that is not there and values that it cannot have.
    """
    described, found = _read(scene)
    folder = Path(folder) if folder is not None else found
    if not vary:
        raise InvalidInput(
            'vary is empty: give a field and its values, such as {"load.per_length": "50 N/mm,100 N/mm"}.'
        )
    axes = [variation(described, field, values, folder) for field, values in vary.items()]
    names = [one.axis.name for one in axes]
    for axis in names:
        if names.count(axis) > 1:
            raise InvalidInput(f"{axis} is varied twice: write all its values in one list.")
    axes.sort(key=lambda one: one.is_load)
    count = 1
    for one in axes:
        count *= len(one.values)
    check_count("vary", count, "points", MOST)
    points = list(product(*(one.values for one in axes)))
    placed, notes = posed([_file_at(described, axes, point) for point in points])
    cases = {
        point: _case(one, described_at)
        for point, one, described_at in zip(
            points, placed, (_file_at(described, axes, p) for p in points), strict=True
        )
    }
    if name is None:
        name = Path(scene).stem if isinstance(scene, str | PathLike) else "scene"
    title = f"{name}: {', '.join(one.axis.long_name for one in axes)}"
    return Study(
        name, title, tuple(one.axis for one in axes), _SceneAt(tuple(names_of(axes)), cases),
        measures, times="none", notes=notes, attributes={"scene": _text(scene, described)},
    )  # fmt: skip


def _text(scene: object, described: SceneFile) -> str:
    """The scene as TOML, as its file has it."""
    if isinstance(scene, str | PathLike):
        return Path(scene).read_text(encoding="utf-8")
    try:
        return scene_text(described.scene)
    except InvalidInput as error:  # a shape or a body that is not of the core
        return f"# {error}\n# {described.scene!r}\n"


def names_of(axes: list[Variation]) -> list[str]:
    """The names of the axes."""
    return [one.axis.name for one in axes]


@dataclass(frozen=True, eq=False)
class _SceneAt:
    """The case at every point."""

    names: tuple[str, ...]
    cases: Mapping[tuple[Value, ...], SceneCase]

    def __call__(self, point: Point) -> SceneCase:
        values = tuple(point[name] for name in self.names)
        if values not in self.cases:
            raise InvalidInput(
                f"The point {dict(point)!r} is not one of the study: give its values when the study is made."
            )
        return self.cases[values]


def _read(scene: Scene | SceneFile | str | PathLike[str]) -> tuple[SceneFile, Path]:
    if isinstance(scene, Scene):
        return SceneFile(scene), Path()
    if isinstance(scene, SceneFile):
        return scene, Path()
    if isinstance(scene, str | PathLike):
        return read_scene(scene), Path(scene).parent
    raise InvalidInput(
        f"scene is {scene!r}: give a Scene, a SceneFile or the path of a scene file."
    )


def _file_at(described: SceneFile, axes: list[Variation], point: tuple[Value, ...]) -> SceneFile:
    """What the file says at a point."""
    document = document_of(described)
    for one, value in sorted(zip(axes, point, strict=True), key=lambda pair: _rank(pair[0])):
        document = one.apply(document, value)
    return scene_file_of(document)


def _rank(one: Variation) -> int:
    last = one.field.path[-1]
    return ORDER.index(last) if last in ORDER else len(ORDER)


def _case(one: Posed, described: SceneFile) -> SceneCase:
    solve = described.settings
    return SceneCase(
        one.scene,
        one.grid,
        one.padding,
        tolerance=solve.tolerance,
        max_iterations=solve.max_iterations,
        solver=solve.solver,
        precision=solve.precision,
    )
