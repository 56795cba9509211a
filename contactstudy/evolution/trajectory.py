"""What an integration of a dry contact in time leaves: frames at recorded instants, and a checkpoint of it on disk.

A frame is the contact at one instant with what it keeps from earlier ones; a :class:`Trajectory` is the sequence of
frames. A :class:`Checkpoint` is a folder from which an integration that was stopped goes on.
"""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, get_origin
from zipfile import BadZipFile

import numpy as np

from contactstudy.domain.errors import ErrorEstimate
from contactstudy.domain.files import digest, locked, read_verified, remove_partial_files, write_with_checksum
from contactstudy.domain.grid import Array
from contactstudy.domain.imports import VERSION, import_for, source_hash
from contactstudy.domain.validation import InvalidInput
from contactstudy.evolution.steady_rolling import SteadyRolling
from contactstudy.problem.problem import Field, Problem
from contactstudy.scene.scene import PosedScene
from contactstudy.solvers.solution import Counts, Solution

if TYPE_CHECKING:
    from contactstudy.evolution.states.plastic import PlasticState

NO_BOUND_OF_STATES = "No bound: this error is not estimated in a contact that has crept, worn or yielded."


@dataclass(frozen=True, eq=False, kw_only=True)
class Frame(Solution):
    """A contact at one recorded instant: its :class:`~contactstudy.Solution`, and what it keeps from earlier instants.

    Solves, iterations and convolutions are counted since the previous frame, and include rejected steps and the
    integration with doubled steps. The status is the worst one of the contacts since the previous frame, without those
    of rejected or halved steps and of replaced iterates; it is DETACHED where the last contact is. The displacement is
    all by which the surfaces have moved: elastically, by creep, wear and yielding. Errors are relative L1 errors of the
    pressure, infinite where there is no estimate; where bodies yield, relative to the pressure under the largest load.

    Attributes
    ----------
    time
        Time [s].
    load
        Load [N/m].
    fields
        Fields (x, y) of the state variables, such as the wear depth, by name.
    solves
        Number of contacts solved, of which a step may take several; contact and plastic strain together count as one.
    errors_by_steps
        Estimated time-discretisation errors by name: ``l1`` of the pressure, or of the tangential traction where that of
        fretting is larger, the peak pressure, and further quantities of a contact that has worn while it rolls. An
        error that is not named is 0.
    coupled_state
        State solved for together with the pressure, such as plastic strain, as arrays by name.
    estimate
        Estimated errors of a contact that keeps a state from earlier instants, with those by the steps; None for others,
        whose errors are those of a contact at rest.
    rolling
        Rolling resistance and centroid of a steadily rolling contact; None for others.
    """

    time: float
    load: float
    fields: Mapping[str, Field] = field(default_factory=dict)
    solves: int = 1
    errors_by_steps: Mapping[str, float] = field(default_factory=dict)
    coupled_state: Mapping[str, Array] = field(default_factory=dict)
    estimate: ErrorEstimate | None = None
    rolling: SteadyRolling | None = None


def frame_of(solution: Solution, **further_fields: Any) -> Frame:
    """Return `solution` as a frame, with `further_fields` of :class:`Frame`, or others in place of its own."""
    values = {each.name: getattr(solution, each.name) for each in fields(Solution)}
    return Frame(**values | further_fields)


# Work of a dry scene in time, with its meaning in words.
WORK = {
    "solves": "contact solves",
    "iterations": "solver iterations of all steps",
    "convolutions": "FFT convolutions of the full grid",
    "rejected": "rejected pairs of steps and load jumps",
    "restarts": "restarts with shorter steps",
}


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Frames of a dry scene that was followed through time.

    Attributes
    ----------
    frames
        The recorded instants, in the order of time.
    work
        Work of all steps by the names in `WORK`: a load jump that was repeated with more increments counts as rejected,
        and a restart is one because the time-discretisation error grew beyond the allowed one.
    description
        The scene, grid and padding.
    coupled
        State variable that derives fields from the frames' coupled states; None if no body yields.
    """

    frames: tuple[Frame, ...]
    work: Mapping[str, int]
    description: PosedScene
    coupled: "PlasticState | None" = None

    @property
    def times(self) -> Array:
        """Time (time,) [s] of each frame."""
        return np.array([frame.time for frame in self.frames])

    @property
    def counts(self) -> Counts:
        """Number of instants, and of what the integration took."""
        work = {name: (self.work.get(name, 0), meaning) for name, meaning in WORK.items()}
        return {"instants": (len(self.frames), "instants recorded")} | work


def error_of_peak(pressure: Array, errors: Array) -> float:
    """Return the error [Pa] of the peak of a `pressure` (x, y) [Pa] whose cells have these `errors` [Pa], at least 0.

    It is as far as the peak moves where each cell has its error: cells at the edge of a contact that wears have large
    errors, and pressures far below the peak. As the error of a cell may vanish by chance, it is at least the relative
    mean error times the peak, or the largest error where that is less.
    """
    peak, total = float(pressure.max()), float(pressure.sum())
    moved = max(float((pressure + errors).max()) - peak, peak - float((pressure - errors).max()))
    mean = float(errors.sum()) / total * peak if total else 0.0
    return max(moved, min(mean, float(errors.max())))


T = TypeVar("T")
# Key in JSON of the name of an array, which is stored beside it.
ARRAY = "array"


@dataclass(frozen=True)
class Checkpoint:
    """Folder of one integration, in which values are kept: made by :meth:`open`.

    Beside ``request.json``, which says of what integration the folder is, each value has a file, such as
    ``frame_00000.npz``. Each file has a checksum and is replaced in one step, so that a killed integration leaves the
    previous one and damage is detected.

    Attributes
    ----------
    folder
        The folder.
    request_hash
        Hash of the request and of this program, which every file names.
    """

    folder: Path
    request_hash: str

    @classmethod
    @contextmanager
    def open(cls, folder: Path, request: object) -> "Iterator[Checkpoint]":
        """Make the folder of an integration, or check that it is of this one, and lock it as long as the block lasts.

        Parameters
        ----------
        folder
            The folder; it need not exist.
        request
            Scene, grid and options that identify the integration.

        Raises
        ------
        InvalidInput
            If the folder holds another integration, one of another version of this program or in another process, or
            damaged files.
        """
        folder.mkdir(parents=True, exist_ok=True)
        identity = {"request": digest(request), "version": VERSION, "source": source_hash()}
        checkpoint, path = cls(folder, digest(identity)), folder / "request.json"
        with locked(folder / ".integration.lock", f"solve.folder {str(folder)!r}"):
            remove_partial_files(folder)
            if path.exists():
                checkpoint._check_identity(identity)
            elif any(not entry.name.startswith(".") for entry in folder.iterdir()):
                raise InvalidInput(f"solve.folder is {str(folder)!r}, which holds other files: give an empty folder.")
            else:
                write_with_checksum(path, json.dumps(identity, indent=1).encode())
            yield checkpoint

    def _check_identity(self, identity: Mapping[str, Any]) -> None:
        """Raise InvalidInput if ``request.json`` in the folder has another identity: "request", "version", "source"."""
        with self._report_damage():
            content = read_verified(self.folder / "request.json")
            stored = json.loads(content or b"")
            stored_identity = [stored[name] for name in identity]
        what = "an integration of another version of this program"
        if stored_identity[0] != identity["request"]:
            what = "the integration of another scene, grid or request"
        if stored_identity != list(identity.values()):
            raise InvalidInput(f"solve.folder is {str(self.folder)!r}, which holds {what}: give another folder.")

    @contextmanager
    def _report_damage(self) -> Iterator[None]:
        """Convert an error that shows a damaged file into an InvalidInput that names the folder."""
        try:
            yield
        except (OSError, LookupError, TypeError, ValueError, EOFError, BadZipFile) as error:
            raise InvalidInput(
                f"solve.folder is {str(self.folder)!r}, which is damaged ({type(error).__name__}): remove it, or give "
                "another folder."
            ) from None

    def write(self, name: str, value: object) -> None:
        """Replace the file called `name` by one with `value`: its arrays beside all else as JSON, which names them."""
        arrays: dict[str, Array] = {}

        def name_array(values: object) -> dict[str, str]:
            if not isinstance(values, np.ndarray):
                raise TypeError(f"{type(values).__name__} cannot be stored in {name}")
            array = f"array_{len(arrays)}"
            arrays[array] = values
            return {ARRAY: array}

        tree = {"request": self.request_hash, "file": name}
        tree["value"] = _converter().unstructure(value)
        content = BytesIO()
        header = json.dumps(tree, default=name_array)
        np.savez(content, header=np.array(header), **arrays)  # type: ignore[arg-type]
        write_with_checksum(self.folder / name, content.getvalue())

    def read(self, name: str, kind: type[T]) -> T:
        """Return the value of that `kind` in the file called `name`."""
        path = self.folder / name
        with self._report_damage(), np.load(BytesIO(read_verified(path) or b"")) as file:

            def with_arrays(item: dict[str, Any]) -> Any:
                return file[item[ARRAY]] if ARRAY in item else item

            header = json.loads(str(file["header"]), object_hook=with_arrays)
            if (header["request"], header["file"]) != (self.request_hash, name):
                raise ValueError("a file of another integration")
            value: T = _converter().structure(header["value"], kind)
            return value


@cache
def _converter() -> Any:
    """Return a converter between dataclasses and values for JSON, which leaves arrays as they are, and problems out."""
    converter = import_for("solve.folder", "cattrs").Converter(detailed_validation=False)

    def is_array(kind: Any) -> bool:
        return np.ndarray in (kind, get_origin(kind))

    converter.register_unstructure_hook_func(is_array, lambda values: values)
    converter.register_structure_hook_func(is_array, lambda values, _: values)
    converter.register_unstructure_hook(Problem, lambda _: None)
    converter.register_structure_hook(Problem, lambda values, _: values)
    return converter
