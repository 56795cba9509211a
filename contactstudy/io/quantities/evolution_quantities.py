"""Quantities of a contact in time, and of one under repeated rolling, with their bounds.

Of a contact in time they are extremes over time, values at the end, and what is left behind: wear, slip, dents,
residual stress (:func:`evolution_quantities`). Of a history with adhesion they are also loads at which contact is lost
and made, and the net work (:func:`history_quantities`). Of repeated rolling they are what the last pass leaves
(:func:`passes_quantities`).
"""

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from contactstudy.domain.errors import MARGIN, ErrorParts
from contactstudy.domain.grid import Array
from contactstudy.domain.validation import readable
from contactstudy.evolution.march import kinks
from contactstudy.io.quantities.quantity import Quantity, per_length, roller_length, with_bound
from contactstudy.problem.problem import Field
from contactstudy.scene.loads import ChangingLoad, loads_between
from contactstudy.scene.scene import AnyLoad, PosedScene, Scene
from contactstudy.scene.solids.bodies import creeps
from contactstudy.solvers.solution import Status

if TYPE_CHECKING:
    from contactstudy.evolution.repeated_rolling import RepeatedRolling
    from contactstudy.evolution.time_stepper import Frame

NO_BOUND_OF_CELLS = "No bound: the errors of this load by cells and range are not estimated; those of a PullOff are."
NO_BOUND_OF_DEPTH = "No bound: the error of the peak pressure, which wears the largest depth, has none."
BEFORE_RECORDED = "No bound: the load is applied at 0 s, before the first recorded instant: record that one too."
NO_BOUND_OF_PASS = "No bound: on cells of twice the size nothing yields in the last pass."
# Bound of what a pass leaves behind over its change from cells of twice the size, and least cells in a half-width. The
# error was at most 1.9 times that change under elastic pressures of 4.3 and 4.6 k on 5 to 20 cells (k: yield stress in
# shear).
PASS_MARGIN, CELLS_OF_PASS = 2.0, 5
NO_BOUND_OF_FEW_CELLS = f"No bound: a half-width has fewer than {CELLS_OF_PASS} cells, give more."


def _magnitude(values: Iterable[float]) -> float:
    """Return the largest size of a force that may act either way."""
    return max(map(abs, values))


# Extremes over time: (name of a quantity of an instant, function that takes the extreme of its values, label).
EXTREMES: tuple[tuple[str, Callable[[Iterable[float]], float], str], ...] = (
    ("peak_pressure", max, "largest peak pressure in time"),
    ("largest_von_mises", max, "largest von Mises stress in time"),
    ("central_film", min, "lowest central film thickness in time"),
    ("minimum_film", min, "minimum film thickness in time"),
    ("friction_coefficient", _magnitude, "largest friction force over load in time, either way"),
    ("traction_coefficient", _magnitude, "largest tangential force over load in time, either way"),
    ("lateral_traction_coefficient", _magnitude, "largest lateral force over load in time, either way"),
    ("frictional_power", max, "largest frictional power in time"),
    ("rolling_resistance", max, "largest coefficient of rolling resistance in time"),
)
# Difference of two values of a history, over the largest, that is rounding.
HISTORY_ROUNDING = 1e-9
# Quantities of an instant whose last value is reported.
FINAL = (
    "peak_pressure", "contact_area", "approach", "central_film", "minimum_film", "friction_coefficient",
    "traction_coefficient", "lateral_traction_coefficient", "stick_fraction", "creepage", "frictional_power",
    "rolling_resistance",
)  # fmt: skip


def evolution_quantities(
    frames: Sequence[Mapping[str, Quantity]],
    times: Sequence[float],
    fields: Mapping[str, Field],
    plastic_fields: Mapping[str, Field],
    posed: PosedScene,
    error: ErrorParts,
    ranges: Mapping[str, tuple[float, float]],
) -> dict[str, Quantity]:
    """Return extremes over time with their instants, final values, and permanent changes: wear, dent, residual stress.

    Parameters
    ----------
    frames
        Quantities of each recorded instant.
    times
        The instants [s].
    fields
        Wear, slip and dent (x, y) at the last instant, by name.
    plastic_fields
        Residual stress (time, component, z, x, y) [Pa] of the bodies that yielded, of which the last instant counts.
    posed
        The scene with its grid.
    error
        Relative L1 error of the pressure at the worst instant.
    ranges
        Lowest and highest values after all steps, by name, of those that are known.
    """
    quantities = _extremes(frames, times, posed.scene, ranges) | _final(frames[-1])
    if "wear_depth" in fields:
        quantities |= _of_wear(fields, frames, posed, error)
    if "friction_energy" in fields:
        quantities |= _of_slip(fields, posed)
    return quantities | _of_dents(fields) | _of_residual_stress(plastic_fields)


def _extremes(
    frames: Sequence[Mapping[str, Quantity]],
    times: Sequence[float],
    scene: Scene,
    ranges: Mapping[str, tuple[float, float]],
) -> dict[str, Quantity]:
    """Return the extremes over time, each with its instant, of the instants that have the quantity.

    They have no bound where a history goes beyond its recorded values between the recorded instants, or has a kink there
    from which a body creeps. The bound of others includes how far their `ranges`, or else a parabola through three
    instants, go beyond them. The arguments are those of :func:`evolution_quantities`.
    """
    quantities = {}
    reason, at_kinks = _beyond_recorded(times, scene)
    for name, extreme, label in EXTREMES:
        known = [(frame[name], time) for frame, time in zip(frames, times, strict=True) if name in frame]
        if not known:
            continue
        values = [extreme([quantity.value]) for quantity, _ in known]  # the size of a value, for a magnitude
        index = values.index(extreme(values))
        (quantity, time), instants = known[index], [instant for _, instant in known]
        bound, beyond = inf if reason else quantity.bound, 0.0
        # an instant may be recorded twice
        before, after = bisect_left(instants, time) - 1, bisect_right(instants, time)
        if name in ranges:
            beyond = abs(extreme([*ranges[name], values[index]]) - values[index])
        elif (
            before >= 0 and after < len(known) and time not in at_kinks
        ):  # at a kink the extreme is at the instant itself
            places = before, index, after
            beyond = _beyond_parabola([instants[place] for place in places], [values[place] for place in places])
        # A bound that is found later, by grids, replaces `bound + beyond`. It reaches to each rival, (value, depth), by
        # distance alone, so that the rival may stand above a lowest value too; the margin is that of such bounds.
        quantities[name] = replace(
            quantity, value=values[index], label=label, bound=bound + beyond, reason=reason or quantity.reason,
            position={"time": float(time)}, detail="", rivals=(*quantity.rivals, (values[index] + MARGIN * beyond, 0.0)),
        )  # fmt: skip
    return quantities


def _beyond_recorded(times: Sequence[float], scene: Scene) -> tuple[str, frozenset[float]]:
    """Return why extremes between the recorded `times` [s] are not known, and the times of all kinks of histories.

    The reason is a sentence on a history that goes beyond its values at the recorded times; empty if none does, and the
    times of kinks are then complete. Where a body creeps, a kink counts as well, since the pressure may be highest there
    under a load that stays.
    """
    known: set[float] = set()
    creeping = any(map(creeps, scene.solids))
    if not scene.histories and times[0] > 0:
        return BEFORE_RECORDED, frozenset()
    for history in scene.histories:
        # the times in falling order of the size of the load or speed: the reason names the first one
        largest_first = reversed(kinks(history, times[-1]))
        between = [time for time in largest_first if history.start <= time <= times[-1]]
        known.update(between)
        before = getattr(history, "before", history.at)
        # an instant that is recorded twice is one before and after a jump
        recorded = [history.at(time) for time in times]
        recorded += [before(time) for time, later in pairwise(times) if time == later]
        lowest, highest = min(recorded), max(recorded)
        allowed = HISTORY_ROUNDING * max(abs(lowest), abs(highest))
        for time in between:
            values = history.at(time), before(time) if time > history.start else lowest
            is_within = all(lowest - allowed <= value <= highest + allowed for value in values)
            if not is_within or (creeping and not np.isclose(times, time).any()):
                return (
                    f"No bound: a history of the scene has a kink or an extreme at {time:.4g} s, between the recorded "
                    "instants: record that one too."
                ), frozenset()
    return "", frozenset(known)


def _beyond_parabola(times: Sequence[float], values: Sequence[float]) -> float:
    """Return how far the vertex of the parabola through three `values` at `times` [s] lies from the middle one.

    It is 0 where the three are on a straight line.
    """
    before, after = (values[end] - values[1] for end in (0, 2))
    t0, t1 = times[0] - times[1], times[2] - times[1]
    curvature = (after / t1 - before / t0) / (t1 - t0)
    slope = before / t0 - curvature * t0
    return abs(slope**2 / curvature / 4) if curvature else 0.0


def _final(last: Mapping[str, Quantity]) -> dict[str, Quantity]:
    """Return those of the `last` instant's quantities that are in `FINAL`, under names that begin with ``final_``."""
    quantities = {}
    peak = last.get("peak_pressure")
    is_separated = peak is not None and peak.value == 0  # separated bodies have no approach
    for name in FINAL:
        if name in last and not (is_separated and name == "approach"):
            final = last[name]
            label, detail = f"{final.label} at the end", "" if final.position else final.detail
            quantities[f"final_{name}"] = replace(final, label=label, position=None, detail=detail)
    return quantities


def _of_wear(
    fields: Mapping[str, Field], frames: Sequence[Mapping[str, Quantity]], posed: PosedScene, error: ErrorParts
) -> dict[str, Quantity]:
    """Return the wear volume, that of the whole circumference of a body that turns, and the largest wear depth.

    Where bodies slide, the volume follows from the load, whose error has no part by images, cells or steps, and the
    largest depth follows from the peak pressures. On a film, under a rolling traction and where slip in fretting wears,
    changes between grids alone tell both errors.
    """
    last = frames[-1]
    worn, grid = fields["wear_depth"].values, posed.grid
    circumference = getattr(posed.scene.wear, "circumference", None)
    around = 1.0 if circumference is None else circumference / grid.extent[0]
    of_volume: ErrorParts | None = replace(error, images=None, discretisation=None, steps=None)
    peaks = [frame["peak_pressure"] for frame in frames]
    by_peaks = max((peak.relative_bound for peak in peaks if peak.value), default=0.0)
    of_depth: ErrorParts | None = ErrorParts(discretisation=by_peaks, reason=NO_BOUND_OF_DEPTH)
    if "friction_energy" in fields or "frictional_power" in last or "central_film" in last:
        of_volume = of_depth = None
    total = float(worn.sum() * grid.cell_area * around)
    volume = per_length(total, "m3", "wear volume", roller_length(posed), grid.length)
    depth = Quantity(float(worn.max()), "m", "largest wear depth")
    return {"wear_volume": with_bound(volume, of_volume), "largest_wear_depth": with_bound(depth, of_depth)}


def _of_slip(fields: Mapping[str, Field], posed: PosedScene) -> dict[str, Quantity]:
    """Return the energy lost to friction and the largest distance slipped."""
    energy = float(fields["friction_energy"].values.sum() * posed.grid.cell_area)
    dissipated = per_length(energy, "J", "energy lost to friction", roller_length(posed), posed.grid.length)
    slid = float(fields["slip_distance"].values.max())
    return {"friction_energy": dissipated, "largest_slip": Quantity(slid, "m", "largest distance slipped")}


def _of_dents(fields: Mapping[str, Field]) -> dict[str, Quantity]:
    """Return depth and shoulders of the residual displacement of each body that yields, from its undeformed surface."""
    quantities = {}
    for name, field in fields.items():
        if name.startswith("residual_displacement"):
            suffix = name.removeprefix("residual_displacement")
            body = f" of solids[{suffix[1:]}]" if suffix else ""
            depth = f"depth of the dent{body} at the end, below the undeformed surface"
            height = f"height of its shoulders{body}, above the undeformed surface"
            quantities["dent_depth" + suffix] = Quantity(float(field.values.max()), "m", depth)
            quantities["shoulder_height" + suffix] = Quantity(-float(field.values.min()), "m", height)
    return quantities


def _of_residual_stress(fields: Mapping[str, Field]) -> dict[str, Quantity]:
    """Return the highest and lowest residual stress of each body that yields: the normal stress across or along."""
    quantities = {}
    for name, stress in fields.items():
        if name.startswith("residual_stress"):
            body = f" of solids[{name[-1]}]" if name[-1].isdigit() else ""
            last = stress.values[-1, :2]
            for end, value in (("highest", last.max()), ("lowest", last.min())):
                label = f"{end} residual stress{body}, across or along"
                quantities[f"{end}_{name}"] = Quantity(float(value), "Pa", label)
    return quantities


def history_quantities(
    frames: "Sequence[Frame]", approach_errors: Sequence[float], load: AnyLoad
) -> dict[str, Quantity]:
    """Return what a history of an adhesive contact says: where contact is lost and made, and the net work.

    Parameters
    ----------
    frames
        Recorded instants of a contact with adhesion.
    approach_errors
        Bound of the approach [m] of each of them.
    load
        Load of the scene.
    """
    work, error, reason = net_work(frames, approach_errors, load)
    changes = changes_of_contact(frames, load)
    quantities: dict[str, Quantity] = {}
    for name, sign, label, beyond in (
        ("pull_off", -1, "pull-off load", "lost before"),
        ("jump_in", 1, "load at which contact jumps in", "not made at"),
    ):
        if name in changes:
            in_contact, farthest = changes[name]
            detail = f", {beyond} {readable(sign * farthest, 'N m-1')}"
            quantities[name] = Quantity(sign * in_contact, "N m-1", label, reason=NO_BOUND_OF_CELLS, detail=detail)
    return quantities | {"net_work": Quantity(work, "J m-1", "net work of the load", error, reason)}


def net_work(frames: "Sequence[Frame]", approach_errors: Sequence[float], load: AnyLoad) -> tuple[float, float, str]:
    """Return the net work of the load in a history [J/m], the bound of its error, and why that is infinite where it is.

    It is the integral of the load over the approach: the hysteresis loss where the history ends at the load and on the
    branch of its beginning, else with the elastic energy stored meanwhile. Where the load does not turn between two
    instants, load and approach go one way, also where contact jumps in. The trapezoid is then wrong by half the product
    of their changes at most. Errors of the approaches [m] count with the changes of the load around them, and at both
    ends with the load.

    Parameters
    ----------
    frames
        Recorded instants of a contact with adhesion.
    approach_errors
        Bound of the approach [m] of each of them.
    load
        Load of the scene.
    """
    work = error = 0.0
    largest = max(abs(frame.load) for frame in frames)
    reason = "" if np.isfinite(approach_errors).all() else "No bound: the approach has none."
    for number, (a, b) in enumerate(pairwise(frames)):
        if Status.DETACHED in (a.status, b.status):
            reason = "No bound: contact is made or lost between two instants."
            continue
        loads = _loads_between(a, b, load)
        variation, change = sum(abs(y - x) for x, y in pairwise(loads)), abs(b.load - a.load)
        if variation - change > HISTORY_ROUNDING * largest:
            reason = reason or "No bound: the load turns between two instants: record where it turns."
        work += (a.load + b.load) / 2 * (b.approach - a.approach)
        error += abs(change * (b.approach - a.approach)) / 2
        error += change / 2 * (approach_errors[number] + approach_errors[number + 1])
    if reason:
        return work, inf, reason
    ends = [abs(frames[n].load) * approach_errors[n] for n in (0, -1)]
    return work, error + sum(ends), ""


def _loads_between(a: "Frame", b: "Frame", load: AnyLoad) -> list[float]:
    """Return the loads [N/m] from one frame to the next, with those between which the load only rises or falls."""
    if not isinstance(load, ChangingLoad):
        return [a.load, b.load]
    return [a.load, *loads_between(load, a.time, b.time), b.load]


def changes_of_contact(frames: "Sequence[Frame]", load: AnyLoad) -> dict[str, tuple[float, float]]:
    """Return the loads between which contact is first lost ("pull_off") and made ("jump_in"), as far as it is.

    The first of each two is a recorded load [N/m] in contact. The other is a recorded one without contact, or one beyond
    where the `load` turns between the two instants.
    """
    changes: dict[str, tuple[float, float]] = {}
    for before, after in pairwise(frames):
        touched, touches = (frame.status is not Status.DETACHED for frame in (before, after))
        if touched != touches:
            loads = _loads_between(before, after, load)
            touching, *others = loads if touched else reversed(loads)
            farthest = max(others, key=lambda other: abs(other - touching))
            changes.setdefault("pull_off" if touched else "jump_in", (touching, farthest))
    return changes


def passes_quantities(rolled: "RepeatedRolling") -> dict[str, Quantity]:
    """Return what the last pass of a repeatedly rolling contact leaves behind.

    The error of each is of first order in the cells: its bound is `PASS_MARGIN` times the largest change by any pass
    from cells of twice the size, since the change by a single pass may be small by chance.
    """
    found, coarse = _by_pass(rolled), _by_pass(rolled.coarse)
    status = next((s for s in (rolled.status, rolled.coarse.status) if s is not Status.CONVERGED), None)
    hertz, cell = rolled.description.scene.hertz, rolled.grid.cell_size[0]
    is_coarse = hertz is not None and cell * CELLS_OF_PASS > hertz.half_width * (1 + 1e-9)
    common_reason = f"No bound: {status}" if status is not None else (NO_BOUND_OF_FEW_CELLS if is_coarse else "")
    quantities = {}
    for name, (values, unit, label) in found.items():
        bound = PASS_MARGIN * float(np.abs(values - coarse[name][0]).max())
        # the last pass alone adds these
        is_elastic = name.startswith(("last", "forward")) and not coarse[name][0][-1]
        reason = common_reason or (NO_BOUND_OF_PASS if is_elastic else "")
        quantities[name] = Quantity(float(values[-1]), unit, label, inf if reason else bound, reason)
    depth = {"z": float(rolled.depths[int(rolled.residual_stress[-1, 0].argmin())])}
    lowest = replace(quantities["lowest_residual_stress"], position=depth)
    return quantities | {"lowest_residual_stress": lowest}


def _by_pass(rolled: "RepeatedRolling") -> dict[str, tuple[Array, str, str]]:
    """Return what each pass leaves behind, by name: its values (pass,), unit and label."""
    lowest, strain = rolled.residual_stress[:, 0].min(axis=-1), rolled.equivalent_plastic_strain.max(axis=-1)
    added = "largest equivalent plastic strain that the last pass adds"
    forward = "forward displacement of the surface, opposite to the travel of the contact, by the last pass"
    return {
        "lowest_residual_stress": (lowest, "Pa", "lowest residual stress in the rolling direction"),
        "equivalent_plastic_strain": (strain, "1", "largest equivalent plastic strain"),
        "last_plastic_strain_increment": (rolled.plastic_strain_increment, "1", added),
        "forward_displacement": (rolled.forward_displacement, "m", forward),
    }
