"""Stress below the surface of a body: what a user asks for, the map from pressure to it, and measures of a stress.

A stress has six components in the order of ``COMPONENTS`` (xx, yy, zz, yz, xz, xy), tension positive. x is across the
contact, y along it, and z, the depth, into the body.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from math import inf, isclose
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np

from contactstudy.domain.grid import Array, ExactPeriodicity, Grid, Paddings, ZeroPadding, is_free
from contactstudy.domain.validation import AT_LEAST_ZERO, BodyIndex, InvalidInput, Metres, readable, validated
from contactstudy.elasticity.convolution import FreeFaceCoefficients, on_padded_grid, padded_cells
from contactstudy.elasticity.kernels.stress import COMPONENTS, HalfSpaceStress
from contactstudy.elasticity.transforms import TRANSFORMS
from contactstudy.problem.problem import Field, ResidualStress
from contactstudy.scene.solids.bodies import Body, HardnessProfile, is_layered

if TYPE_CHECKING:
    from contactstudy.scene.solids.coated import CoatedStress

# CF attributes of the coordinate z of a dataset.
Z = {"axis": "Z", "positive": "down"}
# Ratio of successive depths in the search for the largest stress, and ratios of further depths to the best of these. On
# the axis of a line contact the von Mises stress a tenth above and below its maximum is within 0.4 % of it.
COARSE_STEP, FINE_STEPS = 1.35, (1.1**-2, 1.1**-1, 1.1, 1.1**2)
# Widths of the contact down to which the least safety is searched where the yield stress changes with depth: there the
# von Mises stress of a line contact has fallen to a fifth of its largest.
DEEPEST = 4.0
# Relative difference of depths that is rounding, below that of the two sides of an interface.
ROUNDING = 1e-13
# Largest number of values in the result for all chosen depths: 256 MiB.
MAX_VALUES = 2**25


@validated
class SubsurfaceStress:
    """Stress below the surface of one body: all six components and von Mises' stress.

    In a Dataset they are ``stress`` (component, z, x, y) [Pa], tension positive, and ``von_mises`` (z, x, y) [Pa], with
    x across the contact, y along it and z into the body. They are computed when the Dataset is made. Poisson's ratio of
    the body sets xx, yy and xy. In a coated body these three jump at the interface: a depth equal to the thickness is
    the coating's side, any larger one is in the substrate. In a body that yields they include the residual stress,
    interpolated between the middles of its layers. Where the domain repeats along both axes, mean lateral strain is
    prevented, whatever the images: the mean of xx and yy is ``-nu / (1 - nu)`` of the mean pressure.

    Parameters
    ----------
    depths
        One or more depths [m] below the surface of the body, at least zero; ``"auto"`` chooses those that show the
        largest von Mises stress to 1 %, which takes some twenty of them.
    body
        Index (0 or 1) of the body in ``Scene.solids``.

    Raises
    ------
    InvalidInput
        For other depths or indices; in a scene where that body is rigid, or a body yields that rolls in passes.
    """

    depths: tuple[Annotated[Metres, AT_LEAST_ZERO], ...] | Literal["auto"] = "auto"
    body: BodyIndex = 0

    def check_together(self) -> None:
        """Check that there is a depth."""
        if not self.depths:
            raise InvalidInput('SubsurfaceStress.depths is (): give depths [m], such as [1e-4, 2e-4], or "auto".')

    def check(self, solids: tuple[Body, ...]) -> None:
        """Raise :class:`~contactstudy.InvalidInput` for a rigid body, or one that is no half-space."""
        self._medium(solids[self.body])

    def _medium(self, body: Body) -> "HalfSpaceStress | CoatedStress":
        """Return the stress in `body` under tractions on one cell; raises InvalidInput if none is known."""
        if hasattr(body, "stress_model"):
            return body.stress_model  # type: ignore[no-any-return]
        if not hasattr(body, "poisson_ratio"):
            raise InvalidInput(
                f"SubsurfaceStress.body is {self.body}, a {type(body).__name__}: "
                "stress is known in a homogeneous or a coated half-space only, leave this output out."
            )
        if not body.compliance:
            raise InvalidInput(
                f"SubsurfaceStress.body is {self.body}, a rigid body: give {1 - self.body}, the elastic one."
            )
        return HalfSpaceStress(body.poisson_ratio)

    def of(self, solids: tuple[Body, ...], grid: Grid, paddings: Paddings) -> "SubsurfaceStressOperator":
        """Return the stress of these bodies on `grid`."""
        body = solids[self.body]
        medium, length = self._medium(body), getattr(body, "free_faces", inf)
        face_coefficients = None
        if length < inf:
            if not isclose(length, grid.length):
                raise InvalidInput(
                    f"SubsurfaceStress.body is {self.body}, whose free_faces are {readable(length)} apart on a grid of "
                    f"the length {readable(grid.length)}: give a grid as long as the body, or leave this output out."
                )
            assert isinstance(medium, HalfSpaceStress)
            face_coefficients = FreeFaceCoefficients.of(length, medium.poisson_ratio)
        depths = None if isinstance(self.depths, str) else _at_interfaces(body, self.depths)
        profile = getattr(body, "hardness_profile", None)
        return SubsurfaceStressOperator(
            grid, paddings, medium, depths, self.body, face_coefficients=face_coefficients, profile=profile
        )


def _at_interfaces(body: Body, depths: tuple[float, ...]) -> tuple[float, ...]:
    """Return `depths` [m], where each that is an interface of the layers of `body` but for rounding is exactly that."""
    if not is_layered(body):
        return depths
    bottoms = [bottom for *_, bottom in body.parts.values()]
    return tuple(next((at for at in bottoms if isclose(at, depth, rel_tol=ROUNDING)), depth) for depth in depths)


@dataclass(frozen=True, eq=False)
class SubsurfaceStressOperator:
    """Linear map from pressure to stress on one grid, with the images of `paddings`.

    Pressure is padded and summed as for the displacement. Where a window of images ends at two cells that are equally
    far on either side, each of them counts half. The mean of a domain that repeats along both axes is that of infinitely
    many images.

    Parameters
    ----------
    grid, paddings
        Cells, and padding (across, along).
    medium
        The stress in the body under pressure and tangential traction on one cell of its surface.
    depths
        Depths [m]; None for those that show the largest von Mises stress, which ``fields`` chooses.
    body
        0 for the first body, 1 for the second, on which a tangential traction acts the other way.
    shear
        Tangential traction (component, x, y) on the body, or None.
    bulk
        Stress of the whole body along x [Pa].
    residual
        Function that returns the residual stress of a body that yields as a function of depths [m], or None if there is
        none yet; None of a body that does not yield.
    face_coefficients
        Influence coefficients of the displacement of the body if it has free faces, else None.
    profile
        Yield stress by depth, with which chosen depths also include that of the least safety; or None.
    """

    grid: Grid
    paddings: Paddings
    medium: "HalfSpaceStress | CoatedStress"
    depths: tuple[float, ...] | None
    body: int = 0
    shear: Array | None = None
    bulk: float = 0.0
    residual: Callable[[], ResidualStress | None] | None = None
    face_coefficients: FreeFaceCoefficients | None = None
    profile: HardnessProfile | None = None

    def with_residual_stress(
        self, residual: Callable[[int, float], ResidualStress | None]
    ) -> "SubsurfaceStressOperator":
        """Return this map with the residual stress of the body added, if it yields.

        The function `residual` takes the index of the body and the largest depth [m], and returns its residual stress
        as a function of depths [m]; None without any.
        """
        deepest = self.grid.extent[0] if self.depths is None else max(self.depths)
        return replace(self, residual=partial(residual, self.body, deepest))

    def with_shear(self, shear: Array, bulk: tuple[float, float] = (0.0, 0.0)) -> "SubsurfaceStressOperator":
        """Return this map with `shear` (component, x, y) on the first body, and its reaction on the second.

        The stress `bulk` [Pa] of either body along x comes with the one along y that prevents strain along y.
        """
        return replace(self, shear=-shear if self.body else shear, bulk=bulk[self.body])

    def __call__(self, pressure: Array) -> Array:
        """Return stress (component, z, x, y) at the given depths in the unit of `pressure` (x, y)."""
        assert self.depths is not None
        stress = self._stress_of("pressure", pressure)
        if self.shear is not None:
            for direction, shear in zip(("across", "along"), self.shear, strict=True):
                if shear.any():
                    stress += self._stress_of(direction, shear)
        if self.bulk:
            assert isinstance(self.medium, HalfSpaceStress)
            stress[0] += self.bulk
            stress[1] += self.medium.poisson_ratio * self.bulk
        if self.residual is not None and (residual := self.residual()) is not None:
            stress += residual(np.array(self.depths))
        return stress

    def _stress_of(self, traction: str, values: Array) -> Array:
        """Return the stress (component, z, x, y) due to the `values` (x, y) of a surface `traction`.

        That is "pressure", or tangential traction "across" or "along".
        """
        assert self.depths is not None
        if self.face_coefficients is not None:
            from contactstudy.elasticity.free_faces import StressByFaces  # imported only for bodies with faces

            # the stress of an endless body under the load mirrored in both faces, and the part of loads on the faces
            faces = StressByFaces(self.face_coefficients, self.grid)
            endless = ZeroPadding(), ExactPeriodicity()
            mirrored = replace(self, grid=faces.continued_grid, paddings=endless, face_coefficients=None)
            stress = mirrored._stress_of(traction, faces.continued_load(values))
            (nx, ny), start = self.grid.cells, faces.beside
            return np.asarray(faces.stress(values, self.depths) + stress[:, :, start : start + nx, :ny])
        padded = padded_cells(self.grid, self.paddings)
        spectrum = TRANSFORMS.forward(values, padded)
        buffer = np.empty((padded[0], padded[1] // 2 + 1), dtype=np.complex128)
        stress = np.empty((len(COMPONENTS), len(self.depths), *self.grid.cells))
        # the mean of a domain that repeats along both axes would depend on the number of images in a window
        lacks_mean = self._repeats and any(padding.window is not None for padding in self.paddings)
        # What all components of one depth share is kept only until the next depths.
        for level, depth in enumerate(self.depths):
            for number, name in enumerate(COMPONENTS):
                terms = self.medium.coefficients(traction, name, depth)
                around = on_padded_grid(terms, self.grid, self.paddings)
                waves = TRANSFORMS.forward(around, padded, buffer)
                waves *= spectrum
                field = TRANSFORMS.backward(waves, self.grid.cells, padded)
                if lacks_mean:
                    # stress under a uniform unit load: the sum of that under each of two cells, the fewest of a grid
                    halves, exact = Grid((2, 1), self.grid.extent), ExactPeriodicity()
                    uniform = float(on_padded_grid(terms, halves, (exact, exact)).sum())
                    field += uniform * float(values.mean()) - field.mean()
                stress[number, level] = field
        return stress

    @property
    def _repeats(self) -> bool:
        """True where the domain repeats along both axes."""
        return not any(map(is_free, self.paddings))

    def searched_depths(self, width: float) -> list[float]:
        """Return the depths [m] from the surface to below a contact of this `width` [m] at which a search begins."""
        cell = min(self.grid.cell_size)
        kinks = self.profile.points[0] if self.profile else ()  # the first of these depths is 0
        deepest = max(width, 2 * cell, min(max(kinks, default=0.0), DEEPEST * width))
        count = 2 + int(np.ceil(np.log(2 * deepest / cell) / np.log(COARSE_STEP)))
        return [0.0, *np.geomspace(cell / 2, deepest, count).tolist(), *self.medium.interface_depths, *kinks[1:]]

    def at_chosen_depths(self, pressure: Array) -> dict[float, Array]:
        """Return the stress (component, x, y) by ascending depths [m] that include the largest von Mises stress, to 1 %.

        Near its maximum the stress changes slowly with depth, so that steps by a third find the neighbouring depths, and
        steps by a tenth between them the maximum. On a large grid only the depth of the maximum, its neighbours and both
        sides of an interface are returned. The least safety is found likewise where the yield stress changes with depth.
        """
        rows = np.flatnonzero((pressure > 0).any(axis=1))
        width = (rows[-1] - rows[0] + 1) * self.grid.cell_size[0] if rows.size else 0.0
        # stress at each depth tried, as far as memory allows, and the largest von Mises stress there
        stress: dict[float, Array] = {}
        largest: dict[float, float] = {}
        residual = None if self.residual is None else self.residual()

        def at(depth: float) -> Array:
            """Return the stress (component, x, y) at a depth [m]."""
            return replace(self, depths=(depth,), residual=lambda: residual)(pressure)[:, 0]

        def critical(depths: Iterable[float], strength: Callable[[float], float]) -> float:
            """Try `depths`, and return that of all tried where the stress over the `strength` is largest."""
            for depth in {*map(float, depths)} - largest.keys():
                stress[depth] = at(depth)
                largest[depth] = float(von_mises(stress[depth]).max())
                if (len(COMPONENTS) + 1) * len(stress) * pressure.size > MAX_VALUES:
                    del stress[depth]
            return max(largest, key=lambda depth: largest[depth] / strength(depth))

        strengths: list[Callable[[float], float]] = [lambda _: 1.0]
        if (profile := self.profile) is not None:
            strengths.append(lambda depth: float(profile.yield_stress(np.array(depth))))
        found = []
        for strength in strengths:
            best = critical(self.searched_depths(width), strength)
            found.append(critical((best * factor for factor in FINE_STEPS), strength) if best > 0 else best)
        depths = sorted(largest)
        if len(stress) < len(depths):
            near = {depth for n in map(depths.index, found) for depth in depths[max(n - 1, 0) : n + 2]}
            depths = sorted({*near, *self.medium.interface_depths})
        return {depth: stress[depth] if depth in stress else at(depth) for depth in depths}

    def fields(self, pressure: Array) -> Mapping[str, Field]:
        """Return ``stress``, ``von_mises`` and their coordinates ``component`` and ``z``."""
        if self.depths is None:
            chosen = self.at_chosen_depths(pressure)
            depths, stress = tuple(chosen), np.stack(list(chosen.values()), axis=1)
        else:
            depths, stress = self.depths, self(pressure)
        dimensions = ("component", "z", "x", "y")
        names = np.array(list(COMPONENTS))
        comment = {"comment": "mean lateral strain is prevented"} if self._repeats else {}
        return {
            "stress": Field(dimensions, stress, "Pa", "stress, tension positive", comment),
            "von_mises": Field(dimensions[1:], von_mises(stress), "Pa", "von Mises stress"),
            "component": Field(("component",), names, "1", "x across the contact line, y along it, z into the body"),
            "z": Field(("z",), np.array(depths), "m", "depth below the surface", Z),
        }


def surface_beyond(
    output: SubsurfaceStress, solids: tuple[Body, ...], grid: Grid, paddings: Paddings, stress: Array
) -> Iterator[tuple[Grid, Array]]:
    """Yield, without end, grids 3, 9 ... times as wide as `grid`, with the stress (component, x, y) at the surface.

    The grids have as many cells. The tractions are those of the `stress` (component, x, y) at the surface on `grid`, as
    means over larger cells. An axis with images, or of one cell, stays as it is; nothing is yielded where both do.
    """
    widens = [is_free(padding) and count > 1 for padding, count in zip(paddings, grid.cells, strict=True)]
    # pressure -zz on the surface of this body, and the tractions -xz across and -yz along on it
    tractions = -stress[[2, 4, 3]]
    while any(widens):
        for axis, (widens_here, count) in enumerate(zip(widens, grid.cells, strict=True), 1):
            if widens_here:
                around = [(count, count) if each == axis else (0, 0) for each in range(3)]
                padded = np.moveaxis(np.pad(tractions, around), axis, -1)
                means = padded.reshape(*padded.shape[:-1], count, 3).mean(axis=-1)
                tractions = np.moveaxis(means, -1, axis)
        width, length = (3 * size if wider else size for size, wider in zip(grid.extent, widens, strict=True))
        grid = Grid(grid.cells, (width, length))
        below = replace(output.of(solids, grid, paddings), depths=(0.0,), shear=tractions[1:])
        yield grid, below(tractions[0])[:, 0]


def von_mises(stress: Array) -> Array:
    """Return ``sqrt(3/2 s:s)`` of the deviator s, from components in the order of ``COMPONENTS``."""
    xx, yy, zz, yz, xz, xy = stress
    normal = ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2
    return np.asarray(np.sqrt(normal + 3 * (yz**2 + xz**2 + xy**2)))


def principal_stresses(stress: Array) -> tuple[Array, Array]:
    """Return the largest and the least principal stress, from components in the order of ``COMPONENTS``.

    They follow from the invariants J2 and J3 of the deviator (Malvern 1969, sect. 3.3).
    """
    xx, yy, zz, yz, xz, xy = stress
    mean = (xx + yy + zz) / 3
    a, b, c = xx - mean, yy - mean, zz - mean
    third = a * b * c + 2 * yz * xz * xy - a * yz**2 - b * xz**2 - c * xy**2
    size = von_mises(stress) / 3  # root of J2 / 3
    cosine = third / np.maximum(2 * size**3, np.finfo(np.float64).tiny)
    angle = np.arccos(np.clip(cosine, -1, 1)) / 3
    return mean + 2 * size * np.cos(angle), mean + 2 * size * np.cos(angle + 2 * np.pi / 3)


def largest_shear(stress: Array) -> Array:
    """Return the largest shear stress on any plane, half the difference of the outer principal stresses (Tresca)."""
    largest, least = principal_stresses(stress)
    return (largest - least) / 2


def orthogonal_shear(stress: Array) -> Array:
    """Return the amplitude of the shear stress xz, half its range along x at one depth, as fields (..., x, y).

    A point of a body that rolls along x sees the whole range (Lundberg & Palmgren 1947). The amplitude is the largest
    value of the field along x, which at each place is half the distance of the shear stress from the farther end of its
    range. The field then has a maximum wherever the shear stress has one.
    """
    shear = stress[4]
    lowest, highest = shear.min(axis=-2, keepdims=True), shear.max(axis=-2, keepdims=True)
    return np.asarray(np.maximum(shear - lowest, highest - shear) / 2)
