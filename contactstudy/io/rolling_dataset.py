"""RepeatedRolling -> labelled xarray.Dataset."""

import numpy as np
import xarray as xr

from contactstudy.domain.fields import Array
from contactstudy.domain.version import VERSION
from contactstudy.elasticity.kernels.stress_cell import COMPONENTS
from contactstudy.evolution.passes.repeated_rolling import RepeatedRolling
from contactstudy.io.dataset import X, scene_attribute
from contactstudy.solvers.solution import Status


def rolling_dataset(rolling: RepeatedRolling) -> xr.Dataset:
    """What each pass leaves, over (pass, component, z), and the window at its end over (component, z, x)."""
    passes, track, volume = rolling.passes, rolling.track, rolling.track.operator.volume
    tensors = "pass", "component", "z"
    statuses = list(Status)
    window = np.einsum("ct,cl...->tl...", track.operator.basis, track.strain)

    def labelled(values: Array, units: str, long_name: str, *dimensions: str) -> xr.Variable:
        return xr.Variable(dimensions, values, {"units": units, "long_name": long_name})

    return xr.Dataset(
        {
            "plastic_strain": labelled(rolling.plastic_strain, "1", "plastic strain", *tensors),
            "equivalent_plastic_strain": labelled(
                rolling.equivalent_plastic_strain, "1", "equivalent plastic strain", "pass", "z"
            ),
            "residual_stress": labelled(
                rolling.residual_stress, "Pa", "stress far behind the contact, tension positive", *tensors
            ),
            "shear": labelled(rolling.shear, "1", "shear strain added by the pass", "pass", "z"),
            "forward_displacement": labelled(
                rolling.forward_displacement, "m", "surface moved against the travel by the pass", "pass"
            ),
            "yielding": labelled(
                rolling.yielding, "1", "largest equivalent plastic strain added by the pass", "pass"
            ),
            "peak_pressure": labelled(
                rolling.peak_pressure, "Pa", "peak pressure at the end of the pass", "pass"
            ),
            "distance": labelled(
                np.array([one.distance for one in passes]), "m", "distance rolled", "pass"
            ),
            "status": xr.Variable(
                "pass",
                np.array([statuses.index(one.status) for one in passes], dtype=np.int8),
                {
                    "long_name": "worst status of the steps",
                    "flag_values": np.arange(len(statuses), dtype=np.int8),
                    "flag_meanings": " ".join(one.name for one in statuses),
                },
            ),
            "pressure": labelled(
                passes[-1].solution.pressure[:, 0], "Pa", "contact pressure in the last pass", "x"
            ),
            "window_plastic_strain": labelled(
                window[..., 0], "1", "plastic strain below the contact in the last pass",
                "component", "z", "x",
            ),
            "window_residual_stress": labelled(
                rolling.removed.residual_stress()[..., 0], "Pa",
                "stress where the last contact was lifted off, tension positive",
                "component", "z", "x",
            ),
        },
        coords={
            "pass": ("pass", np.arange(1, len(passes) + 1), {"long_name": "number of the pass"}),
            "component": ("component", list(COMPONENTS)),
            "z": ("z", volume.depths, {"units": "m", "long_name": "depth", "axis": "Z", "positive": "down"}),
            "x": ("x", volume.grid.x, X),
        },
        attrs={
            "Conventions": "CF-1.11",
            "title": "repeated rolling of a line contact",
            "source": f"contactstudy {VERSION}",
            "scene": scene_attribute(rolling.description),
        },
    )  # fmt: skip
