"""Displacement and stress of bodies that end along their length at two faces, which are free of traction.

A body is taken for three half-spaces, whose stresses add up: one below the surface, one behind each face. The loads on
them together leave the surface with its pressure and the faces without traction (Hetenyi 1970; Wang, Guo, Wong & Zhang
2017). The load P on the surface is continued evenly about both faces, which leaves no shear on them, but a normal
stress. A load q on the face that cancels it, mirrored about the surface, leaves the surface in place and a normal
stress on it, for which P differs from the pressure p. Both stresses come from one operator S, since the geometry is the
same seen from either plane: the normal stress on the other plane, tension positive, by a load that presses on one::

    P = p + S q,   q = S P   so that   u = K P = K p + K (I - S S)^-1 S S p,

where u is the displacement, and K the response of the half-space to an evenly continued load. Each face is that of a
quarter-space, but for `COUPLING`.

:func:`between_faces` makes the operator from p to u, and :class:`StressByFaces` the stress below the surface by the
loads q. Across the contact everything is a convolution. For waves of the wave number k the last term is a function of
k y and k y' alone, with the distances y and y' from the face, so that one table for each Poisson's ratio holds for all
bodies and grids.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import e
from typing import NamedTuple, Self

import numpy as np
from scipy import fft

from contactstudy.domain.device import Precision, cached_array
from contactstudy.domain.grid import Array, Grid, Paddings
from contactstudy.domain.validation import InvalidInput
from contactstudy.elasticity.convolution import (
    Coefficients,
    Convolution,
    FreeFaceCoefficients,
    coarsened_spectrum,
    even_spectrum,
    influence_coefficients,
)
from contactstudy.elasticity.kernels.stress import BOUSSINESQ, COMPONENTS, CellKernel
from contactstudy.elasticity.transforms import ComplexField, transforms

# Changes by other values of a constant are given below as fractions of the largest displacement or stress under Hertz's
# pressure, on a body 8 half-widths long. Cells are 1/8 of a half-width for displacement, and 1/4 for stress, which is
# taken at depths of 0.1 to 1 half-width.
#
# Ratio of neighbouring distances from the face in the table, of which a grid uses every third, the stride. Between,
# values are interpolated by cubics in the logarithm of the distance. The root of the ratio changes displacement by 8e-5,
# its square by 3e-4; a stride of 1 by 7e-6, of 6 by 1e-4.
RATIO, STRIDE = 1.1, 3
# First and last distance in the table, in units of 1 / k. The first is short enough for cells of 4e-6 widths of the
# grid; at the last exp(-30) is left.
NEAREST, FARTHEST = 1e-8, 30.0
# First distance from the face on a grid, over the length of a cell. Nearer to the face values are those at this
# distance; cubics there take a node one step nearer. Half of it changes stress by 5e-3, twice by 3e-2.
FIRST_NODE = 0.0625
# Length and power p of the coupling of both faces, fitted. What a load adds at its own face, it takes from the other
# face in the ratio ``exp(-(k L / length)^p)``, in a body of the length L. So both faces together sink over the middle
# as in finite elements of such bodies under waves, within 6 % for Poisson's ratio 0.3 and k L from 0.4 to 10. Two
# quarter-spaces would sink 1 to 6 times as much.
COUPLING = 2.0, 1.15
# Where the response across is summed from waves, it repeats after 2 WIDTHS widths of the grid: its images then are at
# least 15 widths away. Half of this number changes displacement by 2e-4, twice by 7e-5.
WIDTHS = 8
# Depth [body lengths] to which loads on a face are summed: with twice that, the stress under a ridge on bodies of 2 to
# 40 half-widths changes by at most 3e-4 of the largest. Beyond the body length they are taken for constant.
DEPTH = 4.0
# Number of rows of waves that are multiplied at once: they stay in the processor's cache.
ROWS = 8


class FaceTable(NamedTuple):
    """Response of a body with one face to a unit line load along x that varies as ``cos(k x)``, less the half-space's.

    Arrays are (point, line), by the distances of both from the face.

    The `distances` (n,) of points and lines from the face are in units of 1 / k. Points are on the surface; those of
    `on_face` are on the face, at these distances from the surface.
    """

    distances: Array
    #: E* times the displacement of the surface.
    displacement: Array
    #: Additional load P - p on the surface [k], and the load q on the face.
    on_surface: Array
    on_face: Array


@lru_cache(maxsize=8)
def face_table(poisson_ratio: float) -> FaceTable:
    """Return the table of a material, in which loads are constant between the geometric means of distances.

    It solves the equations of the module's docstring for P and q. The operator S there is the transform across of
    Boussinesq's stress on the face by a load and its mirror image: rows are the depths of the stress, columns the
    distances of the load from the face.
    """
    from scipy.special import iti0k0, k0, k1  # imported late, since it is slow

    count = int(np.ceil(np.log(FARTHEST / NEAREST) / np.log(RATIO)))
    edges = NEAREST * RATIO ** np.arange(count + 1)
    widths = np.diff(edges)
    nodes, _ = np.polynomial.legendre.leggauss(2)
    points = (edges[:-1, None] + widths[:, None] * (nodes + 1) / 2).ravel()

    def means(values: Array, *axes: int) -> Array:
        """Return the means over the cells of `values` at the points."""
        for axis in axes:
            shape = (*values.shape[:axis], count, 2, *values.shape[axis + 1 :])
            values = values.reshape(shape).mean(axis=axis + 1)
        return values

    # the integral of K0(sqrt(y^2 + t^2)) over t from z on
    finer, finer_weights = np.polynomial.legendre.leggauss(4)
    ends = np.append(points, 2 * FARTHEST)
    t = ends[:-1, None] + np.diff(ends)[:, None] * (finer + 1) / 2
    panels = k0(np.hypot(points[:, None, None], t)) @ (finer_weights / 2) * np.diff(ends)
    beyond = np.cumsum(panels[:, ::-1], axis=1)[:, ::-1].T
    y, z = points, points[:, None]
    r = np.hypot(y, z)
    stress = (1 - 2 * poisson_ratio) * beyond - z * y**2 / r**2 * (k0(r) + 2 * k1(r) / r)
    s = 2 / np.pi * means(stress, 1, 0) * widths
    # the integral of K0 over each loaded cell and its mirror image
    near, far = (np.abs(points[:, None] - sign * edges) for sign in (1, -1))
    integral = np.sign(points[:, None] - edges) * iti0k0(near)[1] - iti0k0(far)[1]
    displacement = 2 / np.pi * means(-np.diff(integral, axis=1), 0)
    squared = s @ s
    load = np.linalg.solve(np.eye(count) - squared, squared) / widths
    table = displacement @ load
    distances = np.sqrt(edges[1:] * edges[:-1])
    # by reciprocity the table is symmetric but for the discretisation
    return FaceTable(distances, (table + table.T) / 2, load, s / widths + s @ load)


@dataclass(frozen=True, eq=False)
class Faces:
    """Additional displacement of the cells between two faces, or additional load, by the pressure on these cells.

    Fields are known at m distances from each face, the nodes, and interpolated between them. Pressure is divided into a
    part that is equal at both faces and one that is opposite, which do not couple.

    Attributes
    ----------
    weights
        Weights (ny, m) by which each cell along y has its value from those at the nodes of the first face.
    kernel
        Displacement [m/Pa], or load, at nodes over the pressure at nodes, for each wave across and the equal, then the
        opposite part (px // 2 + 1, 2, m, m).
    """

    weights: Array
    kernel: Array

    @cached_property
    def of_both(self) -> Array:
        """Weights (ny, 2 m), times sqrt(1/2), of the equal, then of the opposite parts at the nodes of both faces."""
        first, second = self.weights * 0.5**0.5, self.weights[::-1] * 0.5**0.5
        return np.concatenate([first + second, first - second], axis=1)

    def __call__(self, pressure: Array, across: int) -> Array:
        """Return the displacement or load (x, y) under `pressure`, with transforms of `across` points."""
        waves = self.parts(pressure, across).reshape(across // 2 + 1, -1)
        return np.asarray(fft.irfft(waves, across, axis=0)[: len(pressure)] @ self.of_both.T)

    def parts(self, pressure: Array, across: int) -> ComplexField:
        """Return the transform across (wave, 2, m) of what is added, the equal and the opposite part, at the nodes."""
        waves = fft.rfft(pressure @ self.of_both, across, axis=0)
        count, m = len(waves), self.weights.shape[1]
        # the kernel is real: real and imaginary parts are two columns
        parts = self.kernel @ waves.view(pressure.dtype).reshape(count, 2, m, 2)
        of_parts: ComplexField = parts.view(waves.dtype)[..., 0]
        return of_parts

    def scaled(self, factor: float, precision: Precision) -> "Faces":
        """Return this times `factor`, in `precision`."""
        real = precision.real
        return Faces(self.weights.astype(real), (factor * self.kernel).astype(real))

    def coarsened(self, across: int, along: int) -> "Faces":
        """Return the same on larger cells: mean displacement of blocks under a pressure constant in each."""
        # `weights` are means, and a larger cell has the load of `along` cells
        kernel, (ny, m) = self.kernel * along, self.weights.shape
        if across == 2:
            shortest = len(kernel) - 1
            waves = np.arange(shortest // 2 + 1)
            # a wave and its alias on cells of half the size add up by the squares of their means over two cells
            low = np.cos(np.pi / (2 * shortest) * waves) ** 2
            low = low[:, None, None, None].astype(kernel.dtype)
            kernel = low * kernel[waves] + (1 - low) * kernel[shortest - waves]
        return Faces(self.weights.reshape(ny // along, along, m).mean(axis=1), kernel)


@dataclass(frozen=True, eq=False)
class EndedConvolution(Convolution):
    """Linear map from pressure to displacement of two bodies, of which one or both end along the length.

    The spectrum is that of the loads themselves and of their images of period 2 L.

    Parameters
    ----------
    mirrored
        Transform (px, py // 2 + 1) [m/Pa] of the coefficients of the images mirrored about the faces, as a function of
        the sum of the distances of load and point from the first end of the grid.
    faces
        What the normal stress on the faces adds, one value for each body that ends.
    """

    mirrored: Array
    faces: tuple[Faces, ...]

    def __call__(self, pressure: Array) -> Array:
        """Return the displacement (x, y) [m] under a `pressure` (x, y) [Pa]."""
        if pressure.shape != self.cells:
            raise InvalidInput(f"pressure has the shape {pressure.shape}: give it {self.cells}.")
        pair = transforms()
        waves = pair.forward(pressure, self.padded, self.work_array(self.padded, self.spectrum.dtype))
        px, half = self.padded[0], self.padded[0] // 2 + 1
        for start in range(0, half, ROWS):  # a large new array costs as much as a transform
            rows = np.arange(start, min(start + ROWS, half))
            spectrum, mirrored = self.spectrum[rows], self._mirrored_with_phase[rows]
            opposite = -rows % px
            own, mirror = waves[rows], waves[opposite]
            # the transform of a field that is mirrored along y is the conjugate one of the opposite wave across
            waves[rows] = own * spectrum + mirror.conj() * mirrored
            waves[opposite] = mirror * spectrum + own.conj() * mirrored
        displacement = pair.backward(waves, self.cells, self.padded)
        for faces in self.faces:
            displacement += faces(pressure, self.padded[0])
        return displacement

    @cached_property
    def _mirrored_with_phase(self) -> ComplexField:
        """Half the rows of `mirrored`, moved by a cell: cells i and j are ``(i + j + 1) dy`` from the end together."""
        phase = np.exp(2j * np.pi / self.padded[1] * np.arange(self.padded[1] // 2 + 1))
        of_half = self.mirrored[: self.padded[0] // 2 + 1]
        mirrored: ComplexField = of_half * phase.astype(np.result_type(self.mirrored, 1j))
        return mirrored

    def scaled(self, factor: float, precision: Precision) -> Self:
        """Return this operator times `factor`, in `precision`."""
        mirrored = np.multiply(factor, self.mirrored).astype(precision.real)
        faces = tuple(faces.scaled(factor, precision) for faces in self.faces)
        return replace(super().scaled(factor, precision), mirrored=mirrored, faces=faces)

    def coarsened(self) -> Self:
        """Return the operator on larger cells, as :meth:`Convolution.coarsened`."""
        mirrored = coarsened_spectrum(self.mirrored, self.padded, self.blocks)
        faces = tuple(faces.coarsened(*self.blocks) for faces in self.faces)
        return replace(super().coarsened(), mirrored=mirrored, faces=faces)


def between_faces(response: Mapping[Coefficients, float], grid: Grid, paddings: Paddings) -> Convolution:
    """Return the operator from pressure to displacement of bodies, some of which end along the length.

    Faces may be within `grid` or beyond its ends; the middle of each body is that of the grid.

    Parameters
    ----------
    response
        Weight [1/Pa] of the coefficients [m] of each body; those of a body that ends are ``FreeFaceCoefficients``.
    grid
        Cells and extent. Cells beyond a face carry no pressure, and their displacement has no meaning.
    paddings
        Paddings (across, along), both with zeros.
    """
    # exactly twice the cells along: the coefficients of mirrored images are even about half of it
    padded = 2 * fft.next_fast_len(grid.cells[0]), 2 * grid.cells[1]
    spectrum = np.zeros((padded[0], padded[1] // 2 + 1))
    mirrored, faces = spectrum.copy(), []
    for body, weight in response.items():
        if not isinstance(body, FreeFaceCoefficients):
            spectrum += weight * even_spectrum(influence_coefficients(grid, paddings, body), padded)
            continue
        to_face = (body.length - grid.length) / 2
        spectrum += weight * _images(body, 0.0, grid, padded)
        mirrored += weight * _images(body, 2 * to_face, grid, padded)
        added = faces_on(body, grid, padded[0])  # weights are those of 1 / (pi E*), and the table is that of 1 / E*
        faces.append(added.scaled(np.pi * weight, Precision.DOUBLE))
    ends = True, True
    return EndedConvolution(spectrum, grid.cells, padded, mirrored, tuple(faces), ends=ends)


def _images(body: FreeFaceCoefficients, offset: float, grid: Grid, padded: tuple[int, int]) -> Array:
    """Return the transform (px, py // 2 + 1) of the coefficients of `body` with images of a period of two body lengths.

    An `offset` [m] along y is added to the distance of load and point.
    """

    def spectrum() -> Array:
        """Return the transform, which is kept."""
        (nx, ny), (dx, dy) = grid.cells, grid.cell_size
        x, y = np.arange(nx)[:, None] * dx, np.abs(np.arange(ny + 1.0) * dy + offset)
        return even_spectrum(body.row(x, y, dx, dy, 2 * body.length), padded)

    return cached_array((body, offset, grid), spectrum)


def faces_on(body: FreeFaceCoefficients, grid: Grid, across: int, added: str = "displacement") -> Faces:
    """Return what the faces of `body` add on `grid`, the field of :class:`FaceTable` that is named `added`.

    Transforms across have `across` points. At a distance x across, what the faces add is the cosine transform of the
    table over wave numbers in equal steps, at which the table is interpolated. Under waves longer than the body, a load
    at one face also acts on the other, see `COUPLING`.
    """
    to_face = (body.length - grid.length) / 2
    (nx, ny), (dx, dy) = grid.cells, grid.cell_size
    step = STRIDE * np.log(RATIO)
    first = first_distance(body, grid)
    # means over 16 points of each cell, of functions that are cubic in the logarithm of the distance; 32 change 3e-6
    fine = (np.arange(16) + 0.5) / 16
    distance = to_face + (np.arange(ny)[:, None] + fine) * dy
    index = np.log(np.maximum(distance / first, 1)) / step + 1
    count = int(index.max()) + 3
    weights = cardinal(index.ravel(), count).reshape(ny, len(fine), count).mean(axis=1)

    def kernel() -> Array:
        """Return the kernel of :class:`Faces`, which is kept."""
        points = 2 * WIDTHS * nx
        k = 2 * np.pi / (points * dx) * np.arange(points // 2 + 1)
        k[0] = k[1] / (2 * e)  # the mean of a logarithm over half a step is its value there
        of_material = face_table(body.poisson_ratio)
        distances, table = of_material.distances, getattr(of_material, added)
        index = np.log(k * first / distances[0]) / np.log(RATIO) - STRIDE
        lowest = int(index[0]) - 1
        levels = int(index[-1]) + 3 - lowest
        of_load = np.sinc(k * dx / (2 * np.pi))[:, None] * cardinal(index - lowest, levels)
        response = fft.irfft(of_load, points, axis=0)[:nx]
        offsets = np.arange(across // 2 + 1)
        waves = fft.dct(response[np.minimum(offsets, nx - 1)], 1, axis=0)
        # rows and columns of the table at each level, zero beyond it
        steps = lowest + np.arange(levels)  # none below 0 on cells longer than 4e-6 widths of the grid
        last = steps[-1] + 1 + STRIDE * count
        whole = np.pad(table, (0, max(last - len(table), 0)))
        blocks = np.stack([whole[n:last:STRIDE, n:last:STRIDE][:count, :count] for n in steps])
        levels_of_k = distances[0] / first * RATIO ** (steps + STRIDE)
        length, power = COUPLING
        equal = -np.expm1(-((levels_of_k * body.length / length) ** power))
        share = np.stack([equal, 2 - equal], axis=1)
        if added != "displacement":
            share *= levels_of_k[:, None]
        parts = share[:, :, None, None] * blocks[:, None]
        return np.asarray(np.tensordot(waves, parts, axes=1) * dy)

    return Faces(weights, cached_array((added, body, grid), kernel))


def first_distance(body: FreeFaceCoefficients, grid: Grid) -> float:
    """Return the first distance [m] from the faces of `body` that is used on `grid`, the second node."""
    return max((body.length - grid.length) / 2, 0.0) + FIRST_NODE * grid.cell_size[1]


def cardinal(index: Array, count: int) -> Array:
    """Return the weights of `count` values (points, count) in cubic interpolation at `index`, from the nearest four."""
    t = np.abs(index[:, None] - np.arange(count))
    near, far = (1 - t**2) * (2 - t) / 2, (1 - t) * (2 - t) * (3 - t) / 6
    return np.where(t < 1, near, np.where(t < 2, far, 0.0))


# For each component of stress in the body: its name in the half-space behind the first face, whose depth z is the
# body's y; and its sign by a load on the second face, over that by the same load on the first one.
ON_FACE = {
    "xx": ("xx", 1), "yy": ("zz", 1), "zz": ("yy", 1), "yz": ("yz", -1), "xz": ("xy", 1), "xy": ("xz", -1),
}  # fmt: skip
# Ratio of the sizes of neighbouring cells down a face, away from the surface and from the depth of the stress, where
# cells are finest. A ratio of 1.15 changes stress by 7e-3, one of 1.6 by 3e-3.
GROWTH = 1.3


@dataclass(frozen=True, eq=False)
class StressByFaces:
    """Loads on the surface and on the faces of `body` under a pressure on `grid`, and stress by the loads on the faces.

    The ends of `grid` along y are the faces. The load on the surface is the pressure and what the faces add to it, as
    if mirrored about both faces. The load on each face is mirrored about the surface. Loads on a face are known at
    distances from the surface in a geometric progression, the nodes; the same distances from the face are nodes of the
    stress.
    """

    body: FreeFaceCoefficients
    grid: Grid

    @property
    def beside(self) -> int:
        """Cells beside the contact, on either side across, on which the faces add to the load as well."""
        return self.grid.cells[0] // 2

    @property
    def continued_grid(self) -> Grid:
        """Grid of the load that is continued beside the contact and, evenly about a face, to twice the length."""
        (nx, ny), dx = self.grid.cells, self.grid.cell_size[0]
        across = nx + 2 * self.beside
        return Grid((across, 2 * ny), (across * dx, 2 * self.grid.length))

    def continued_load(self, pressure: Array) -> Array:
        """Return the load on the surface (x, 2 y) on the continued grid under a `pressure` (x, y)."""
        pressure = self._widened(pressure)
        load = pressure + self._on_wide_grid("on_surface")(pressure, self._across)
        return np.concatenate([load, load[:, ::-1]], axis=1)

    def _widened(self, pressure: Array) -> Array:
        """Return a `pressure` (x, y) with zeros on the cells beside the contact."""
        return np.pad(pressure, ((self.beside, self.beside), (0, 0)))

    @property
    def _across(self) -> int:
        """Number of points of the Fourier transforms along x."""
        return 2 * int(fft.next_fast_len(self.continued_grid.cells[0]))

    def _on_wide_grid(self, added: str) -> Faces:
        """Return the field `added` by the faces on the grid with the cells beside the contact.

        It is the name of a field of ``FaceTable``: a load ``"on_surface"``, or ``"on_face"``.
        """
        (nx, _), (width, _) = self.continued_grid.cells, self.continued_grid.extent
        grid = Grid((nx, self.grid.cells[1]), (width, self.grid.length))
        return faces_on(self.body, grid, self._across, added)

    def stress(self, pressure: Array, depths: tuple[float, ...]) -> Array:
        """Return the stress (component, z, x, y) [Pa] at some `depths` [m] by the loads on both faces alone."""
        pressure = self._widened(pressure)
        faces = self._on_wide_grid("on_face")
        equal, opposite = np.moveaxis(faces.parts(pressure, self._across), 1, 0) / np.sqrt(2)
        # transforms of the loads on the first and on the second face (wave, face, node), from their sum and difference
        waves = np.stack([equal + opposite, equal - opposite], axis=1)
        stress = np.empty((len(COMPONENTS), len(depths), *self.grid.cells))
        inside = slice(self.beside, self.beside + self.grid.cells[0])
        for level, depth in enumerate(depths):
            edges = self._edges(depth)
            of_cells = self._interpolation(np.abs(edges[1:] + edges[:-1]) / 2, waves.shape[2])
            on_cells = waves @ of_cells.T  # (wave, face, cell)
            parts = np.concatenate([on_cells.real, on_cells.imag], axis=1)  # kernels are real
            for number, name in enumerate(COMPONENTS):
                on_face, sign = ON_FACE[name]
                component = BOUSSINESQ[on_face]
                kernel = self._kernel(component, depth, edges, waves.shape[2])
                real, imaginary = np.split(parts @ kernel, 2, axis=1)
                at_nodes = (real + 1j * imaginary) * (1 if component.parity[0] > 0 else -1j)
                fields = fft.irfft(at_nodes, self._across, axis=0)[inside]
                first, second = fields[:, 0] @ faces.weights.T, fields[:, 1] @ faces.weights[::-1].T
                stress[number, level] = first + sign * second
        return stress

    def _edges(self, depth: float) -> Array:
        """Return the edges [m] of cells down a face and its mirror image, finest at the surface and at `depth`."""
        # an eighth of a cell changes stress by 4e-3, a half by 2e-2
        finest, farthest = self.grid.cell_size[1] / 4, DEPTH * self.body.length
        count = int(np.ceil(np.log(farthest / finest) / np.log(GROWTH)))
        steps = np.append(0, finest * GROWTH ** np.arange(count))
        centres = np.array([0, depth, -depth])
        candidates = np.unique(np.add.outer(centres, [*steps, *-steps]))
        edges = [candidates[0]]
        # leave out edges of slivers where the cells about two centres overlap
        for edge in candidates:
            size = max(finest, (GROWTH - 1) * np.abs(edge - centres).min()) / 2
            if edge - edges[-1] > size:
                edges.append(edge)
        return np.array(edges)

    def _interpolation(self, distance: Array, count: int) -> Array:
        """Return the weights (n, count) of `count` nodes by which a load has its value at each `distance` (n,) [m]."""
        step = STRIDE * np.log(RATIO)
        index = np.log(np.maximum(distance / first_distance(self.body, self.grid), 1)) / step + 1
        return cardinal(np.minimum(index, count - 2), count)

    def _kernel(self, component: CellKernel, depth: float, edges: Array, count: int) -> Array:
        """Return the transform (wave, cell, node) along x of a stress `component` by unit loads on cells of a face.

        The cells lie between the `edges`, the component is that in the half-space of the face, at a `depth` below the
        surface and at `count` nodes, distances from the face. It is real: of a component that is odd along x it is the
        sine transform, and the Fourier transform is -i times that.
        """
        dx, step = self.grid.cell_size[0], RATIO**STRIDE
        nodes = first_distance(self.body, self.grid) * step ** (np.arange(count) - 1.0)
        x = (np.arange(self._across // 2 + 1) - 0.5) * dx
        u, v, y = np.broadcast_arrays(x[:, None, None], (depth - edges)[:, None], nodes)
        point = u, v, y, np.sqrt(u * u + v * v + y * y)  # at many depths y at once
        corners = component.corner(*point, self.body.poisson_ratio)  # type: ignore[arg-type]
        half = -np.diff(np.diff(corners, axis=0), axis=1) / (2 * np.pi)
        if component.parity[0] > 0:
            return np.asarray(fft.dct(np.concatenate([half, 0 * half[:1]]), 1, axis=0))
        return np.pad(fft.dst(half[1:], 1, axis=0), ((1, 1), (0, 0), (0, 0)))
