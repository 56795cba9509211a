"""``contactstudy show FILE.nc``."""

from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from contactstudy import InvalidInput
from contactstudy.domain.imports import import_for

if TYPE_CHECKING:
    import xarray as xr

FORMATS = ("png", "pdf", "svg", "vtk")


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    help="Folder for the pictures.  [default: that of FILE]",
)
@click.option(
    "--format",
    "formats",
    default="png",
    show_default=True,
    help="png, pdf, svg or, of a solution, vtk for ParaView; several with commas.",
)
@click.option(
    "--figures", type=click.Choice(["curves", "maps"]), default="curves", show_default=True
)
def show(file: Path, out: Path | None, formats: str, figures: str) -> None:
    """Draw what is in FILE: a solution, with pressure, gap, profiles and stress, or a study."""
    from contactstudy.domain.files import replacing
    from studies.store.netcdf import open_folder, read_any

    chosen = [one.strip().lower().lstrip(".") for one in formats.split(",")]
    for one in chosen:
        if one not in FORMATS:
            raise InvalidInput(f"--format is {one!r}: give one or more of {', '.join(FORMATS)}.")
    dataset = read_any(file)
    folder = open_folder(out or file.parent)
    if "pressure" in dataset and dataset["pressure"].dims == ("x", "y"):
        from contactstudy.io.pictures.contact import picture

        drawn = {file.stem: picture(dataset)} if set(chosen) - {"vtk"} else {}
        if "vtk" in chosen:
            click.echo(f"wrote {_vtk(dataset, folder / file.stem)}")
    elif "case_status" in dataset:
        if "vtk" in chosen:
            raise InvalidInput(
                "--format has vtk, which is for the fields of a solution: leave it out for a study."
            )
        from studies.registry import BUILT_IN, default_drawing, load_drawing

        name = str(dataset.attrs.get("study", file.stem))
        drawing = load_drawing(name) if name in BUILT_IN else default_drawing(figures)
        drawn = {f"{file.stem}-{one.name}": one.figure for one in drawing.figure(dataset)}
    else:
        raise InvalidInput(
            f"{str(file)!r} is neither a solution nor a study: give a file that contactstudy solve or run wrote."
        )
    for stem, figure in drawn.items():
        for suffix in (one for one in chosen if one != "vtk"):
            with replacing(folder / f"{stem}.{suffix}") as partial:
                figure.savefig(partial, format=suffix)
            click.echo(f"wrote {folder / stem}.{suffix}")


def _vtk(dataset: "xr.Dataset", stem: Path) -> str:
    """Pressure and gap over the cells as a rectilinear grid; stress, if there is any, as points in depth."""
    write = import_for("--format vtk", "pyevtk.hl").gridToVTK
    edges = [_edges(dataset[axis].values) for axis in ("x", "y")]
    # its cells lie between edges: one thin layer, so that the map is seen from above
    cells = {
        name: np.ascontiguousarray(dataset[name].values[:, :, None])
        for name in ("pressure", "gap", "displacement")
        if name in dataset
    }
    flat = np.array([0.0, min(np.diff(edge).min() for edge in edges)])
    # the library adds the ending
    path = write(str(stem), edges[0], edges[1], flat, cellData=cells)
    if "von_mises" in dataset:
        values = np.ascontiguousarray(dataset["von_mises"].transpose("x", "y", "z").values)
        depths = -dataset["z"].values
        axes = [np.ascontiguousarray(dataset[axis].values, dtype=float) for axis in ("x", "y")]
        order = np.argsort(depths)
        write(
            f"{stem}-stress", axes[0], axes[1], np.ascontiguousarray(depths[order]),
            pointData={"von_mises": np.ascontiguousarray(values[:, :, order])},
        )  # fmt: skip
    return str(path)


def _edges(centres: np.ndarray) -> np.ndarray:
    if len(centres) == 1:
        return np.array([-0.5, 0.5]) * (abs(float(centres[0])) or 1e-6)
    step = float(centres[-1] - centres[0]) / (len(centres) - 1)
    return np.asarray(centres[0] + step * (np.arange(len(centres) + 1) - 0.5))
