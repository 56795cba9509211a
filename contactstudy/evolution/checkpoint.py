"""A march on disk: frames as they are found, and where to go on from."""

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
    """A folder with ``request.json``, ``frame_00000.npz`` and so on, and ``state.npz``.

    Each file is replaced at once and on the disk, so that a kill leaves the one before.
    """

    folder: Path

    def open(self, request: str) -> None:
        """Make the folder for ``request``, or check that it is the one's.

        Raises :class:`~contactstudy.InvalidInput` where another march is in it.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        path, digest = self.folder / "request.json", hashlib.sha256(request.encode()).hexdigest()
        if path.exists():
            known = json.loads(path.read_text(encoding="utf-8"))
            if known.get("sha256") != digest:
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
        """One more frame."""
        about = {
            "fields": {
                name: [field.dimensions, field.units, field.long_name]
                for name, field in frame.fields.items()
            },
            "status": frame.status.name,
            "grid_error_parts": asdict(frame.grid_error_parts),
            "warnings": frame.warnings,
        } | {name: getattr(frame, name) for name in NUMBERS}
        fields = {f"field_{name}": field.values for name, field in frame.fields.items()}
        fields |= {f"kept_{name}": values for name, values in frame.kept.items()}
        self._write(self._frame(number), about, pressure=frame.pressure, gap=frame.gap, **fields)

    def read_frame(self, number: int) -> Frame:
        """The frame of that number."""
        about, arrays = self._read(self._frame(number))
        fields = {
            name: Field(tuple(dimensions), arrays[f"field_{name}"], units, long_name)
            for name, (dimensions, units, long_name) in about["fields"].items()
        }
        numbers = {name: about[name] for name in NUMBERS}
        status = Status[about["status"]]
        kept = {
            name.removeprefix("kept_"): values
            for name, values in arrays.items()
            if name.startswith("kept_")
        }
        return Frame(
            pressure=arrays["pressure"],
            gap=arrays["gap"],
            fields=fields,
            kept=kept,
            status=status,
            grid_error_parts=ErrorParts(**about["grid_error_parts"]),
            warnings=tuple(about["warnings"]),
            **numbers,
        )

    def write_state(self, progress: Mapping[str, Any], instants: Mapping[str, Instant]) -> None:
        """Where the march is: numbers of its own, and its instants by name."""
        about: dict[str, Any] = {"progress": dict(progress), "instants": {}}
        arrays = {}
        for name, instant in instants.items():
            about["instants"][name] = [
                instant.time,
                instant.load,
                [list(state) for state in instant.states],
            ]
            arrays[f"{name}_pressure"] = instant.pressure
            for number, state in enumerate(instant.states):
                for key, field in state.items():
                    arrays[f"{name}_{number}_{key}"] = field
        self._write(self.folder / "state.npz", about, **arrays)

    def read_state(self) -> tuple[Mapping[str, Any], Mapping[str, Instant]] | None:
        """What was written last; None before the first time."""
        path = self.folder / "state.npz"
        if not path.exists():
            return None
        about, arrays = self._read(path)
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
            for name, (time, load, states) in about["instants"].items()
        }
        return about["progress"], instants

    def _frame(self, number: int) -> Path:
        return self.folder / f"frame_{number:05d}.npz"

    def _write(self, path: Path, about: Mapping[str, Any], **arrays: Array) -> None:
        with replacing(path) as partial, partial.open("wb") as file:
            np.savez(file, about=np.array(json.dumps(about)), **arrays)  # type: ignore[arg-type]

    def _read(self, path: Path) -> tuple[Any, dict[str, Array]]:
        with np.load(path) as file:
            arrays = {name: file[name] for name in file.files}
        return json.loads(str(arrays.pop("about"))), arrays


NUMBERS = ("time", "load", "approach", "residual", "step_error", "grid_error", "steps", "iterations",
           "convolutions")  # fmt: skip
