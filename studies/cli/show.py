"""The commands on stored files: ``contactstudy show FILE.nc`` and ``contactstudy compare A.nc B.nc``."""

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import contactstudy as cs
from contactstudy import InvalidInput, MeasuredSurface
from studies.cli.options import FORMAT, PICTURES, PLOT, formats_in, is_given, names_in, out_option, refuse, write_text
from studies.model.drawing import write_figure
from studies.model.plain_text import one_line, place_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from contactstudy.io.pictures import Heights

FORMATS = (*PICTURES, "vtk", "html", "excel")


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("names", nargs=-1)
@out_option("Folder for the files.  [default: that of FILE; --csv prints]", None)
@FORMAT
@PLOT
@click.option(
    "--csv", "as_table", is_flag=True, help="A table as CSV: the quantities, NAMES or all; --format excel is for Excel."
)
@click.option("--unit", help="Unit of the heights of a measured surface, of a file without one.")
@click.option("--extent", help="Width and length of a measured surface without sizes, such as '1 mm, 2 mm'.")
@click.option("--invalid", type=float, help="Number of points that were not measured in a surface.")
@click.option("--decimal", type=click.Choice([",", "."]), help="Decimal sign of the text file of a surface.")
@click.option(
    "--sizes",
    type=click.Choice(["checked", "confirmed"]),
    default="checked",
    help="Whether sizes, units and heights of a surface that are not plausible are refused.",
)
@click.pass_context
def show(
    context: click.Context,
    /,
    file: Path,
    names: tuple[str, ...],
    out: Path | None,
    formats: str,
    plot: str | None,
    as_table: bool,  # noqa: FBT001 (click's own way)
    **reading: Any,  # the options of a measured surface
) -> None:
    """Draw what is in FILE, or its NAMES: a solution, a study, or a measured surface.

    A measured surface is drawn with its parameters, also those of a scene in a TOML file, prepared as the scene says;
    with the name raw also as it was measured.
    """
    from studies.store.netcdf import open_folder, read_any

    chosen, named = formats_in(formats, FORMATS), (*names_in(plot), *names)
    pictures = [name for name in chosen if name in PICTURES]
    if surfaces := surfaces_of(file, **reading):
        refuse(context, "a study, and not for a surface", "as_table")
        if set(named) - {"raw"}:
            raise InvalidInput(f"{named[0]!r} is no picture of a surface: give raw, or no name.")
        shown: tuple[Heights, ...] = ("prepared", "as measured") if named else ("prepared",)
        _save(drawn_surfaces(surfaces, shown), open_folder(out or file.parent), pictures)
        return
    refuse(context, "a measured surface", *reading)
    dataset = read_any(file)
    if as_table:
        if is_given(context, "formats") and set(chosen) != {"excel"}:
            raise InvalidInput(f"--format is {formats!r}: give excel with --csv, or leave it out.")
        _tabulate(dataset, file, out, named, "\ufeff" * ("excel" in chosen))
        return
    if "excel" in chosen:  # a figure has no such format
        raise InvalidInput("--format has excel, which is for a table: give --csv too.")
    if named and "case_status" not in dataset:
        option = "--plot" if plot else "a name"
        raise InvalidInput(f"{option} is for a study or --csv, and not for the picture of a solution: leave it out.")
    folder = open_folder(out or file.parent)
    with drawing(str(file), "its variables do not fit a figure; --csv prints them."):
        if "html" in chosen:
            from studies.cli.exports import page_of

            # not FILE.html, which may be a chapter of the report
            write_text(page_of(dataset, file.stem), folder / f"{file.stem}-explore.html")
        if "vtk" in chosen:
            from studies.cli.exports import write_vtk

            for path in write_vtk(dataset, file, folder / file.stem):
                click.echo(f"wrote {path}")
        drawn = _figures(context, dataset, file, named) if pictures else {}
    _save(drawn, folder, pictures)


def _figures(context: click.Context, dataset: "xr.Dataset", file: Path, names: Sequence[str]) -> "dict[str, Figure]":
    """Return the figures of a dataset in a file by the stems of their files."""
    if "case_status" not in dataset:
        from contactstudy.io.pictures import picture_of

        if (picture := picture_of(dataset)) is not None:
            return {file.stem: picture}
        raise InvalidInput(f"{str(file)!r} is no solution and no study: give what contactstudy solve or run wrote.")
    from studies.registry import BUILT_IN, default_drawing, load_drawing

    name = str(dataset.attrs.get("study", file.stem))
    if name in BUILT_IN:
        refuse(context, "a study without figures of its own", "plot", "names")
    figures_of = load_drawing(name) if name in BUILT_IN else default_drawing(names)
    return {f"{file.stem}-{item.name}": item.figure for item in figures_of.figure(dataset)}


def _tabulate(dataset: "xr.Dataset", file: Path, out: Path | None, names: Sequence[str], mark: str) -> None:
    """Print a table as CSV after a `mark`, or write it to a folder, and say how many columns it leaves out."""
    from studies.cli.exports import csv_of
    from studies.store.netcdf import open_folder

    with drawing(str(file), "its variables do not fit a table."):
        table, left_out = csv_of(dataset, file, names)
    if out is None:
        click.echo(mark + table, nl=False)
    else:
        write_text(mark + table, open_folder(out) / f"{file.stem}.csv")
    if left_out and not names:
        click.echo(f"{file}: {left_out} further columns, such as iterations: name them, or all", err=True)


def surfaces_of(file: Path, extent: str | None, **reading: Any) -> dict[str, MeasuredSurface]:
    """Return the measured surfaces of a file or of a scene by the stems of their pictures; none for another file."""
    sides: Any = None if extent is None else [side.strip() for side in extent.split(",")]
    if sides and len(sides) != 2:
        raise InvalidInput(f"--extent is {extent!r}: give a width and a length, such as '1 mm, 2 mm'.")
    if file.suffix == ".toml":
        shapes = enumerate(cs.read_scene(file).scene.shapes)
        matching = {
            f"{file.stem}-shapes-{number}": shape for number, shape in shapes if isinstance(shape, MeasuredSurface)
        }
        if not matching:
            raise InvalidInput(f"{str(file)!r} has no measured surface: give one that has, or the .nc of its solve.")
        return matching
    if not file.is_file() or (file.suffix == ".nc" and not _holds_heights(file)):
        return {}
    missing, seam = cs.HarmonicFill(up_to=0.5), cs.AsMeasured()
    try:
        return {file.stem: MeasuredSurface.read(file, extent=sides, missing=missing, seam=seam, **reading)}
    except InvalidInput as error:  # its fields are options here
        options = "|".join(("extent", *reading))
        raise InvalidInput(re.sub(rf"MeasuredSurface\.({options})\b", r"--\1", str(error))) from None


def _holds_heights(file: Path) -> bool:
    """Return whether a netCDF file holds heights alone, and no solution or study."""
    from studies.store.netcdf import read_any

    dataset = read_any(file)
    return "heights" in dataset and not {"gap", "case_status"} & set(dataset.variables)


def drawn_surfaces(surfaces: dict[str, MeasuredSurface], shown: "tuple[Heights, ...]") -> "dict[str, Figure]":
    """Print what was done to surfaces, and their parameters; return their pictures."""
    from contactstudy.io.pictures import surface_picture
    from contactstudy.io.quantities.surface_parameters import parameters_text, surface_parameters

    for name, surface in surfaces.items():
        click.echo(f"{name}: {surface.description}")
        for line in parameters_text(surface_parameters(surface)):
            click.echo(f"  {line}")
    return {name: surface_picture(surface, shown) for name, surface in surfaces.items()}


# Remedy where a figure fails.
REMEDY_IN_CODE = "the stored variables do not fit the figure, or its code is wrong; correct it and run again."


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
    for stem, figure in drawn.items():
        for path in write_figure(figure, folder / stem, formats):
            click.echo(f"wrote {path}")


@click.command()
@click.argument("first", metavar="A", type=click.Path(path_type=Path))
@click.argument("second", metavar="B", type=click.Path(path_type=Path))
@out_option("Folder for a picture of the difference.  [default: none is drawn]", None)
@click.pass_context
def compare(context: click.Context, /, first: Path, second: Path, out: Path | None) -> None:
    """Print how B differs from A.

    Both are solutions on any grids of one period, or runs of one study.
    """
    from studies.report.changes import changes
    from studies.store.netcdf import open_folder, read_any

    a, b = read_any(first), read_any(second)
    of_studies = {"case_status" in a, "case_status" in b}
    if of_studies == {False} and "pressure" in a and "pressure" in b:
        comparison = cs.compare(a, b)
        for line in str(comparison).splitlines():
            click.echo(line)
        if out is not None:
            drawn = {f"{first.stem}-{second.stem}": comparison.plot()}
            _save(drawn, open_folder(out), ["png"])
    elif of_studies == {True}:
        refuse(context, "two solutions, and not for two runs of a study", "out")
        for line in changes(a, b):
            click.echo(line)
    else:
        raise InvalidInput(
            f"{str(first)!r} and {str(second)!r} are of different kinds: give two solutions or two runs."
        )
