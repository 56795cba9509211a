"""What passes of a contact leave in a half-space."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.imports import import_for
from contactstudy.evolution.march import worst
from contactstudy.evolution.passes.track import Profile, Track
from contactstudy.scene.scene import PosedScene
from contactstudy.solvers.solution import Solution, Status

if TYPE_CHECKING:
    import xarray as xr

XX, YY, XZ = 0, 1, 4


@dataclass(frozen=True, eq=False)
class RollingPass:
    """One pass: the plastic strain that it has ``left`` behind, over a ``distance`` [m], and the contact at its end.

    ``status`` is the worst of its ``steps``, which took so many ``iterations`` of Newton's method; it is
    NOT_CONVERGED, too, where the plastic strain did not become steady.
    """

    left: Profile
    distance: float
    solution: Solution
    status: Status
    steps: int
    iterations: int


@dataclass(frozen=True, eq=False)
class RepeatedRolling:
    """The ``passes`` of a contact over a half-space, in order, and the ``track`` in the window of the last one.

    Arrays are (pass, z) or (pass, component, z): components xx, yy, zz, yz, xz, xy with x in the direction of travel
    and z into the body, stress tension positive, each after the pass and far behind the contact, where nothing
    changes along x. ``removed`` is the track after the last contact has been lifted off.
    """

    passes: tuple[RollingPass, ...]
    track: Track
    removed: Track
    description: PosedScene

    @property
    def grid(self) -> Grid:
        """The window."""
        return self.track.operator.volume.grid

    @property
    def depths(self) -> Array:
        """Middles of the layers (z,) [m]."""
        return self.track.operator.volume.depths

    @property
    def plastic_strain(self) -> Array:
        """(pass, component, z)"""
        basis = self.track.operator.basis
        return np.asarray(np.einsum("ct,ncl->ntl", basis, self._each(_strain)))

    @property
    def equivalent_plastic_strain(self) -> Array:
        """(pass, z)"""
        return self._each(_equivalent)

    @property
    def residual_stress(self) -> Array:
        """(pass, component, z) [Pa]: xx and yy alone, which balance in a body that goes on to infinity."""
        moduli = self.track.operator.moduli
        strain, nu = self.plastic_strain, moduli.poisson_ratio
        stress = np.zeros_like(strain)
        stress[:, XX] = -moduli.plane_strain * (strain[:, XX] + nu * strain[:, YY])
        stress[:, YY] = -moduli.plane_strain * (strain[:, YY] + nu * strain[:, XX])
        return stress

    @property
    def yielding(self) -> Array:
        """(pass,) The largest equivalent plastic strain that a pass adds; 0 where nothing yields any more."""
        return np.asarray(self._added(self.equivalent_plastic_strain).max(axis=-1))

    @property
    def shear(self) -> Array:
        """(pass, z) The shear strain ``2 e_xz`` that a pass adds."""
        return 2 * self._added(self.plastic_strain[:, XZ])

    @property
    def forward_displacement(self) -> Array:
        """(pass,) [m] How far a pass moves the surface over what lies deep, against the direction of travel.

        The integral of :attr:`shear`. On a disc that turns below a contact which stays, it is forwards
        (Crook 1957, Proc. Inst. Mech. Eng. 171).
        """
        return self.shear @ self.track.operator.volume.thicknesses

    @property
    def peak_pressure(self) -> Array:
        """(pass,) [Pa] at the end of each."""
        return np.array([one.solution.pressure.max() for one in self.passes])

    @property
    def shaken_down(self) -> int | None:
        """The first pass, counted from 1, from which on nothing yields; None where the last one yields still."""
        still = np.flatnonzero(self.yielding > 0)
        last = int(still[-1]) + 1 if still.size else 0
        return None if last == len(self.passes) else last + 1

    @property
    def status(self) -> Status:
        """The worst of all passes."""
        return worst([one.status for one in self.passes])

    def summary(self) -> str:
        """What was found, in a few lines."""
        stress = self.residual_stress[-1, XX]
        lowest = int(stress.argmin())
        down = self.shaken_down
        return "\n".join(
            (
                f"{self.status}",
                f"  {len(self.passes)} passes, {sum(one.steps for one in self.passes)} steps, "
                f"{sum(one.iterations for one in self.passes)} iterations",
                "  the last pass yields still"
                if down is None
                else f"  nothing yields from pass {down} on",
                f"  lowest residual stress along the way {stress[lowest]:.4g} Pa at a depth of "
                f"{self.depths[lowest]:.4g} m; the last pass moves the surface by "
                f"{self.forward_displacement[-1]:.4g} m",
            )
        )

    def to_dataset(self) -> "xr.Dataset":
        """By pass and depth, and the window after the last pass, with units and long names."""
        # by name: a Dataset stands on results, not results on Datasets
        labelled = import_for("RepeatedRolling.to_dataset", "contactstudy.io.dataset")
        made: xr.Dataset = labelled.rolling_dataset(self)
        return made

    def _each(self, of: Callable[[Profile], Array]) -> Array:
        layers = len(self.depths)
        return np.stack([of(one.left.deeper(layers)) for one in self.passes])

    def _added(self, kept: Array) -> Array:
        return np.diff(kept, axis=0, prepend=np.zeros_like(kept[:1]))


def _strain(profile: Profile) -> Array:
    return profile.strain


def _equivalent(profile: Profile) -> Array:
    return profile.equivalent
