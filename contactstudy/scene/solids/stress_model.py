"""Stress in a body under pressure and tangential traction on one cell of its surface."""

from dataclasses import dataclass
from typing import ClassVar, Protocol

from contactstudy.domain.grid import Array
from contactstudy.elasticity.convolution import Coefficients
from contactstudy.elasticity.kernels import stress


class StressModel(Protocol):
    """Stress in a body under pressure and tangential traction on one cell of its surface."""

    @property
    def interface_depths(self) -> tuple[float, ...]:
        """Depths [m] just above and just below each interface, where stress jumps; empty without one."""

    def coefficients(self, traction: str, component: str, depth: float) -> tuple[tuple[Coefficients, float], ...]:
        """Return coefficients with their weights of a stress `component` at a `depth` [m], tension positive.

        The `traction` is "pressure", or tangential traction "across" or "along"; the `component` is xx, yy, zz, yz, xz
        or xy.
        """


@dataclass(frozen=True)
class HalfSpaceStress:
    """Stress in a homogeneous half-space of this `poisson_ratio`; it has no interface."""

    poisson_ratio: float
    interface_depths: ClassVar[tuple[float, ...]] = ()

    def coefficients(self, traction: str, component: str, depth: float) -> tuple[tuple[Coefficients, float], ...]:
        """Return the coefficients of Boussinesq and Cerruti, with the weight 1."""
        families = {"pressure": stress.BOUSSINESQ, "across": stress.CERRUTI_ACROSS, "along": stress.CERRUTI_ALONG}
        return ((StressCoefficients(families[traction][component], depth, self.poisson_ratio), 1.0),)


@dataclass(frozen=True)
class StressCoefficients:
    """Influence coefficients of one stress component at one depth, over pressure or tangential traction.

    Parameters
    ----------
    component
        Component, with the load on the surface that causes it.
    depth
        Depth below the surface [m].
    poisson_ratio
        Poisson's ratio of the half-space.
    """

    component: stress.CellKernel
    depth: float
    poisson_ratio: float

    @property
    def parity(self) -> tuple[int, int]:
        """Parity of the component in x and y."""
        return self.component.parity

    def swap_axes(self) -> "StressCoefficients":
        """Return the component that takes this one's place when the axes are exchanged."""
        return StressCoefficients(self.component.swap_axes(), self.depth, self.poisson_ratio)

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        """Return the stress over the traction on one cell."""
        return stress.stress_cell(self.component, x, y, self.depth, dx, dy, self.poisson_ratio)

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """Return the stress over the traction on a cell and an infinite row of its images along y."""
        cell = self.depth, dx, dy
        return stress.stress_cell_periodic(self.component, x, y, *cell, period, self.poisson_ratio)

    def lattice(self, x: Array, y: Array, dx: float, dy: float, width: float, period: float) -> Array:
        """Return the stress over the traction on a cell and an infinite lattice of its images."""
        cell, periods = (self.depth, dx, dy), (width, period)
        return stress.stress_cell_doubly_periodic(self.component, x, y, *cell, *periods, self.poisson_ratio)
