"""``contactstudy explore FILE.nc``: one HTML page that shows a study or a contact interactively, without a network."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from contactstudy import InvalidInput
from contactstudy.domain.imports import import_for
from studies.cli.options import out_option

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

# Cells of a map that a page holds; a finer contact is shown by the means of blocks of cells.
MOST_CELLS = 20_000
NARROW = 280  # width of a map [px] that a telephone shows whole
STYLE = """<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
  body { margin: 0.5em; font-family: sans-serif }
  #vis.vega-embed { display: flex; flex-direction: column }
  .vega-bind { margin: 0.3em 0 }
</style>
"""


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@out_option("Folder of the page.  [default: that of FILE]", None)
def explore(file: Path, out: Path | None) -> None:
    """Write one HTML page to look into FILE, a study or a solution, in any browser, without a network."""
    from contactstudy.domain.files import replacing
    from studies.store.netcdf import open_folder, read_any

    # not FILE.html, which may be a chapter of the report
    path = open_folder(out or file.parent) / f"{file.stem}-explore.html"
    page = page_of(read_any(file), file.stem)
    with replacing(path) as partial:
        partial.write_text(page, encoding="utf-8")
    click.echo(f"wrote {path}")


def page_of(dataset: "xr.Dataset", name: str) -> str:
    """Return the self-contained HTML page of a stored study or solution.

    Raises :class:`~contactstudy.InvalidInput` for a dataset of another kind.
    """
    altair = import_for("contactstudy explore", "altair")
    import_for("contactstudy explore", "vl_convert")  # which holds the scripts of the page
    if "case_status" in dataset:
        chart, renderer = study_chart(altair, dataset), "svg"
    elif "pressure" in dataset and dataset["pressure"].dims == ("x", "y"):
        chart, renderer = contact_chart(altair, dataset), "canvas"  # of many thousand cells
    else:
        raise InvalidInput(
            f"{name} is neither a solution nor a study: give a file that contactstudy solve or run wrote."
        )
    with altair.data_transformers.enable("default", max_rows=None):
        page = str(
            chart.to_html(inline=True, embed_options={"actions": False, "renderer": renderer})
        )
    title = f"<title>{name}: {dataset.attrs.get('title', 'contact')}</title>\n"
    return page.replace("<head>", f"<head>\n{title}{STYLE}", 1)


# What is drawn, in Vega's expressions: `xaxis`, `variable`, `colour`, `logx` and `logy` are the reader's choices.
X = "(texts[xaxis] ? datum['no. ' + xaxis] : (logx ? log(datum[xaxis]) / LN10 : datum[xaxis]))"
Y = "(logy ? log(datum[variable]) / LN10 : datum[variable])"
X_LABEL = "(texts[xaxis] ? texts[xaxis][datum.value] : format(logx ? pow(10, datum.value) : datum.value, '.3~g'))"
Y_LABEL = "format(logy ? pow(10, datum.value) : datum.value, '.3~g')"
COLOUR = "colour == 'none' ? 'all' : isNumber(datum[colour]) ? format(datum[colour], '.4~g') : datum[colour]"
BY = "(colour == 'none' ? '' : ', by ' + labels[colour])"


def study_chart(altair: Any, dataset: "xr.Dataset") -> Any:
    """Return a chart of any variable over any axis, coloured by another, with a slider for each further axis."""
    axes = [str(axis) for axis in dataset["case_status"].dims]
    table, variables = _points(dataset, axes)
    sliders = _sliders(altair, dataset, axes)
    chosen = [f"(xaxis == '{axis}' || colour == '{axis}')" for axis in sliders]
    at_slider = [f"datum['no. {axis}'] == at{number}" for number, axis in enumerate(sliders)]
    shown = [f"({free} || {at})" for free, at in zip(chosen, at_slider, strict=True)]
    fixed = "".join(
        f" + ({free} ? '' : ', ' + labels['{axis}'] + ' = ' + values['{axis}'][at{number}])"
        for number, (axis, free) in enumerate(zip(sliders, chosen, strict=True))
    )
    scale = altair.Scale(zero=False)
    legend = altair.Legend(orient="bottom", columns=3)
    points = (
        altair.Chart(table)
        .transform_filter(" && ".join(shown) or "true")
        .transform_calculate(x=X, y=Y, v="datum[variable]", c=COLOUR)
        .transform_filter("isValid(datum.v) && isFinite(datum.y) && isFinite(datum.x)")
        .encode(
            x=altair.X("x:Q", title=None, scale=scale, axis=altair.Axis(labelExpr=X_LABEL)),
            y=altair.Y("y:Q", title=None, scale=scale, axis=altair.Axis(labelExpr=Y_LABEL)),
            color=altair.Color("c:N", sort=None, title=None, legend=legend),
            tooltip=[
                *(altair.Tooltip(f"{axis}:N") for axis in axes),
                altair.Tooltip("v:Q", title="value", format=".4~g"),
                altair.Tooltip("case:N", title="case"),
            ],
        )
    )
    heading = altair.expr(f"labels[variable] + ' over ' + labels[xaxis] + {BY}{fixed}")
    return (
        altair.layer(points.mark_line(), points.mark_point(filled=True, size=60))
        .add_params(*_choices(altair, dataset, axes, variables, table), *sliders.values())
        .properties(
            width="container", height=360, title=altair.Title(heading, anchor="start", limit=2000)
        )
    )


def _choices(
    altair: Any,
    dataset: "xr.Dataset",
    axes: list[str],
    variables: list[str],
    table: "pd.DataFrame",
) -> list[Any]:
    """Return the parameters of the chart: the choices of the reader, and the texts and labels of the axes."""
    texts = {
        axis: [str(value) for value in dataset[axis].values]
        for axis in axes
        if dataset[axis].dtype.kind not in "if"
    }
    first = next(
        (name for name in ("peak_pressure", "largest_pressure") if name in variables), variables[0]
    )
    box = altair.binding_checkbox
    return [
        _choice(altair, "xaxis", "x axis ", axes, axes[0]),
        _choice(altair, "variable", "variable ", variables, first),
        _choice(altair, "colour", "colour ", ["none", *axes], axes[1] if axes[1:] else "none"),
        altair.param("logx", bind=box(name="logarithmic x "), value=_spans_decades(table[axes[0]])),
        altair.param("logy", bind=box(name="logarithmic y "), value=False),
        altair.param("texts", value=texts),
        altair.param("labels", value={name: _label(dataset, name) for name in [*axes, *variables]}),
        altair.param(
            "values", value={axis: [_plain(v) for v in dataset[axis].values] for axis in axes}
        ),
    ]


def _sliders(altair: Any, dataset: "xr.Dataset", axes: list[str]) -> dict[str, Any]:
    """Return a slider for each of several axes, by the name of the axis."""
    sliders = {}
    for number, axis in enumerate(axes if len(axes) > 1 else []):
        last = dataset.sizes[axis] - 1
        name = f"{_label(dataset, axis)}: value no. "
        binding = altair.binding_range(min=0, max=last, step=1, name=name)
        sliders[axis] = altair.param(f"at{number}", bind=binding, value=last // 2)
    return sliders


def _points(dataset: "xr.Dataset", axes: list[str]) -> "tuple[pd.DataFrame, list[str]]":
    """Return a row for each point, with the place on each axis and the status of its case, and the variables."""
    names = [
        str(name)
        for name, variable in dataset.data_vars.items()
        if set(variable.dims) == set(axes)
        and variable.dtype.kind in "fi"
        and "flag_values" not in variable.attrs
    ]
    variables = [name for name in names if np.isfinite(dataset[name].values).any()]
    if not variables:
        raise InvalidInput("The study has no numbers over its axes: run its cases first.")
    flat = dataset[[*variables, "case_status"]]
    flat = flat.drop_vars([name for name in flat.coords if name not in axes])
    table = flat.to_dataframe(dim_order=axes).reset_index()
    for axis in axes:
        place = {value: number for number, value in enumerate(dataset[axis].values.tolist())}
        table[f"no. {axis}"] = [place[value] for value in table[axis]]
    status = dataset["case_status"].attrs
    values = np.atleast_1d(status["flag_values"]).tolist()
    words = dict(zip(values, str(status["flag_meanings"]).split(), strict=True))
    table["case"] = [words.get(int(value), "?") for value in table.pop("case_status")]
    return table, variables


# Fields of a contact that a page shows, with the factor to the unit in brackets.
FIELDS = {"pressure": ("pressure [MPa]", 1e-6), "gap": ("gap [µm]", 1e6)}


def contact_chart(altair: Any, dataset: "xr.Dataset") -> Any:
    """Return a map of a contact, with the cross-section at the last position of the pointer."""
    table, steps = _cells(dataset)
    labels = {name: label for name, (label, _) in FIELDS.items()}
    choices = [
        _choice(altair, "field", "field ", list(labels), "pressure"),
        altair.param("labels", value=labels),
    ]
    tooltip = [altair.Tooltip(f"{name}:Q", format=".4~g") for name in ("x", "y", *labels)]
    section = (
        altair.Chart(table)
        .transform_calculate(v="datum[field]")
        .mark_line()
        .encode(
            x=altair.X("x:Q", title="across [mm]"),
            y=altair.Y("v:Q", title=None),
            tooltip=tooltip,
        )
        .properties(width=NARROW, height=220)
    )
    heading = altair.Title(altair.expr("labels[field]"), anchor="start")
    places = np.unique(table["y"])
    if len(places) == 1:
        return section.add_params(*choices).properties(title=heading)
    middle = float(places[len(places) // 2])
    pointer = altair.selection_point(
        "at", on="pointerover", fields=["y"], value=middle, empty=False
    )
    viridis, below_map = altair.Scale(scheme="viridis"), altair.Legend(orient="bottom")
    straight = altair.Scale(nice=False)
    cells = (
        altair.Chart(table)
        .transform_calculate(  # to beyond the next cell, so that no seams show
            v="datum[field]", x2=f"datum.x + {1.04 * steps[0]}", y2=f"datum.y + {1.04 * steps[1]}"
        )
        .mark_rect()
        .encode(
            x=altair.X("y:Q", title="along [mm]", scale=straight),
            x2="y2:Q",
            y=altair.Y("x:Q", title="across [mm]", scale=straight),
            y2="x2:Q",
            color=altair.Color("v:Q", title=None, scale=viridis, legend=below_map),
            tooltip=tooltip,
        )
        .properties(width=NARROW, height=260, title=heading)
        .add_params(pointer)
    )
    at = "labels[field] + ' across at y = ' + (at.y ? format(at.y[0], '.3~g') + ' mm' : '')"
    below = section.transform_filter(pointer).properties(
        title=altair.Title(altair.expr(at), anchor="start")
    )
    return altair.vconcat(cells, below).add_params(*choices)


def _cells(dataset: "xr.Dataset") -> "tuple[pd.DataFrame, list[float]]":
    """Return a row for each cell, or block of cells of a fine grid, and the sides of a cell or block [mm]."""
    cells_in_block = dataset.sizes["x"] * dataset.sizes["y"] / MOST_CELLS
    block = max(1, int(np.ceil(np.sqrt(cells_in_block))))
    coarse = dataset[list(FIELDS)]
    coarse = coarse.coarsen(x=block, y=min(block, dataset.sizes["y"]), boundary="trim").mean()
    for name, (_, factor) in FIELDS.items():
        coarse[name] = coarse[name] * factor
    coarse = coarse.assign_coords({axis: coarse[axis] * 1e3 for axis in ("x", "y")})
    labels = [name for name in coarse.coords if name not in ("x", "y")]
    table = coarse.drop_vars(labels).to_dataframe().reset_index().astype(float)
    steps = [float(np.diff(coarse[axis].values[:2]).sum()) for axis in ("x", "y")]
    return table.map(lambda value: float(f"{value:.5g}")), steps


def _choice(altair: Any, name: str, label: str, options: list[str], value: str) -> Any:
    """Return a parameter with a list of options."""
    return altair.param(name, bind=altair.binding_select(options=options, name=label), value=value)


def _label(dataset: "xr.Dataset", name: str) -> str:
    """Return the long name of a variable with its unit."""
    attributes = dataset[name].attrs
    units = attributes.get("units", "1")
    text = str(attributes.get("long_name", name))
    return text if units == "1" else f"{text} [{units}]"


def _plain(value: object) -> str:
    """Return a value of an axis as text."""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _spans_decades(values: "pd.Series[Any]") -> bool:
    """Return whether positive numbers span more than a factor of 30."""
    numbers = values.to_numpy()
    return bool(
        numbers.dtype.kind in "if" and numbers.min() > 0 and numbers.max() > 30 * numbers.min()
    )
