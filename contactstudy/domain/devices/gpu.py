"""A graphics processor: the one module that knows whose."""

from dataclasses import dataclass
from importlib import import_module
from typing import Any

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.devices.device import Numbers
from contactstudy.domain.devices.namespace import Namespace


@dataclass(frozen=True)
class Gpu:
    """The graphics processor of this machine, through CuPy (extra ``gpu``).

    Influence coefficients are computed on the processor in double precision and moved once; a solution's fields are
    numpy arrays. Of several graphics processors it is CuPy's current one. Raises
    :class:`~contactstudy.InvalidInput` where there is none, or no CuPy.
    """

    def __post_init__(self) -> None:
        try:
            _ = self.arrays
            count = _cupy().cuda.runtime.getDeviceCount()
        except ImportError as missing:
            raise InvalidInput(
                f"Gpu needs CuPy, which cannot be imported ({missing}): "
                "pip install 'contactstudy[gpu]', or give Cpu()."
            ) from missing
        except _cupy().cuda.runtime.CUDARuntimeError as failed:
            raise InvalidInput(
                f"Gpu found no graphics processor ({failed}): give Cpu()."
            ) from failed
        if count == 0:
            raise InvalidInput("Gpu found no graphics processor: give Cpu().")

    @property
    def arrays(self) -> Namespace:
        """CuPy, with the names of the array API standard."""
        found: Namespace = import_module("array_api_compat.cupy")
        return found

    def put(self, field: Numbers) -> Numbers:
        """A copy of a numpy array there."""
        found: Numbers = _cupy().asarray(field)
        return found

    def take(self, field: Numbers) -> Numbers:
        """A copy as a numpy array."""
        found: Numbers = _cupy().asnumpy(field)
        return found

    @property
    def available_bytes(self) -> float:
        """Memory there that is free, or that CuPy keeps for the next arrays."""
        free, _ = _cupy().cuda.runtime.memGetInfo()
        return float(free + _cupy().get_default_memory_pool().free_bytes())


def _cupy() -> Any:
    return import_module("cupy")
