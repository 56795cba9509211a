"""Checkpoint of a march on disk: recorded frames, and the state to continue from."""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from contactstudy.accuracy.expected_error import ErrorParts
from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.files import (
    locked,
    read_sealed,
    remove_partial_files,
    write_sealed,
)
from contactstudy.domain.identity import canonical, key
from contactstudy.domain.version import VERSION, source_hash
from contactstudy.evolution.evolution import Frame
from contactstudy.evolution.march import Instant
from contactstudy.problem.problem import Field
from contactstudy.solvers.solution import Status


@dataclass
class Checkpoint:
    """Folder of a march: ``request.json``, ``frame_00000.npz`` and so on, and ``state.npz``, for one march at a time.

    Each file has a checksum and is replaced in one step, so that a killed march leaves the previous one and damage is
    detected. Each names the request that it belongs to.
    """

    folder: Path
    request: str = ""

    @contextmanager
    def open(self, request: object) -> Iterator[None]:
        """Make the folder for a march, or check that it holds this march, and lock it in the block.

        Parameters
        ----------
        request
            Scene, grid and options that identify the march.

        Raises
        ------
        InvalidInput
            If the folder holds another march, one of another version of this program or in another process, or damaged
            files.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        tree = {"request": canonical(request), "version": VERSION, "source": source_hash()}
        self.request = key(tree)

        def refuse(holder: str) -> None:
            raise InvalidInput(
                f"evolve.folder is {str(self.folder)!r}; {holder}: run again when it has ended, or give another folder."
            )

        with locked(self.folder / ".march.lock", refuse):
            remove_partial_files(self.folder)
            path = self.folder / "request.json"
            if path.exists():
                self._check(tree)
            elif any(not entry.name.startswith(".") for entry in self.folder.iterdir()):
                raise InvalidInput(
                    f"evolve.folder is {str(self.folder)!r}, which holds other files: give an empty folder."
                )
            else:
                write_sealed(path, json.dumps(tree, indent=1).encode())
            yield

    def _check(self, tree: Mapping[str, Any]) -> None:
        """Raise InvalidInput if the folder belongs to another request."""
        with self._blamed():
            content = read_sealed(self.folder / "request.json")
            stored = json.loads(content or b"")
            identity = [stored[name] for name in tree]
        what = "a march of another version of this program"
        if identity[0] != tree["request"]:
            what = "the march of another scene, grid or request"
        if identity != list(tree.values()):
            raise InvalidInput(
                f"evolve.folder is {str(self.folder)!r}, which holds {what}: give another folder."
            )

    @contextmanager
    def _blamed(self) -> Iterator[None]:
        """Raise an error of a damaged file as a sentence that names the folder."""
        try:
            yield
        except (OSError, LookupError, TypeError, ValueError, EOFError, BadZipFile) as error:
            raise InvalidInput(
                f"evolve.folder is {str(self.folder)!r}, which is damaged ({type(error).__name__}): remove it, or give "
                "another folder."
            ) from None

    def write_frame(self, number: int, frame: Frame) -> None:
        """Write the frame with index `number`."""
        metadata = {
            "fields": {
                name: [field.dimensions, field.units, field.long_name]
                for name, field in frame.fields.items()
            },
            "status": frame.status.name,
            "grid_error_parts": asdict(frame.grid_error_parts),
            "warnings": frame.warnings,
        } | {name: getattr(frame, name) for name in NUMBERS}
        fields = {f"field_{name}": field.values for name, field in frame.fields.items()}
        fields |= {f"kept_{name}": values for name, values in frame.joint_state.items()}
        self._write(self._frame(number), metadata, pressure=frame.pressure, gap=frame.gap, **fields)

    def read_frame(self, number: int) -> Frame:
        """Return the frame with index `number`."""
        metadata, arrays = self._read(self._frame(number))
        fields = {
            name: Field(tuple(dimensions), arrays[f"field_{name}"], units, long_name)
            for name, (dimensions, units, long_name) in metadata["fields"].items()
        }
        numbers = {name: metadata[name] for name in NUMBERS}
        status = Status[metadata["status"]]
        joint_state = {
            name.removeprefix("kept_"): values
            for name, values in arrays.items()
            if name.startswith("kept_")
        }
        return Frame(
            pressure=arrays["pressure"],
            gap=arrays["gap"],
            fields=fields,
            joint_state=joint_state,
            status=status,
            grid_error_parts=ErrorParts(**metadata["grid_error_parts"]),
            warnings=tuple(metadata["warnings"]),
            **numbers,
        )

    def write_state(self, progress: Mapping[str, Any], instants: Mapping[str, Instant]) -> None:
        """Write the state of the march.

        Parameters
        ----------
        progress
            Counts and flags of the march, as JSON holds them.
        instants
            The instants of main march and companion, by name.
        """
        metadata: dict[str, Any] = {"progress": dict(progress), "instants": {}}
        arrays = {}
        for name, instant in instants.items():
            metadata["instants"][name] = [
                instant.time,
                instant.load,
                [list(state) for state in instant.states],
            ]
            arrays[f"{name}_pressure"] = instant.pressure
            for number, state in enumerate(instant.states):
                for part, field in state.items():
                    arrays[f"{name}_{number}_{part}"] = field
        self._write(self.folder / "state.npz", metadata, **arrays)

    def read_state(self) -> tuple[Mapping[str, Any], Mapping[str, Instant]] | None:
        """Return the progress and the instants that were written last; None if there are none."""
        path = self.folder / "state.npz"
        if not path.exists():
            return None
        metadata, arrays = self._read(path)
        instants = {
            name: Instant(
                time,
                load,
                arrays[f"{name}_pressure"],
                tuple(
                    {key: arrays[f"{name}_{number}_{key}"] for key in keys}
                    for number, keys in enumerate(states)
                ),
            )
            for name, (time, load, states) in metadata["instants"].items()
        }
        return metadata["progress"], instants

    def _frame(self, number: int) -> Path:
        """Return the path of the frame with index `number`."""
        return self.folder / f"frame_{number:05d}.npz"

    def _write(self, path: Path, about: Mapping[str, Any], **arrays: Array) -> None:
        """Replace a file by one with metadata as JSON and arrays."""
        owned = {"request": self.request, "file": path.name, "about": about}
        content = BytesIO()
        np.savez(content, about=np.array(json.dumps(owned)), **arrays)  # type: ignore[arg-type]
        write_sealed(path, content.getvalue())

    def _read(self, path: Path) -> tuple[Any, dict[str, Array]]:
        """Return metadata and arrays of a file."""
        with self._blamed(), np.load(BytesIO(read_sealed(path) or b"")) as file:
            arrays = {name: file[name] for name in file.files}
            owned = json.loads(str(arrays.pop("about")))
            if (owned["request"], owned["file"]) != (self.request, path.name):
                raise ValueError("a file of another march")
            return owned["about"], arrays


NUMBERS = ("time", "load", "approach", "residual", "step_error", "grid_error", "steps", "iterations",
           "convolutions")  # fmt: skip
