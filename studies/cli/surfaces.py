"""Measured surfaces for ``contactstudy show``: of a file, or of a scene."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import contactstudy as cs
from contactstudy import InvalidInput

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def surfaces_of(file: Path, extent: str | None, **keys: Any) -> dict[str, cs.MeasuredSurface]:
    """Return the measured surfaces of a file or of a scene by the stems of their pictures; none for another file."""
    if file.suffix == ".toml":
        shapes = enumerate(cs.read_scene(file).scene.shapes)
        found = {
            f"{file.stem}-shapes-{number}": shape
            for number, shape in shapes
            if isinstance(shape, cs.MeasuredSurface)
        }
        if not found:
            raise InvalidInput(
                f"{str(file)!r} has no measured surface: give one that has, or the .nc file of its solve."
            )
        return found
    if not file.is_file() or (file.suffix == ".nc" and not _holds_heights(file)):
        return {}
    sides: Any = None if extent is None else [side.strip() for side in extent.split(",")]
    missing = cs.HarmonicFill(up_to=0.5)
    given: Any = {"extent": sides, "missing": missing, "seam": cs.AsMeasured(), **keys}
    return {file.stem: cs.MeasuredSurface.read(file, **given)}


def _holds_heights(file: Path) -> bool:
    """Return whether a netCDF file holds heights alone, and no solution or study."""
    from studies.store.netcdf import read_any

    dataset = read_any(file)
    return "heights" in dataset and not {"gap", "case_status"} & set(dataset.variables)


def drawn_surfaces(
    surfaces: dict[str, cs.MeasuredSurface], *, with_raw: bool
) -> "dict[str, Figure]":
    """Print what was done to surfaces, and their parameters; return their pictures."""
    from contactstudy.io.pictures.surface import surface_picture
    from contactstudy.io.quantities.surface_quantities import parameters_text, surface_parameters

    for name, surface in surfaces.items():
        click.echo(f"{name}: {surface.description}")
        for line in parameters_text(surface_parameters(surface)):
            click.echo(f"  {line}")
    return {name: surface_picture(surface, raw=with_raw) for name, surface in surfaces.items()}
