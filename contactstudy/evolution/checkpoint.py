"""Checkpoint of a march on disk: recorded frames, and the state to continue from."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from contactstudy.accuracy.expected_error import ErrorParts
from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.files import replacing
from contactstudy.evolution.evolution import Frame
from contactstudy.evolution.march import Instant
from contactstudy.problem.problem import Field
from contactstudy.solvers.solution import Status


@dataclass(frozen=True)
class Checkpoint:
    """Folder of a march: ``request.json``, ``frame_00000.npz`` and so on, and ``state.npz``.

    Each file is replaced in one step and written through to the disk, so that a killed march leaves the previous one.
    """

    folder: Path

    def open(self, request: str) -> None:
        """Make the folder for a march, or check that it holds this march.

        Parameters
        ----------
        request
            Text that identifies scene, grid and options.

        Raises
        ------
        InvalidInput
            If the folder holds another march or other files.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        path, digest = self.folder / "request.json", hashlib.sha256(request.encode()).hexdigest()
        if path.exists():
            stored = json.loads(path.read_text(encoding="utf-8"))
            if stored.get("sha256") != digest:
                raise InvalidInput(
                    f"evolve.folder is {str(self.folder)!r}, which holds the march of another scene, grid or "
                    "request: give another folder."
                )
            return
        if any(self.folder.iterdir()):
            raise InvalidInput(
                f"evolve.folder is {str(self.folder)!r}, which holds other files: give an empty folder."
            )
        with replacing(path) as partial:
            partial.write_text(
                json.dumps({"sha256": digest, "request": request}, indent=1), "utf-8"
            )

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
                for key, field in state.items():
                    arrays[f"{name}_{number}_{key}"] = field
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

    def _write(self, path: Path, metadata: Mapping[str, Any], **arrays: Array) -> None:
        """Replace a file by one with `arrays` and with `metadata` as JSON."""
        with replacing(path) as partial, partial.open("wb") as file:
            np.savez(file, about=np.array(json.dumps(metadata)), **arrays)  # type: ignore[arg-type]

    def _read(self, path: Path) -> tuple[Any, dict[str, Array]]:
        """Return metadata and arrays of a file."""
        with np.load(path) as file:
            arrays = {name: file[name] for name in file.files}
        return json.loads(str(arrays.pop("about"))), arrays


NUMBERS = ("time", "load", "approach", "residual", "step_error", "grid_error", "steps", "iterations",
           "convolutions")  # fmt: skip
