"""Stress below the surface of a body that ends along its length at two free faces.

The body is taken for three half-spaces, whose stresses add up: one below the surface, one behind each face. The loads
on them together leave the surface with its pressure and the faces without traction (Hetenyi 1970; Wang, Guo, Wong &
Zhang 2017). The module `free_faces` finds these loads.
"""

from dataclasses import dataclass

import numpy as np
from scipy import fft

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.elasticity.coefficients import FreeFaceCoefficients
from contactstudy.elasticity.free_faces import CONSTANTS, Faces, cardinal, faces_on, first_distance
from contactstudy.elasticity.kernels.stress_cell import COMPONENTS, CellKernel

# For each component of stress in the body, its name in the half-space of the first face, where the depth is y, not z,
# and its sign by a load on the second face over that by the same load on the first.
ON_FACE = {
    "xx": ("xx", 1), "yy": ("zz", 1), "zz": ("yy", 1), "yz": ("yz", -1), "xz": ("xy", 1), "xy": ("xz", -1),
}  # fmt: skip
# Ratio of the sizes of neighbouring cells down a face, away from the depths where cells are finest.
GROWTH = 1.3


@dataclass(frozen=True, eq=False)
class StressByFaces:
    """Loads on the surface and on the faces of `body` under a pressure on `grid`, and the stress by those on the faces.

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
        load = pressure + self._on_wide_grid("load")(pressure, self._across)
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

        It is the name of a field of ``FaceTable``: ``"load"`` on the surface, or ``"pressure"`` on the faces.
        """
        (nx, _), (width, _) = self.continued_grid.cells, self.continued_grid.extent
        grid = Grid((nx, self.grid.cells[1]), (width, self.grid.length))
        return faces_on(self.body, grid, self._across, added)

    def stress(self, pressure: Array, depths: tuple[float, ...]) -> Array:
        """Return the stress (component, z, x, y) [Pa] at some `depths` [m] by the loads on both faces alone."""
        pressure = self._widened(pressure)
        faces = self._on_wide_grid("pressure")
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
                component = COMPONENTS[on_face]
                kernel = self._kernel(component, depth, edges, waves.shape[2])
                real, imaginary = np.split(parts @ kernel, 2, axis=1)
                at_nodes = (real + 1j * imaginary) * (1 if component.parity[0] > 0 else -1j)
                fields = fft.irfft(at_nodes, self._across, axis=0)[inside]
                first, second = fields[:, 0] @ faces.weights.T, fields[:, 1] @ faces.weights[::-1].T
                stress[number, level] = first + sign * second
        return stress

    def _edges(self, depth: float) -> Array:
        """Return the edges [m] of cells down a face and its mirror image, finest at the surface and at `depth`."""
        finest, farthest = self.grid.cell_size[1] / 4, 4 * self.body.length
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
        """Return the weights (distances, count) of the nodes at some `distance` [m] from the surface."""
        step = CONSTANTS.stride * np.log(CONSTANTS.ratio)
        index = np.log(np.maximum(distance / first_distance(self.body, self.grid), 1)) / step + 1
        return cardinal(np.minimum(index, count - 2), count)

    def _kernel(self, component: CellKernel, depth: float, edges: Array, count: int) -> Array:
        """Return the transform (wave, cell, node) along x of a stress `component` by unit loads on cells of a face.

        The cells lie between the `edges`, the component is that in the half-space of the face, at a `depth` below the
        surface and at `count` nodes, distances from the face. It is real: of a component that is odd along x it is the
        sine transform, and the Fourier transform is -i times that.
        """
        dx, step = self.grid.cell_size[0], CONSTANTS.ratio**CONSTANTS.stride
        nodes = first_distance(self.body, self.grid) * step ** (np.arange(count) - 1.0)
        x = (np.arange(self._across // 2 + 1) - 0.5) * dx
        u, v, y = np.broadcast_arrays(x[:, None, None], (depth - edges)[:, None], nodes)
        point = u, v, y, np.sqrt(u * u + v * v + y * y)  # at many depths y at once
        corners = component.corner(*point, self.body.poisson_ratio)  # type: ignore[arg-type]
        half = -np.diff(np.diff(corners, axis=0), axis=1) / (2 * np.pi)
        if component.parity[0] > 0:
            return np.asarray(fft.dct(np.concatenate([half, 0 * half[:1]]), 1, axis=0))
        return np.pad(fft.dst(half[1:], 1, axis=0), ((1, 1), (0, 0), (0, 0)))
