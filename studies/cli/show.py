"""The commands on stored files: ``contactstudy show FILE.nc`` and ``contactstudy compare A.nc B.nc``."""

import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from contactstudy import InvalidInput, Sizes
from contactstudy.domain.imports import import_for
from contactstudy.domain.units import display_unit_of
from studies.cli.options import (
    FIGURES,
    FORMAT,
    PICTURES,
    PLOT,
    formats_in,
    names_in,
    out_option,
    refuse,
)
from studies.cli.surfaces import drawn_surfaces, surfaces_of
from studies.model.outcome import is_time
from studies.model.plain_text import one_line, place_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

FORMATS = (*PICTURES, "vtk", "html")


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@out_option("Folder for the pictures.  [default: that of FILE]", None)
@FORMAT
@FIGURES
@PLOT
@click.option(
    "--csv",
    "as_table",
    is_flag=True,
    help="Print the numbers of FILE as CSV instead: a row for each point of a study, units in the header.",
)
@click.option("--unit", help="Unit of the heights of a measured surface, of a file without one.")
@click.option(
    "--extent",
    help="Width and length of a measured surface without sizes, such as '1 mm, 2 mm'.",
)
@click.option("--invalid", type=float, help="Number of points that were not measured in a surface.")
@click.option(
    "--decimal", type=click.Choice([",", "."]), help="Decimal sign of the text file of a surface."
)
@click.option(
    "--sizes",
    type=click.Choice(["checked", "confirmed"]),
    help="Whether sizes, units and heights of a surface that are not plausible are refused.  [default: checked]",
)
@click.option("--raw", is_flag=True, help="Draw a measured surface as it was measured beside.")
@click.pass_context
def show(
    context: click.Context,
    /,
    file: Path,
    out: Path | None,
    formats: str,
    figures: str,
    plot: str,
    as_table: bool,  # noqa: FBT001 (click's own way)
    unit: str | None,
    extent: str | None,
    invalid: float | None,
    decimal: str | None,
    sizes: str | None,
    raw: bool,  # noqa: FBT001 (click's own way)
) -> None:
    """Draw what is in FILE: a solution, a study, or a measured surface.

    A measured surface is drawn with its parameters, also those of a scene in a TOML file, prepared as the scene says.
    """
    from studies.store.netcdf import open_folder, read_any

    chosen = formats_in(formats, FORMATS)
    keys = {
        "unit": unit,
        "invalid": invalid,
        "decimal": decimal,
        "sizes": Sizes(sizes or "checked"),
    }
    if surfaces := surfaces_of(file, extent, **keys):
        refuse(context, "a study, and not for a surface", "figures", "plot", "as_table")
        drawn = drawn_surfaces(surfaces, with_raw=raw)
        _save(drawn, open_folder(out or file.parent), [name for name in chosen if name in PICTURES])
        return
    refuse(context, "a measured surface", "unit", "extent", "invalid", "decimal", "sizes", "raw")
    dataset = read_any(file)
    if as_table:
        refuse(context, "pictures, and not for --csv", "out", "formats", "figures", "plot")
        with drawing(str(file), "its variables do not fit a table."):
            table = _csv(dataset)
        click.echo(table, nl=False)
        return
    folder = open_folder(out or file.parent)
    with drawing(str(file), "its variables do not fit a figure; --csv prints them."):
        if "html" in chosen:
            click.echo(f"wrote {_page(dataset, file, folder)}")
        drawn = _drawn(context, dataset, file, folder, chosen, figures, plot)
    _save(drawn, folder, [name for name in chosen if name in PICTURES])


def _drawn(
    context: click.Context, dataset: "xr.Dataset", file: Path, folder: Path, chosen: list[str],
    figures: str, plot: str,
) -> "dict[str, Figure]":  # fmt: skip
    """Return the figures of a dataset in a file by their names, and write it for VTK if that is chosen."""
    is_study = "case_status" in dataset
    if "vtk" in chosen:
        if is_study or "gap" not in dataset or "time" in dataset.dims:
            raise InvalidInput(
                "--format has vtk, which is for a dry contact at rest: leave it out for other files."
            )
        click.echo(f"wrote {_vtk(dataset, folder / file.stem)}")
    if not is_study:
        refuse(context, "a study, and not for a solution", "figures", "plot")
        return {file.stem: _picture(dataset, file)} if set(chosen) & set(PICTURES) else {}
    if not set(chosen) & set(PICTURES):
        return {}
    from studies.registry import BUILT_IN, default_drawing, load_drawing

    name = str(dataset.attrs.get("study", file.stem))
    if name in BUILT_IN:
        refuse(context, "a study without figures of its own", "figures", "plot")
        figures_of = load_drawing(name)
    else:
        figures_of = default_drawing(figures, names_in(plot))
    return {f"{file.stem}-{item.name}": item.figure for item in figures_of.figure(dataset)}


def _page(dataset: "xr.Dataset", file: Path, folder: Path) -> Path:
    """Write the interactive page of a file, and return its path."""
    from contactstudy.domain.files import replacing
    from studies.cli.explore import page_of

    # not FILE.html, which may be a chapter of the report
    path = folder / f"{file.stem}-explore.html"
    page = page_of(dataset, file.stem)
    with replacing(path) as partial:
        partial.write_text(page, encoding="utf-8")
    return path


# Remedies where a figure fails.
REMEDY_IN_CODE = (
    "the stored variables do not fit the figure, or its code is wrong; correct it and run again, which draws what is "
    "stored."
)
REMEDY_IN_TIMES = "its figures may need times: run with --repeats 1."


@contextmanager
def drawing(name: str, remedy: str = REMEDY_IN_CODE) -> Iterator[None]:
    """Report an error of a figure in one sentence with its `remedy`: the numbers are stored."""
    try:
        yield
    except (InvalidInput, click.ClickException, ModuleNotFoundError):
        raise
    except OSError as error:
        raise click.ClickException(
            f"{name} cannot be drawn ({error.strerror or error}): make room or give another folder with --out, "
            "and run again, which draws what is stored."
        ) from None
    except Exception as error:  # noqa: BLE001 (a study file may do anything)
        raise click.ClickException(
            f"{name} cannot be drawn ({type(error).__name__}{place_of(error)}: {one_line(error, 300)}): {remedy}"
        ) from None


def _save(drawn: "dict[str, Figure]", folder: Path, formats: list[str]) -> None:
    """Write figures by the stems of their files, in each format."""
    from contactstudy.domain.files import replacing

    for stem, figure in drawn.items():
        for suffix in formats:
            with replacing(folder / f"{stem}.{suffix}") as partial:
                figure.savefig(partial, format=suffix)
            click.echo(f"wrote {folder / stem}.{suffix}")


def _picture(dataset: "xr.Dataset", file: Path) -> "Figure":
    """Return the picture of a solution: a contact, a film, either in time, or repeated rolling."""
    from contactstudy.io.pictures import contact, evolution

    in_time = "time" in dataset.dims
    if "film" in dataset:
        picture = evolution.film_evolution_picture if in_time else contact.film_picture
        return picture(dataset)
    if "pass_number" in dataset.dims:
        return evolution.passes_picture(dataset)
    if "gap" in dataset:
        return evolution.evolution_picture(dataset) if in_time else contact.contact_picture(dataset)
    raise InvalidInput(
        f"{str(file)!r} is neither a solution nor a study: give a file that contactstudy solve or run wrote."
    )


def _csv(dataset: "xr.Dataset") -> str:
    """Return a table as CSV: a row for each point of a study or instant of an evolution, or one row for a solution."""
    if "case_status" in dataset:
        axes = [str(name) for name in dataset["case_status"].dims]
    else:
        axes = [name for name in ("time", "pass_number") if name in dataset.dims]
    # beside axes, leave out scalars: they would repeat in every row
    names = [
        str(name)
        for name, variable in dataset.data_vars.items()
        if set(variable.dims) <= set(axes) and bool(variable.dims) == bool(axes)
    ]
    names.sort(key=_column_order)
    flat = dataset[names].assign({name: _with_flag_meanings(dataset[name]) for name in names})
    if "contended" not in flat or (flat["contended"] == "not_timed").all():
        flat = flat.drop_vars([name for name in names if is_time(name)])
    flat = flat.reset_coords(drop=True)
    if axes:
        table = flat.to_dataframe(dim_order=axes).reset_index()
    else:
        table = flat.expand_dims("row").to_dataframe().reset_index(drop=True)
    for name in [str(column) for column in table.columns]:
        head, factor = _header(dataset, name)
        if factor != 1:
            table[name] = table[name] / factor
        table = table.rename(columns={name: head})
    return str(table.to_csv(index=False, float_format="%.14g"))


# Columns at the end of a table, in this order: the solver's work, the case, the times.
SORTED_LAST = ("status", "iterations", "convolutions", "residual", "case_", "contended", "_time")


def _column_order(name: str) -> int:
    """Return the position of a column among :data:`SORTED_LAST`, 0 for any other."""
    places = [place for place, word in enumerate(SORTED_LAST, start=1) if word in name]
    return max(places, default=0)


def _header(dataset: "xr.Dataset", name: str) -> tuple[str, float]:
    """Return the head of a column with the unit in which it is read best, and the factor of this unit in SI units."""
    if name not in dataset.variables:
        return name, 1.0
    units = str(dataset[name].attrs.get("units", "1"))
    # a bound in the unit of what it bounds
    bounded = name.removesuffix("_bound")
    values = dataset[bounded if bounded in dataset.variables else name].values
    if units == "1" or values.dtype.kind not in "iuf":
        return name if units == "1" else f"{name} [{units}]", 1.0
    factor, unit = display_unit_of(values, units)
    return f"{name} [{unit}]", factor


def _with_flag_meanings(variable: "xr.DataArray") -> "xr.DataArray":
    """Return a flag variable with the meaning of each value, empty for nan, and any other variable unchanged."""
    meanings = str(variable.attrs.get("flag_meanings", "")).split()
    if not meanings:
        return variable
    values = [int(value) for value in np.atleast_1d(variable.attrs["flag_values"])]
    words = dict(zip(values, meanings, strict=True))
    named = np.vectorize(lambda value: words.get(value, ""), otypes=[object])(variable.values)
    return variable.copy(data=named)


def _vtk(dataset: "xr.Dataset", stem: Path) -> str:
    """Write pressure and gap over the cells as a rectilinear grid, and stress as points in depth; return the file."""
    write = import_for("--format vtk", "pyevtk.hl").gridToVTK
    edges = [_edges(dataset[axis].values) for axis in ("x", "y")]
    # a cell alone is as long as the scene's grid, or square where that is not known
    if len(edges[1]) == 2:
        grid = tomllib.loads(str(dataset.attrs.get("scene", ""))).get("grid", {})
        edges[1] *= grid.get("extent", (0.0, np.diff(edges[0])[0]))[1]
    # its cells lie between edges: one thin layer, so that the map is seen from above
    shown = [name for name in ("pressure", "gap", "displacement") if name in dataset]
    cells = {name: np.ascontiguousarray(dataset[name].values[:, :, None]) for name in shown}
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
    """Return the edges of cells with these centres [m]; of a single one those of a cell of length 1."""
    step = float(centres[-1] - centres[0]) / (len(centres) - 1) if len(centres) > 1 else 1.0
    return np.asarray(centres[0] + step * (np.arange(len(centres) + 1) - 0.5))


@click.command()
@click.argument("first", metavar="A", type=click.Path(path_type=Path))
@click.argument("second", metavar="B", type=click.Path(path_type=Path))
@out_option("Folder for a picture of the difference.  [default: none is drawn]", None)
@click.pass_context
def compare(context: click.Context, /, first: Path, second: Path, out: Path | None) -> None:
    """Print how B differs from A.

    Both are solutions on any grids of one period, or runs of one study.
    """
    import contactstudy as cs
    from contactstudy.domain.files import replacing
    from studies.report.changes import changes
    from studies.store.netcdf import open_folder, read_any

    a, b = read_any(first), read_any(second)
    of_studies = {"case_status" in a, "case_status" in b}
    if of_studies == {False} and "pressure" in a and "pressure" in b:
        comparison = cs.compare(a, b)
        for line in str(comparison).splitlines():
            click.echo(line)
        if out is not None:
            name = f"{first.stem}-{second.stem}.png"
            with replacing(open_folder(out) / name) as partial:
                comparison.plot().savefig(partial)
            click.echo(f"wrote {out / name}")
    elif of_studies == {True}:
        refuse(context, "two solutions, and not for two runs of a study", "out")
        for line in changes(a, b):
            click.echo(line)
    else:
        raise InvalidInput(
            f"{str(first)!r} and {str(second)!r} are of different kinds: give two solutions or two runs of a study."
        )
