"""Preparation of measured heights: tiles, missing points, trend, filter, periodic extension and resampling to cells.

Heights (x, y) lie across and along the contact. The trend is the form of the measured body without its roughness, and
is subtracted; the seam is the step where the two ends of a surface meet when it is repeated.
"""

from math import inf, log, pi, sqrt
from typing import Annotated, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain import validation
from contactstudy.domain.grid import Array
from contactstudy.domain.validation import InvalidInput, at_least, readable, validated


@validated
class Tile:
    """Tile of a measured surface that is cut into equal ones.

    If the tiles do not divide the number of points, the remaining points at the far ends belong to none.

    Parameters
    ----------
    tiles
        Numbers of tiles (across, along).
    number
        Index of this tile, at least 0, counted along the length first.

    Raises
    ------
    InvalidInput
        If there is no tile of that index.
    """

    tiles: tuple[Annotated[int, at_least(1)], Annotated[int, at_least(1)]]
    number: Annotated[int, at_least(0)] = 0

    def check_together(self) -> None:
        """Check that there is a tile of that index."""
        last = self.tiles[0] * self.tiles[1] - 1
        if self.number > last:
            raise InvalidInput(f"Tile.number is {self.number}: give a number from 0 to {last}.")

    def of(self, points: Array) -> Array:
        """Return this tile of `points` (x, y)."""
        sides = [count // tiles for count, tiles in zip(points.shape, self.tiles, strict=True)]
        if min(sides) < 2:
            raise InvalidInput(
                f"Tile.tiles is {self.tiles}: give fewer, since the surface has {points.shape} points and a tile "
                "needs 2 x 2."
            )
        first, second = divmod(self.number, self.tiles[1])
        return points[first * sides[0] : (first + 1) * sides[0], second * sides[1] : (second + 1) * sides[1]]


@validated
class RefuseMissing:
    """Rule that refuses a surface with missing points."""

    description: ClassVar[str] = "refused"

    def check(self, missing: int, points: int) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if any of so many `points` is `missing`."""
        if missing:
            raise InvalidInput(
                f"MeasuredSurface.heights has {missing} missing of {points} points: fill them, or give "
                'missing = HarmonicFill(), in a scene file missing = "HarmonicFill".'
            )

    def fill(self, heights: Array) -> Array:
        """Return the heights unchanged."""
        return heights


@validated
class HarmonicFill:
    """Rule that interpolates missing points by Laplace's equation.

    Each is the mean of its neighbours, so that none is higher or lower than the points around the hole.

    Parameters
    ----------
    up_to
        Largest fraction of missing points, above 0 and below 1; a surface with more is refused. The fill is smooth: with
        5, 10 and 20 % of a self-affine surface in holes of 17 points, its rms slope was 2, 4 and 8 % too low.
    """

    description: ClassVar[str] = "filled by Laplace's equation from the edges of their holes"

    up_to: Annotated[validation.Number, validation.BELOW_ONE] = 0.1

    def check(self, missing: int, points: int) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if more of so many `points` are `missing` than `up_to` allows."""
        if missing > self.up_to * points:
            raise InvalidInput(
                f"MeasuredSurface.heights has {missing} missing of {points} points, a fraction of "
                f"{missing / points:.2g}: give another surface, or fill them from their edges nevertheless with "
                f'missing = {{ kind = "HarmonicFill", up_to = {min(missing / points + 0.01, 0.999):.2g} }}.'
            )

    def fill(self, heights: Array) -> Array:
        """Return heights with the solution of Laplace's five-point equation where one is missing."""
        holes = np.isnan(heights)
        if not holes.any():
            return heights
        filled = heights.copy()
        filled[holes] = _harmonic_heights(heights, holes)
        return filled


# Rule for missing points, the non-measured points of ISO 25178.
Missing = RefuseMissing | HarmonicFill


def _harmonic_heights(heights: Array, holes: NDArray[np.bool_]) -> Array:
    """Return the heights at the `holes`, in the order of that mask, each the mean of its neighbours."""
    from scipy import sparse  # imported only where it is needed
    from scipy.sparse.linalg import spsolve

    def laplacian(count: int) -> sparse.csr_array:
        """Return the Laplacian of a row of points: for each, the sum of its differences from its neighbours."""
        step = sparse.eye_array(count - 1, count, k=1) - sparse.eye_array(count - 1, count)
        return step.T @ step

    is_hole = holes.ravel()
    of_holes = sparse.kronsum(laplacian(heights.shape[1]), laplacian(heights.shape[0]), format="csr")[is_hole]
    border_sums = -of_holes[:, ~is_hole] @ heights[~holes]
    return np.asarray(spsolve(of_holes[:, is_hole].tocsc(), border_sums))


# Least-squares form that is subtracted from a measured surface, and the total degrees of the polynomials among them.
Trend = Literal["none", "mean", "plane", "quadratic", "cubic", "quartic", "cylinder"]
DEGREES = {"mean": 0, "plane": 1, "quadratic": 2, "cubic": 3, "quartic": 4}


def without_trend(trend: Trend, heights: Array, extent: tuple[float, float] | None) -> Array:
    """Return `heights` (x, y) over `extent` [m] less the form, fitted to all points alike."""
    if trend == "none":
        return heights
    if trend == "cylinder":
        return heights - _cylinder(heights, extent)[0]
    return heights - polynomial(heights, DEGREES[trend])[0]


def trend_text(trend: Trend, heights: Array, extent: tuple[float, float] | None) -> str:
    """Return words on the tilt of `heights` (x, y) over `extent` [m], and on the form that is subtracted."""
    plane = polynomial(heights, 1)[0]
    rises = plane[-1, 0] - plane[0, 0], plane[0, -1] - plane[0, 0]
    across, along = (f"{1e6 * rise:.3g} um" for rise in rises)
    rest = {"none": "is left", "mean": "is left, and the mean was subtracted", "plane": "was subtracted"}.get(trend)
    if trend == "cylinder":
        curvature, axis = _cylinder(heights, extent)[1:]
        radius = readable(1 / curvature) if curvature else "infinite"
        rest = f"and a cylinder of radius {radius}, its axis at {axis:.1f} degrees to the length, were subtracted"
    tilt = f"a plane that rises {across} across and {along} along"
    return f"{tilt} {rest or f'was subtracted with a {trend} polynomial'}"


def polynomial(heights: Array, degree: int) -> tuple[Array, dict[tuple[int, int], float]]:
    """Return the least-squares polynomial of a total `degree` at the points of `heights` (x, y), and its coefficients.

    The coefficients are those of u^i v^j by (i, j), where u across and v along run from -1 to 1 over the points. The
    polynomial is fitted to the points that are not missing.
    """
    measured = np.isfinite(heights).ravel()
    x, y = (_from_middle(count) for count in heights.shape)
    rows, columns = heights.shape
    powers = [(i, j) for i in range(min(degree + 1, rows)) for j in range(min(degree + 1 - i, columns))]
    basis = np.stack([(x[:, None] ** i * y**j).ravel() for i, j in powers], axis=1)
    coefficients = np.linalg.lstsq(basis[measured], heights.ravel()[measured], rcond=None)[0]
    form = np.asarray((basis @ coefficients).reshape(heights.shape))
    return form, dict(zip(powers, map(float, coefficients), strict=True))


def _cylinder(heights: Array, extent: tuple[float, float] | None) -> tuple[Array, float, float]:
    """Return the least-squares cylinder at the points, its curvature [1/m], and its axis [degrees from the length].

    The curvature is above 0 of a convex cylinder. A profile shows no axis, which is then along the length.
    """
    from scipy.optimize import least_squares  # imported only where it is needed

    if extent is None:
        raise InvalidInput("MeasuredSurface.trend is a cylinder, which has no size: give extent.")
    sides = zip(extent, heights.shape, strict=True)
    # from the middle to the outermost points; a single point has no such distance, and half the size serves
    half = np.array([size / 2 * (1 - 1 / count) or size / 2 for size, count in sides])
    largest = half.max()
    x, y = (_from_middle(count) * side / largest for count, side in zip(heights.shape, half, strict=True))
    # curvatures of the quadratic give the start: the axis lies along the smaller
    form = polynomial(heights, 2)[1]
    xx, xy, yy = 2 * form.get((2, 0), 0.0), form.get((1, 1), 0.0), 2 * form.get((0, 2), 0.0)
    curvatures, axes = np.linalg.eigh(np.array([[xx, xy], [xy, yy]]) / np.outer(half, half))
    across = axes[:, np.argmax(np.abs(curvatures))]
    tilt = np.array([form.get((1, 0), 0.0), form.get((0, 1), 0.0)]) / half
    start = [-curvatures[np.argmax(np.abs(curvatures))] * largest, np.arctan2(across[1], across[0])]
    start += [across @ tilt, across[0] * tilt[1] - across[1] * tilt[0], heights.mean() / largest]

    def cylinder(values: Array, x: Array, y: Array) -> Array:
        """Return heights at the points of x and y, all in units of half the largest side.

        The `values` are the curvature c, the angle from x of the direction u across the axis, the sine s of the slope
        along u at the origin, the slope along the axis v, and the height of the origin. Along u the circle is
        ``(sqrt(1 - (c u - s)^2) - sqrt(1 - s^2)) / c``, here in a form that holds for c = 0 too.
        """
        curvature, angle, slope, rise, level = values
        angle = start[1] if 1 in heights.shape else angle  # a profile does not show its axis
        u = x[:, None] * np.cos(angle) + y * np.sin(angle)
        v = y * np.cos(angle) - x[:, None] * np.sin(angle)
        root = np.sqrt(np.maximum(1 - (curvature * u - slope) ** 2, 0))
        roots = np.maximum(root + sqrt(max(1 - slope**2, 0)), 1e-9)
        return np.asarray(level + rise * v + u * (2 * slope - curvature * u) / roots)

    # some 200 points a side are fitted, which find the five numbers of a cylinder to far less than the roughness
    some = tuple(slice(None, None, max(1, count // 200)) for count in heights.shape)
    scaled = heights[some] / largest

    def misfit(values: Array) -> Array:
        """Return how far the cylinder lies above the points that are fitted."""
        return np.asarray(cylinder(values, x[some[0]], y[some[1]]) - scaled).ravel()

    fit = least_squares(misfit, start, xtol=1e-14, ftol=1e-14, gtol=1e-14)
    angle = (np.degrees(start[1] if 1 in heights.shape else fit.x[1]) + 90) % 180 - 90
    return largest * cylinder(fit.x, x, y), float(fit.x[0] / largest), float(angle)


def _from_middle(count: int) -> Array:
    """Return positions of points from -1 to 1, which keeps the fit of their powers well conditioned."""
    return np.asarray((2 * np.arange(count) - (count - 1)) / max(count - 1, 1), dtype=np.float64)


@validated
class GaussianFilter:
    """Gaussian filter of zero phase of a profile (ISO 16610-21) or a surface (ISO 16610-61).

    A wave of the wavelength of a cut-off is passed with half its amplitude. Near the ends the weights of the points
    within the surface are scaled to the sum 1 (ISO 16610-28).

    Parameters
    ----------
    lambda_s
        Cut-off [m] below which waves are removed (noise); 0 for none.
    lambda_c
        Cut-off [m] above which waves are removed (waviness); infinite for none.

    Raises
    ------
    InvalidInput
        If a cut-off is no length, or lambda_c is not above lambda_s.
    """

    lambda_s: Annotated[validation.Metres, validation.AT_LEAST_ZERO] = 0.0
    lambda_c: Annotated[validation.Metres, validation.OR_INFINITE] = inf

    def check_together(self) -> None:
        """Check that waves pass the filter."""
        if self.lambda_c <= self.lambda_s:
            raise InvalidInput(f"GaussianFilter.lambda_c is {self.lambda_c!r}: give a cut-off above lambda_s.")

    @property
    def description(self) -> str:
        """Sentence on what the filter removes."""
        below = f"below lambda_s = {readable(self.lambda_s)}" if self.lambda_s > 0 else ""
        above = f"above lambda_c = {readable(self.lambda_c)}" if self.lambda_c < inf else ""
        removed = filter(None, (below, above))
        return f"waves {' and '.join(removed) or 'of no length'} were removed by Gaussian filters"

    def filtered(self, heights: Array, extent: tuple[float, float] | None) -> Array:
        """Return the heights (x, y) over `extent` [m] between the two cut-offs."""
        if extent is None:
            raise InvalidInput("MeasuredSurface.filter has cut-offs in metres: give extent.")
        steps = [size / count for size, count in zip(extent, heights.shape, strict=True)]
        smooth = _smoothed(heights, self.lambda_s, steps)
        return smooth if self.lambda_c == inf else smooth - _smoothed(smooth, self.lambda_c, steps)


def _smoothed(heights: Array, cutoff: float, steps: list[float]) -> Array:
    """Return the means of heights with the weights of ISO 16610-21, along x and then y, whose points are `steps` apart.

    At the distance x the weight is exp(-pi (x / (alpha cutoff))^2), with alpha = sqrt(ln 2 / pi) and the cut-off [m]: a
    Gaussian of the standard deviation sqrt(ln 2 / 2) cutoff / pi.
    """
    from scipy.ndimage import gaussian_filter1d  # imported only where it is needed

    for axis, step in enumerate(steps):
        deviation = cutoff * sqrt(log(2) / 2) / pi / step
        if heights.shape[axis] > 1 and deviation > 0:
            weights = gaussian_filter1d(np.ones(heights.shape[axis]), deviation, mode="constant")
            means = gaussian_filter1d(heights, deviation, axis, mode="constant")
            heights = means / np.expand_dims(weights, 1 - axis)
    return heights


@validated
class AsMeasured:
    """Unchanged surface: the step between its end and its beginning stays."""

    #: Period, in lengths of the surface.
    lengths: ClassVar[int] = 1
    description: ClassVar[str] = "as measured"

    def periodic(self, heights: Array) -> Array:
        """Return the heights unchanged."""
        return heights


@validated
class Mirrored:
    """Surface followed by its mirror image: no step, twice the period, all heights unchanged."""

    #: Period, in lengths of the surface.
    lengths: ClassVar[int] = 2
    description: ClassVar[str] = "mirrored"

    def periodic(self, heights: Array) -> Array:
        """Return heights (x, y), followed along y by their mirror image."""
        return np.concatenate([heights, heights[:, ::-1]], axis=1)


@validated
class Tapered:
    """Surface tapered to its mean height at both ends by a cosine (Tukey's window; Harris 1978, Proc. IEEE 66, eq. 38).

    In the tapered part the surface is smoother than measured: its rms height is less by 5/16 of the fraction.

    Parameters
    ----------
    fraction
        Tapered fraction of the length, half of it at each end, above 0 and up to 1.
    """

    #: Period, in lengths of the surface.
    lengths: ClassVar[int] = 1

    fraction: Annotated[validation.Number, validation.UP_TO_ONE] = 0.1

    @property
    def description(self) -> str:
        """Words for a sentence on the ends."""
        return f"tapered over {self.fraction / 2:.3g} of the size at each end"

    def periodic(self, heights: Array) -> Array:
        """Return heights (x, y), tapered along y."""
        count = heights.shape[1]
        from_end = np.minimum(np.arange(count) + 0.5, count - np.arange(count) - 0.5) / count
        taper = (1 - np.cos(np.pi * np.minimum(from_end / (self.fraction / 2), 1))) / 2
        mean = heights.mean()
        return np.asarray(mean + (heights - mean) * taper)


# Rule of the periodic extension of a measured surface: its `periodic` gives one period of heights (x, y) along y.
PeriodicExtension = AsMeasured | Mirrored | Tapered
# The boundary condition of scipy.interpolate.CubicSpline.
Ends = Literal["periodic", "not-a-knot"]


def cell_means(heights: Array, axis: int, *, extent: float, cells: int, width: float, ends: Ends) -> Array:
    """Return means over equal cells of a smooth surface that has the means `heights`.

    This is conservative resampling: a cubic spline interpolates the cumulative integral, and its differences between
    the edges of a cell give the mean. A cell made of whole pieces has their mean.

    Parameters
    ----------
    heights
        Means of equal pieces of `extent` along `axis`.
    axis
        Axis that is resampled.
    extent
        Length of all pieces [m], centred on the same origin as `width`.
    cells
        Number of cells.
    width
        Length of all cells [m], within the extent unless the ends are periodic.
    ends
        Boundary condition of the spline.
    """
    count = heights.shape[axis]
    if (cells, width) == (count, extent):
        return heights
    from scipy.interpolate import CubicSpline  # imported only where it is needed

    mean = heights.mean(axis=axis, keepdims=True)
    integral = np.cumsum(heights - mean, axis=axis)
    start = np.zeros_like(mean)
    # the integral of the deviation from the mean is zero at both ends, except for rounding
    inner = np.take(integral, range(count - 1), axis=axis)
    integral = np.concatenate([start, inner, start], axis=axis) * (extent / count)
    piece_edges = (np.arange(count + 1) / count - 0.5) * extent
    spline = CubicSpline(piece_edges, integral, axis=axis, bc_type=ends)
    cell_edges = (np.arange(cells + 1) / cells - 0.5) * width
    if ends != "periodic":
        cell_edges = np.clip(cell_edges, piece_edges[0], piece_edges[-1])
    return np.asarray(mean + np.diff(spline(cell_edges), axis=axis) * (cells / width))
