"""Checkpoint of an integration on disk: recorded frames, and the state to continue from."""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any, TypeVar, get_origin
from zipfile import BadZipFile

import numpy as np

from contactstudy.domain.files import locked, read_verified, remove_partial_files, write_with_checksum
from contactstudy.domain.grid import Array
from contactstudy.domain.identity import digest
from contactstudy.domain.imports import VERSION, import_for, source_hash
from contactstudy.domain.validation import InvalidInput
from contactstudy.problem.problem import Problem

T = TypeVar("T")
ARRAY = "array"  # key of the name of an array in JSON


@dataclass
class Checkpoint:
    """Folder of one integration: ``request.json``, ``frame_00000.npz`` and so on, and ``state.npz``.

    Each file has a checksum and is replaced in one step, so that a killed integration leaves the previous one and
    damage is detected. Frames and state name the hash of the request in ``request.json``.

    Attributes
    ----------
    folder
        The folder.
    request_hash
        Hash of the request and of this program, which :meth:`open` sets.
    """

    folder: Path
    request_hash: str = ""

    @contextmanager
    def open(self, request: object) -> Iterator[None]:
        """Make the folder for an integration, or check that it holds this integration, and lock it in the block.

        Parameters
        ----------
        request
            Scene, grid and options that identify the integration.

        Raises
        ------
        InvalidInput
            If the folder holds another integration, one of another version of this program or in another process, or
            damaged files.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        identity = {"request": digest(request), "version": VERSION, "source": source_hash()}
        self.request_hash = digest(identity)
        with locked(self.folder / ".integration.lock", f"solve.folder {str(self.folder)!r}"):
            remove_partial_files(self.folder)
            path = self.folder / "request.json"
            if path.exists():
                self._check_identity(identity)
            elif any(not entry.name.startswith(".") for entry in self.folder.iterdir()):
                raise InvalidInput(
                    f"solve.folder is {str(self.folder)!r}, which holds other files: give an empty folder."
                )
            else:
                write_with_checksum(path, json.dumps(identity, indent=1).encode())
            yield

    def _check_identity(self, identity: Mapping[str, Any]) -> None:
        """Raise InvalidInput if the folder belongs to another request."""
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
