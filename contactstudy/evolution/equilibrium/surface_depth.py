"""Shape of the depth that wear or plastic strain adds to the gap."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, on_cells
from contactstudy.scene.shapes.shape import LengthScales

# Cells around a grid by which splines continue beyond it.
PADDED = 4


@dataclass(frozen=True, eq=False)
class SurfaceDepth:
    """Shape of a surface that lies `depth` (x, y) [m] deeper in the cells of a grid: worn, or pressed in."""

    depth: Array
    grid: Grid
    curvature: float = 0.0
    length_scales: LengthScales = LengthScales()  # noqa: RUF009 (a frozen value)

    def gap(self, grid: Grid) -> Array:
        """Return the depth on another grid: means over larger cells; on smaller ones, a cubic spline."""
        if all(n <= m for n, m in zip(grid.cells, self.grid.cells, strict=True)):
            return on_cells(self.depth, grid.cells)
        around = np.pad(
            np.pad(self.depth, ((PADDED, PADDED), (0, 0)), "edge"),
            ((0, 0), (PADDED, PADDED)),
            "wrap",
        )
        dx, dy = self.grid.cell_size
        rows, columns = (grid.x - self.grid.x[0]) / dx, (grid.y - self.grid.y[0]) / dy
        places = np.meshgrid(PADDED + rows, PADDED + columns, indexing="ij")
        return np.asarray(ndimage.map_coordinates(around, places, order=3, mode="nearest"))
