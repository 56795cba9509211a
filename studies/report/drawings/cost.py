"""Drawings of the studies of cost: solvers, speed, each effect, and other programs."""

from itertools import product

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from contactstudy.domain.fields import Array
from studies.definitions.effect_cost import COARSER, IN_TIME, PERIOD, WIDTH, YIELD
from studies.definitions.peers import PROGRAMS
from studies.definitions.solvers import SOLVERS
from studies.definitions.speed import LINE, ROUGH, SELF_AFFINE
from studies.model.drawing import CaptionedFigure, Drawing, Finding
from studies.model.outcome import CaseStatus
from studies.model.plain_text import thread_count
from studies.reference.line_contact import total_time
from studies.report.style import COLORS, LAW_STYLE, add_legend, panels, percent, power

# solvers


TITLES = {"preconditioned_cg": "preconditioned CG", "polonsky_keer": "Polonsky & Keer"}
SOLVERS_COLORS = dict(zip(SOLVERS, COLORS, strict=False))
SOLVERS_LINES = {"smooth": "-", "wavy": "--", "rough": ":"}


def _solvers_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw time, iterations and convolutions against the grid, with the growth of each fitted."""
    cells = dataset["grid"].values
    fig, axes = panels(3)
    labels = {
        "solve_time": "wall time to solve [s]",
        "iterations": "iterations",
        "convolutions": "transform pairs of the full grid",
    }
    for ax, (variable, label) in zip(axes, labels.items(), strict=True):
        for solver in (str(name) for name in dataset["solver"].values):
            for surface in (str(name) for name in dataset["surface"].values):
                line = dataset[variable].sel(solver=solver, surface=surface)
                style = {
                    "color": SOLVERS_COLORS[solver],
                    "linestyle": SOLVERS_LINES[surface],
                    "marker": "o",
                }
                ax.loglog(cells, line, label=f"{TITLES[solver]}, {surface}", **style)
        if variable == "solve_time":
            least = float(dataset[variable].isel(grid=0).min())
            ax.loglog(cells, least * (cells / cells[0]) ** 2, label="N²", **LAW_STYLE)
        ax.set(xlabel="cells N across, and along but for a line", ylabel=label)
        ax.set_xticks(cells, [str(n) for n in cells])
        ax.minorticks_off()
    add_legend(fig)
    return (CaptionedFigure("solvers", fig, _solvers_caption(dataset)),)


def _solvers_caption(dataset: xr.Dataset) -> str:
    facts = []
    finest = dataset.isel(grid=-1)
    for solver in (str(name) for name in dataset["solver"].values):
        part = finest.sel(solver=solver)
        growth = ""
        if dataset.sizes["grid"] > 1:
            times = dataset["solve_time"].sel(solver=solver)
            rates = [
                np.polyfit(np.log(dataset["grid"].values), np.log(times.sel(surface=s).values), 1)[
                    0
                ]
                for s in dataset["surface"].values
            ]
            growth = f", growing like {power('N', min(rates), 1)} to {power('N', max(rates), 1)}"
        facts.append(
            f"{TITLES[solver]}: {int(part['iterations'].min())} to "
            f"{int(part['iterations'].max())} iterations, {float(part['solve_time'].min()):.2g} to "
            f"{float(part['solve_time'].max()):.2g} s{growth}, at most "
            f"{float(part['memory'].max()):.0f} fields of memory"
        )
    return (
        "Cost of a solve with exact periodicity to a residual of 1e-8, on one thread, without "
        f"set-up. At {int(finest['grid'])} x {int(finest['grid'])} cells, " + "; ".join(facts) + "."
    )


def _solvers_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return which solver is the faster."""
    solvers = set(dataset["solver"].values.tolist())
    if not solvers >= set(SOLVERS) or not (dataset["case_status"] == CaseStatus.OK).all():
        return ()
    finest = dataset.isel(grid=-1)
    new, old = (finest.sel(solver=name) for name in ("preconditioned_cg", "polonsky_keer"))
    facts = "; ".join(
        f"{surface}: "
        + " against ".join(
            f"{int(part['iterations'])} iterations in {float(part['solve_time']):.2g} s"
            for part in (solver.sel(surface=surface) for solver in (new, old))
        )
        for surface in finest["surface"].values.tolist()
    )
    ratio = old["solve_time"] / new["solve_time"]
    return (
        Finding(
            f"Preconditioned conjugate gradients: {float(ratio.min()):.1f} to {float(ratio.max()):.1f} times "
            "faster than the scheme of Polonsky & Keer.",
            f"At {int(finest['grid'])} x {int(finest['grid'])} cells, against Polonsky & Keer: {facts}.",
            "Which solver?",
        ),
    )


solvers = Drawing(_solvers_figures, _solvers_findings, axes=("solver", "surface", "grid"))


# speed


SPEED_LINES = ("-", "--", ":", "-.")
FAMILY = ("hurst", "cut_off", "share")
WAYS = ("precision", "device", "threads")
FIRST = dict.fromkeys(WAYS, 0)
LABELS = {
    "solve_time": "wall time to solve [s]",
    "iterations": "iterations",
    "transform_ratio": "time over that of bare transforms",
}


def _speed_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw time, iterations and the ratio to bare transforms against the grid, a line for each surface."""
    cells = dataset["grid"].values
    fig, axes = panels(len(LABELS))
    for ax, (variable, label) in zip(axes, LABELS.items(), strict=True):
        values = dataset[variable]
        for number, (name, surface) in enumerate(_surfaces(dataset).items()):
            for line, (how, chosen) in enumerate(_ways(dataset).items()):
                style = {
                    "color": COLORS[number % len(COLORS)],
                    "linestyle": SPEED_LINES[line % len(SPEED_LINES)],
                    "marker": "o",
                }
                ax.semilogx(cells, values.sel(surface | chosen), label=f"{name}{how}", **style)
                if variable == "iterations":
                    break  # they are the same on any number of threads
        if variable == "solve_time":
            least = float(values.isel(grid=0).min())
            ax.semilogx(cells, least * (cells / cells[0]) ** 2, label="N²", **LAW_STYLE)
            ax.set_yscale("log")
        else:
            ax.set_ylim(bottom=0)
        ax.set(xlabel="cells N across, and along but for a line", ylabel=label)
        ax.set_xticks(cells, [str(n) for n in cells])
        ax.minorticks_off()
    add_legend(fig)
    return (CaptionedFigure("speed", fig, _speed_caption(dataset)),)


def _surfaces(dataset: xr.Dataset) -> dict[str, dict[str, object]]:
    """Return the selection of each surface, by its name, which tells the values of axes that have several."""
    selections: dict[str, dict[str, object]] = {}
    for surface in dataset["surface"].values.tolist():
        if surface == SELF_AFFINE:
            for values in product(*(dataset[axis].values.tolist() for axis in FAMILY)):
                chosen = dict(zip(FAMILY, values, strict=True))
                words = {
                    "hurst": f", H = {chosen['hurst']:g}",
                    "cut_off": f", down to {chosen['cut_off']:g} cells",
                    "share": f", {percent(chosen['share'])} in contact",
                }
                varied = [words[axis] for axis in FAMILY if dataset.sizes[axis] > 1]
                name = f"{SELF_AFFINE}{''.join(varied)}"
                selections[name] = {"surface": surface, **chosen}
        else:
            first = {axis: dataset[axis].values.tolist()[0] for axis in FAMILY}
            selections[surface] = {"surface": surface, **first}
    return selections


def _ways(dataset: xr.Dataset) -> dict[str, dict[str, object]]:
    """Return the selections of precision, device and threads, by words that follow the name of a surface."""
    precisions, devices, threads = (dataset[axis].values.tolist() for axis in WAYS)
    selections: dict[str, dict[str, object]] = {}
    for precision, device, count in product(precisions, devices, threads):
        words = [precision] * (len(precisions) > 1)
        words += [device] * (len(devices) > 1)
        words += [thread_count(count)] * (len(threads) > 1 and device == "cpu")
        chosen = {"precision": precision, "device": device, "threads": count}
        selections.setdefault("".join(f", {word}" for word in words), chosen)
    return selections


def _speed_caption(dataset: xr.Dataset) -> str:
    finest = dataset.isel(FIRST | {"grid": -1})
    shortest = " or ".join(f"{cells:g}" for cells in dataset["cut_off"].values)
    facts = [
        f"{name}: {int(part['iterations'])} iterations in {float(part['solve_time']):.2g} s, "
        f"{percent(part['contact_share'])} in contact, {float(part['memory']):.0f} fields of memory"
        for name, part in _each(finest)
    ]
    return (
        f"Cost of a solve against the grid, without set-up. {ROUGH.capitalize()} is a rough cylinder, semi-periodic, "
        f"the same surface on every grid; a {LINE} is a smooth cylinder with one cell along; a "
        "self-affine one is flat, periodic along both axes, and has waves down "
        f"to {shortest} cells of every grid. At {int(finest['grid'])} x {int(finest['grid'])} cells, on "
        f"{_where(finest)}, {'; '.join(facts)}. Bare transforms are as many as the solve takes, of the full grid."
    )


def _where(one: xr.Dataset) -> str:
    return thread_count(one["threads"]) if one["device"] == "cpu" else "a graphics processor"


def _each(dataset: xr.Dataset) -> list[tuple[str, xr.Dataset]]:
    return [(name, dataset.sel(chosen)) for name, chosen in _surfaces(dataset).items()]


def _speed_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return how the cost grows, and the time that threads save."""
    if dataset.sizes["grid"] < 2 or not (dataset["case_status"] == CaseStatus.OK).all():
        return ()
    first, last = dataset.isel(grid=0), dataset.isel(grid=-1)
    growth = float((last["iterations"] / first["iterations"]).max())
    facts = "; ".join(
        f"{name}: {int(part['iterations'][0])} to {int(part['iterations'][-1])}"
        for name, part in _each(dataset.isel(FIRST))
    )
    ratio = last["transform_ratio"].isel(FIRST)
    measured = (
        f"Iterations from {int(first['grid'])} to {int(last['grid'])} cells across: {facts}. At "
        f"{int(last['grid'])} cells a solve takes {float(ratio.min()):.1f} to {float(ratio.max()):.1f} times the "
        "time of its bare transforms"
    )
    threads = dataset["threads"].values.tolist()
    if len(threads) > 1 and str(dataset["device"].values[0]) == "cpu":
        times = last["solve_time"].isel(precision=0, device=0)
        faster = times.isel(threads=0) / times.isel(threads=-1)
        measured += (
            f", and is {float(np.min(faster)):.1f} to {float(np.max(faster)):.1f} times as fast on "
            f"{thread_count(threads[-1])} as on {thread_count(threads[0])} of this machine"
        )
    return (
        Finding(
            f"From {int(first['grid'])} to {int(last['grid'])} cells across, iterations grow by a factor of at most "
            f"{growth:.1f}.",
            f"{measured}.",
            "How does the cost grow?",
        ),
    )


speed = Drawing(_speed_figures, _speed_findings, axes=("surface", *FAMILY, *WAYS, "grid"))


# effect_cost


COLOR = "#0072B2"
# Rows of scenes that have not all effects above them.
ALONE = ("smooth", "one step", "two steps")


def _effect_cost_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw a bar for each scene: time, iterations, transforms and memory."""
    finest = dataset.isel(grid=-1)
    names = [str(name) for name in finest["effect"].values]
    place = np.arange(float(len(names)))
    fig, axes = panels(4, columns=2, width=3.6, height=0.6 + 0.32 * len(names), share="y")
    setup, solve = finest["setup_time"].values, finest["solve_time"].values
    axes[0].barh(place, setup, color="#E69F00", label="set-up")
    axes[0].barh(place, solve, left=setup, color=COLOR, label="solve and outputs")
    _numbers(axes[0], place, setup + solve, "{:.2g}")
    for ax, variable, form in (
        (axes[1], "memory", "{:.3g}"),
        (axes[2], "iterations", "{:.0f}"),
        (axes[3], "convolutions", "{:.0f}"),
    ):
        ax.barh(place, finest[variable].values, color=COLOR)
        _numbers(ax, place, finest[variable].values, form)
    for ax, label in zip(
        axes,
        ("wall time [s]", "peak memory [MB]", "iterations", "transform pairs of the solve"),
        strict=True,
    ):
        ax.set_xlabel(label)
        ax.grid(visible=False, axis="y")
    labels = [name if name.startswith(ALONE) else f"+ {name}" for name in names]
    axes[0].set_yticks(place, labels)
    axes[0].invert_yaxis()
    add_legend(fig)
    return (CaptionedFigure("effects", fig, _effect_cost_caption(finest)),)


def _numbers(ax: Axes, place: Array, values: Array, form: str) -> None:
    """Write the value of each bar at its end."""
    for y, value in zip(place, values, strict=True):
        ax.text(value, y, " " + form.format(value), va="center", fontsize="small")
    ax.margins(x=0.18)


def _effect_cost_caption(dataset: xr.Dataset) -> str:
    cells = int(dataset["grid"])
    words = (
        f"Cost of each effect: every scene has all effects above it and one more, but the sliding one has no "
        f"coating. {cells} x {cells // 4} "
        f"cells over {WIDTH:g} a x {PERIOD:g} a ({cells} x 1 for the first), exact periodicity, a residual of "
        "1e-8, one thread. Time and memory include set-up, solve and outputs."
    )
    both = ["smooth, 1-D", "smooth, 2-D"]
    if set(both) <= set(dataset["effect"].values.tolist()):
        time = total_time(dataset).sel(effect=both).values
        words += (
            " If nothing varies along the length, one cell along it gives the same pressure in "
            f"{percent(time[0] / time[1])} of the time. All heights are added to one field, so no shape needs "
            "more memory or longer transforms: a shape costs iterations. Stress adds no iterations, "
            "but it needs influence coefficients and transforms of its own, "
            "one for each of six components at each depth (here one depth), and as many again under shear. A coating "
            "costs set-up alone."
        )
    if YIELD in dataset["effect"].values.tolist():
        words += (
            " Yield is alone on the smooth cylinder, in plane strain, one cell along and "
            f"{cells // COARSER} across: the load comes in two steps, of which a solution of the contact is "
            "sought together with the plastic strain, and all contacts on the way count."
        )
    if set(IN_TIME) & set(dataset["effect"].values.tolist()):
        words += (
            " Creep and wear are alone on the wavy cylinder, a sudden load and one step in time: iterations and "
            "transform pairs are those of the step, which starts from the pressure before, while time "
            "and memory count both. A step adds at most one convolution to a solve."
        )
    return words


effect_cost = Drawing(_effect_cost_figures, axes=("effect", "grid"))


# peers


PEERS_COLORS = dict(zip(PROGRAMS, COLORS, strict=False))
PEERS_LINES = ("-", "--", ":", "-.")  # of each number of threads


def _peers_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw the total time against the grid, a panel for each boundary."""
    boundaries = [str(name) for name in dataset["boundary"].values]
    fig, axes = panels(len(boundaries), share="y")
    threads = dataset["threads"].values.tolist()
    time = total_time(dataset)
    facts = []
    for ax, boundary in zip(axes, boundaries, strict=True):
        for program, number in product(dataset["program"].values, range(len(threads))):
            chosen = {"program": program, "boundary": boundary, "threads": threads[number]}
            part = time.sel(chosen)
            if not np.isfinite(part).any():
                continue
            name = program if len(threads) == 1 else f"{program}, {thread_count(threads[number])}"
            line = {
                "color": PEERS_COLORS[str(program)],
                "linestyle": PEERS_LINES[number % len(PEERS_LINES)],
            }
            ax.loglog(dataset["grid"], part, marker="o", label=name, **line)
            finest = dataset.sel(chosen).isel(grid=-1)
            facts.append(
                f"{boundary}, {name} {float(part[-1]):.2g} s with a difference of "
                f"{float(finest['difference']):.0e}"
            )
        ax.set(title=boundary, xlabel="cells across and along")
        ax.set_xticks(dataset["grid"], [str(n) for n in dataset["grid"].values])
        ax.minorticks_off()
    axes[0].set_ylabel("wall time, set-up and solve [s]")
    add_legend(fig)
    return (
        CaptionedFigure(
            "peers",
            fig,
            f"Total time on {' or '.join(map(thread_count, threads))}. At {int(dataset['grid'][-1])} cells: "
            + "; ".join(facts)
            + ". "
            "The difference is the largest one from the converged solution for cells of constant pressure. On "
            "periodic surfaces the other programs represent the pressure as a sum of waves, which is another "
            "discretisation and not an error.",
        ),
    )


peers = Drawing(_peers_figures, axes=("program", "boundary", "threads", "grid"))
