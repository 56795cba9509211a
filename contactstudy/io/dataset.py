"""Solution -> labelled xarray.Dataset."""

from dataclasses import asdict

import xarray as xr

from contactstudy.accuracy.estimate import ErrorEstimate
from contactstudy.solvers.solution import Solution


def to_dataset(solution: Solution, estimate: ErrorEstimate | None = None) -> xr.Dataset:
    """``solution`` with dimensions (width, length), units, long names, and where it came from.

    Coordinates are cell centres [m]; scalars are variables without dimensions; ``status`` and its
    sentence are attributes. With an ``estimate`` of its errors, those too, along a dimension ``cause``
    over which they add up. What
    ``Scene.outputs`` asks for is found here.
    """
    grid, fields = solution.problem.grid, ("width", "length")
    metres, one = {"units": "m"}, {"units": "1"}
    dataset = xr.Dataset(
        {
            "pressure": (
                fields,
                solution.pressure,
                {"units": "Pa", "long_name": "contact pressure"},
            ),
            "displacement": (
                fields,
                solution.displacement,
                metres | {"long_name": "surface displacement"},
            ),
            "gap": (fields, solution.gap, metres | {"long_name": "gap after deformation"}),
            "approach": ((), solution.approach, metres | {"long_name": "approach of the bodies"}),
            "residual": ((), solution.residual, one | {"long_name": "residual of the solver"}),
            "iterations": ((), solution.iterations, one | {"long_name": "solver iterations"}),
            "convolutions": (
                (),
                solution.convolutions,
                one | {"long_name": "transform pairs of the full grid"},
            ),
        },
        coords={
            "width": ("width", grid.x, metres | {"long_name": "position across the contact"}),
            "length": ("length", grid.y, metres | {"long_name": "position along the contact"}),
        },
        attrs=dict(solution.problem.attributes)
        | {
            "Conventions": "CF-1.11",
            "title": "line contact",
            "status": solution.status.name,
            "status_sentence": str(solution.status),
        },
    )
    for output in solution.problem.outputs:
        for name, one_field in output.fields(solution.pressure).items():
            labels = {"units": one_field.units, "long_name": one_field.long_name}
            dataset[name] = one_field.dimensions, one_field.values, labels
    return dataset if estimate is None else dataset.assign(_estimated(estimate))


def _estimated(estimate: ErrorEstimate) -> dict[str, xr.DataArray]:
    named = {
        "peak_pressure": ("highest pressure", estimate.peak_pressure),
        "pressure_l1": ("pressure in L1", estimate.l1),
    }
    return {
        f"{metric}_error_estimate": xr.DataArray(
            list(asdict(parts).values()),
            {
                "cause": (
                    "cause",
                    list(asdict(parts)),
                    {"units": "1", "long_name": "cause of the error"},
                )
            },
            ("cause",),
            attrs={"units": "1", "long_name": f"estimated relative error of the {what}"},
        )
        for metric, (what, parts) in named.items()
    }
