"""``contactstudy explore FILE.nc``: one HTML file to look into a study or a contact, which works offline."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from contactstudy import InvalidInput
from contactstudy.domain.imports import import_for

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
@click.option(
    "--out", type=click.Path(path_type=Path), help="Folder of the page.  [default: that of FILE]"
)
def explore(file: Path, out: Path | None) -> None:
    """Write one HTML page to look into FILE, a study or a solution, in any browser, without a network."""
    from contactstudy.domain.files import replacing
    from studies.store.netcdf import open_folder, read_any

    path = open_folder(out or file.parent) / f"{file.stem}.html"
    page = page_of(read_any(file), file.stem)
    with replacing(path) as partial:
        partial.write_text(page, encoding="utf-8")
    click.echo(f"wrote {path}")


def page_of(dataset: "xr.Dataset", name: str) -> str:
    """Return a page that stands alone, for a stored study or solution.

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


def study_chart(altair: Any, dataset: "xr.Dataset") -> Any:
    """Return a chart of any variable over any axis, coloured by another, with a slider for each axis left."""
    axes = [str(axis) for axis in dataset["case_status"].dims]
    table, variables = _points(dataset, axes)
    texts = {
        axis: [str(v) for v in dataset[axis].values]
        for axis in axes
        if dataset[axis].dtype.kind not in "if"
    }
    labels = {name: _label(dataset, name) for name in [*axes, *variables]}
    first = next(
        (name for name in ("peak_pressure", "largest_pressure") if name in variables), variables[0]
    )
    colour = axes[1] if len(axes) > 1 else "none"
    logarithmic = _spans_decades(table[axes[0]])
    params = [
        _choice(altair, "xaxis", "x axis ", axes, axes[0]),
        _choice(altair, "variable", "variable ", variables, first),
        _choice(altair, "colour", "colour ", ["none", *axes], colour),
        altair.param(
            "logx", bind=altair.binding_checkbox(name="logarithmic x "), value=logarithmic
        ),
        altair.param("logy", bind=altair.binding_checkbox(name="logarithmic y "), value=False),
        altair.param("texts", value=texts),
        altair.param("labels", value=labels),
    ]
    shown = ["true"]
    for number, axis in enumerate(axes if len(axes) > 1 else []):
        last = dataset.sizes[axis] - 1
        slider = altair.binding_range(min=0, max=last, step=1, name=f"{labels[axis]}: value no. ")
        params.append(altair.param(f"at{number}", bind=slider, value=last // 2))
        shown.append(
            f"(xaxis == '{axis}' || colour == '{axis}' || datum['no. {axis}'] == at{number})"
        )
    values = {axis: [_plain(v) for v in dataset[axis].values] for axis in axes}
    fixed = "".join(
        f" + ((xaxis == '{axis}' || colour == '{axis}') ? '' : ', {labels[axis]} = ' + values['{axis}'][at{number}])"
        for number, axis in enumerate(axes if len(axes) > 1 else [])
    )
    params.append(altair.param("values", value=values))
    x = "(texts[xaxis] ? datum['no. ' + xaxis] : (logx ? log(datum[xaxis]) / LN10 : datum[xaxis]))"
    y = "(logy ? log(datum[variable]) / LN10 : datum[variable])"
    readings = "(texts[xaxis] ? texts[xaxis][datum.value] : format(logx ? pow(10, datum.value) : datum.value, '.3~g'))"
    tooltip = [altair.Tooltip(f"{axis}:N") for axis in axes] + [
        altair.Tooltip("v:Q", title="value", format=".4~g"),
        altair.Tooltip("case:N", title="case"),
    ]
    number_y = "format(logy ? pow(10, datum.value) : datum.value, '.3~g')"
    scale = altair.Scale(zero=False)
    points = (
        altair.Chart(table)
        .transform_filter(" && ".join(shown))
        .transform_calculate(
            x=x, y=y, v="datum[variable]", c="colour == 'none' ? 'all' : toString(datum[colour])"
        )
        .transform_filter("isValid(datum.v) && isFinite(datum.y) && isFinite(datum.x)")
        .encode(
            x=altair.X("x:Q", title=None, scale=scale, axis=altair.Axis(labelExpr=readings)),
            y=altair.Y("y:Q", title=None, scale=scale, axis=altair.Axis(labelExpr=number_y)),
            color=altair.Color(
                "c:N", sort=None, title=None, legend=altair.Legend(orient="bottom", columns=3)
            ),
            tooltip=tooltip,
        )
    )
    heading = altair.expr(f"labels[variable] + ' over ' + labels[xaxis]{fixed}")
    return (
        altair.layer(points.mark_line(), points.mark_point(filled=True, size=60))
        .add_params(*params)
        .properties(
            width="container", height=360, title=altair.Title(heading, anchor="start", limit=2000)
        )
    )


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
    words = dict(
        zip(
            np.atleast_1d(status["flag_values"]).tolist(),
            str(status["flag_meanings"]).split(),
            strict=True,
        )
    )
    table["case"] = [words.get(int(value), "?") for value in table.pop("case_status")]
    return table, variables


def contact_chart(altair: Any, dataset: "xr.Dataset") -> Any:
    """Return a map of a contact, and the cross-section at the place that the pointer was last over."""
    factors = [
        max(1, int(np.ceil(np.sqrt(dataset.sizes["x"] * dataset.sizes["y"] / MOST_CELLS))))
    ] * 2
    factors[1] = min(factors[1], dataset.sizes["y"])
    coarse = (
        dataset[["pressure", "gap"]].coarsen(x=factors[0], y=factors[1], boundary="trim").mean()
    )
    table = (
        coarse.drop_vars([n for n in coarse.coords if n not in ("x", "y")])
        .to_dataframe()
        .reset_index()
    )
    table = table.astype(float)
    table["x"], table["y"] = (table[axis] * 1e3 for axis in ("x", "y"))
    table["pressure"], table["gap"] = table["pressure"] / 1e6, table["gap"] * 1e6
    table = table.map(lambda value: float(f"{value:.5g}"))
    labels = {"pressure": "pressure [MPa]", "gap": "gap [µm]"}
    field = _choice(altair, "field", "field ", list(labels), "pressure")
    section = (
        altair.Chart(table)
        .transform_calculate(v="datum[field]")
        .mark_line()
        .encode(
            x=altair.X("x:Q", title="across [mm]"),
            y=altair.Y("v:Q", title=None),
            tooltip=[
                altair.Tooltip(name, format=".4~g")
                for name in ("x:Q", "y:Q", "pressure:Q", "gap:Q")
            ],
        )
        .properties(width=NARROW, height=220)
    )
    names = altair.param("labels", value=labels)
    if coarse.sizes["y"] == 1:
        heading = altair.Title(altair.expr("labels[field]"), anchor="start")
        return section.add_params(field, names).properties(title=heading)
    middle = float(table["y"].iloc[coarse.sizes["y"] // 2])
    pointer = altair.selection_point(
        "at", on="pointerover", fields=["y"], value=middle, empty=False
    )
    steps = [float(np.diff(coarse[axis].values[:2])[0]) * 1e3 for axis in ("x", "y")]
    cells = (
        altair.Chart(table)
        .transform_calculate(
            v="datum[field]", x2=f"datum.x + {1.04 * steps[0]}", y2=f"datum.y + {1.04 * steps[1]}"
        )
        .mark_rect()
        .encode(
            x=altair.X("y:Q", title="along [mm]", scale=altair.Scale(nice=False)),
            x2="y2:Q",
            y=altair.Y("x:Q", title="across [mm]", scale=altair.Scale(nice=False)),
            y2="x2:Q",
            color=altair.Color(
                "v:Q",
                title=None,
                scale=altair.Scale(scheme="viridis"),
                legend=altair.Legend(orient="bottom"),
            ),
            tooltip=[
                altair.Tooltip(name, format=".4~g")
                for name in ("x:Q", "y:Q", "pressure:Q", "gap:Q")
            ],
        )
        .properties(
            width=NARROW,
            height=260,
            title=altair.Title(altair.expr("labels[field]"), anchor="start"),
        )
        .add_params(pointer)
    )
    heading = altair.Title(
        altair.expr(
            "labels[field] + ' across at y = ' + (at.y ? format(at.y[0], '.3~g') + ' mm' : '')"
        ),
        anchor="start",
    )
    return altair.vconcat(
        cells, section.transform_filter(pointer).properties(title=heading)
    ).add_params(field, names)


def _choice(altair: Any, name: str, label: str, options: list[str], value: str) -> Any:
    return altair.param(name, bind=altair.binding_select(options=options, name=label), value=value)


def _label(dataset: "xr.Dataset", name: str) -> str:
    attributes = dataset[name].attrs
    units = attributes.get("units", "1")
    text = str(attributes.get("long_name", name))
    return text if units == "1" else f"{text} [{units}]"


def _plain(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _spans_decades(values: "pd.Series[Any]") -> bool:
    numbers = values.to_numpy()
    return bool(
        numbers.dtype.kind in "if" and numbers.min() > 0 and numbers.max() > 30 * numbers.min()
    )
