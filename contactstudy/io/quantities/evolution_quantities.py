"""Numbers of a contact in time, and of one under repeated rolling."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from contactstudy.domain.errors import ErrorParts
from contactstudy.io.quantities.quantity import Quantity, per_length, with_bound
from contactstudy.problem.problem import Field

if TYPE_CHECKING:
    from contactstudy.evolution.rolling.repeated_rolling import RepeatedRolling

NO_BOUND_OF_SLIP = "No bound: the discretisation error of slip is not estimated; solve again on cells of half the width."
NO_BOUND_OF_STRAIN = "No bound: the error of plastic strain is not estimated; solve again on cells of half the width."


def evolution_quantities(
    frames: Sequence[Mapping[str, Quantity]],
    times: Sequence[float],
    fields: Mapping[str, Field],
    length: float | None,
    around: float,
    cell: tuple[float, float],
    plastic_fields: Mapping[str, Field],
    error: ErrorParts,
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
    length
        Length of the roller [m]; None for an endless contact.
    around
        Circumference of a worn body that turns over the width of the grid; 1 where none turns.
    cell
        Cell area [m^2] and period [m] of the grid.
    plastic_fields
        Residual stress (time, component, z, x, y) [Pa] of the bodies that yielded, at the last instant.
    error
        Relative L1 error of the pressure at the worst instant.
    """
    quantities: dict[str, Quantity] = {}
    extremes: tuple[tuple[str, Callable[[list[float]], float], str], ...] = (
        ("peak_pressure", max, "largest peak pressure in time"),
        ("largest_von_mises", max, "largest von Mises stress in time"),
        ("central_film", min, "lowest central film thickness in time"),
        ("minimum_film", min, "minimum film thickness in time"),
        ("friction_coefficient", max, "largest friction force over load in time"),
        ("traction_coefficient", max, "largest tangential force over load in time"),
        ("frictional_power", max, "largest frictional power in time"),
        ("rolling_resistance", max, "largest coefficient of rolling resistance in time"),
    )
    for name, extreme, label in extremes:
        if name in frames[0]:
            values = [frame[name].value for frame in frames]
            number = values.index(extreme(values))
            position = {"time": float(times[number])}
            quantities[name] = replace(
                frames[number][name], label=label, position=position, detail=""
            )
    reported = ["peak_pressure", "contact_area", "approach", "central_film", "minimum_film"]
    reported += ["friction_coefficient", "traction_coefficient", "stick_fraction", "creepage"]
    reported += ["frictional_power", "rolling_resistance"]
    peak = frames[-1].get("peak_pressure")
    is_separated = peak is not None and peak.value == 0  # separated bodies have no approach
    for name in reported:
        if name in frames[-1] and not (is_separated and name == "approach"):
            final = frames[-1][name]
            label, detail = f"{final.label} at the end", "" if final.position else final.detail
            quantities[f"final_{name}"] = replace(final, label=label, position=None, detail=detail)
    if "worn_depth" in fields:
        worn, (area, period) = fields["worn_depth"].values, cell
        volume = float(worn.sum() * area * around)
        # sliding wears in proportion to the load, which is exact, and to the pressure before
        by_load = replace(error, images=None, discretisation=None)
        by_slip = ErrorParts(discretisation=inf, reason=NO_BOUND_OF_SLIP)
        slips = "friction_energy" in fields or "frictional_power" in frames[-1]
        of_film = error if "central_film" in frames[-1] else by_load
        worn_volume = per_length(volume, "m3", "worn volume", length, period)
        quantities["worn_volume"] = with_bound(worn_volume, by_slip if slips else of_film)
        deepest = Quantity(float(worn.max()), "m", "largest worn depth")
        quantities["largest_worn_depth"] = with_bound(deepest, by_slip if slips else error)
    if "friction_energy" in fields:
        energy = float(fields["friction_energy"].values.sum() * cell[0])
        dissipated = per_length(energy, "J", "energy lost to friction", length, cell[1])
        slid = float(fields["slip_distance"].values.max())
        quantities["friction_energy"] = replace(dissipated, bound=inf, reason=NO_BOUND_OF_SLIP)
        label = "largest distance slipped"
        quantities["largest_slip"] = Quantity(slid, "m", label, inf, NO_BOUND_OF_SLIP)
    if "residual_displacement" in fields:
        # into the bodies, from the undeformed surface
        residual, unbounded = fields["residual_displacement"].values, (inf, NO_BOUND_OF_STRAIN)
        depth, height = float(residual.max()), float(-residual.min())
        label = "depth of the dent at the end, below the undeformed surface"
        quantities["dent_depth"] = Quantity(depth, "m", label, *unbounded)
        label = "height of its shoulders, above the undeformed surface"
        quantities["shoulder_height"] = Quantity(height, "m", label, *unbounded)
    for name, stress in plastic_fields.items():
        if name.startswith("residual_stress"):
            of = f" of solids[{name[-1]}]" if name[-1].isdigit() else ""
            for end, extreme in (("highest", np.max), ("lowest", np.min)):
                label = f"{end} residual stress{of}, across or along"
                value = float(extreme(stress.values[-1, :2]))
                quantities[f"{end}_{name}"] = Quantity(value, "Pa", label, inf, NO_BOUND_OF_STRAIN)
    return quantities


def cycle_quantities(
    net_work: tuple[float, float, str],
    separation: tuple[float, float] | None,
    jump_in: tuple[float, float] | None,
) -> dict[str, Quantity]:
    """Return what a history of an adhesive contact says: where contact is lost and made, and the net work.

    Parameters
    ----------
    net_work
        Net work done by the load [J/m], the bound of its error, and why that is infinite.
    separation
        Last load held and first load lost [N/m]; None where contact is not lost.
    jump_in
        First load in contact and last load before [N/m]; None where contact is not made.
    """
    work, error, reason = net_work
    quantities = {"net_work": Quantity(work, "J m-1", "net work of the load", error, reason)}
    if separation is not None:
        last_stable, first_unstable = separation
        bound = abs(last_stable - first_unstable)
        pull_off = Quantity(-last_stable, "N m-1", "pull-off load", bound, "")
        quantities = {"pull_off": pull_off} | quantities
    if jump_in is not None:
        in_contact, separated = jump_in
        label, bound = "load at which contact jumps in", abs(in_contact - separated)
        quantities["jump_in"] = Quantity(in_contact, "N m-1", label, bound, "")
    return quantities


def passes_quantities(rolled: "RepeatedRolling") -> dict[str, Quantity]:
    """Return what the last pass of a repeatedly rolling contact leaves behind."""
    stress = rolled.residual_stress[-1, 0]
    lowest = int(stress.argmin())
    depth = {"z": float(rolled.depths[lowest])}
    compression = "lowest residual stress in the rolling direction"
    strain = float(rolled.equivalent_plastic_strain[-1].max())
    added = float(rolled.plastic_strain_increment[-1])
    displacement = float(rolled.forward_displacement[-1])
    forward = "displacement of the surface against the rolling direction, by the last pass"
    yielding = "largest plastic strain that the last pass adds"
    return {
        "lowest_residual_stress": Quantity(
            float(stress[lowest]), "Pa", compression, position=depth
        ),
        "equivalent_plastic_strain": Quantity(strain, "1", "largest equivalent plastic strain"),
        "last_yielding": Quantity(added, "1", yielding),
        "forward_displacement": Quantity(displacement, "m", forward),
    }
