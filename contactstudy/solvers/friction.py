"""Shear on the surface: full sliding, and partial slip under less shear than would make all slide."""

from dataclasses import dataclass, replace

import numpy as np

from contactstudy.domain.device import Device
from contactstudy.domain.fields import Array
from contactstudy.elasticity.tangential import Correlated, ShearResponse
from contactstudy.problem.problem import Problem
from contactstudy.solvers.solution import Solution, Status, Traction
from contactstudy.solvers.solve import SolveOptions

# Errors fall by at least 1.7 from one pass to the next where both bodies are elastic and friction is below 1.
MOST_PASSES = 200


@dataclass(frozen=True, eq=False)
class FullSliding:
    """Full sliding along x: the traction ``coefficient * pressure`` on the first body, and its reaction on the second.

    `coupling` maps shear [Pa] to normal displacement [m]; None where both bodies give way alike, so that shear does not
    change the pressure.
    """

    coefficient: float
    coupling: Correlated | None

    def solved(
        self, problem: Problem, options: SolveOptions, start: Array | None, on: Device
    ) -> Solution:
        """Return the solution under shear, in one pass or with the shear of the pass before until it no longer changes.

        The coupling is odd, so that it has no place in a symmetric operator: its displacement is added to the gap. The
        pass is the last whose own shear changes the gap by less than the tolerance.
        """
        solution = options.solved(problem, start, on)
        if self.coupling is None:
            return replace(solution, traction=self._traction(solution.pressure, 1))
        lagged = np.zeros_like(solution.gap)
        iterations, convolutions = solution.iterations, solution.convolutions
        passes, change = 1, np.inf
        while True:
            displacement = self.coefficient * self.coupling(solution.pressure)
            convolutions += 1
            change = uneven_change(displacement - lagged, solution.pressure) / problem.scales.gap
            if change <= options.tolerance or passes == MOST_PASSES or not np.isfinite(change):
                break
            lagged = displacement
            shifted = replace(problem, undeformed_gap=problem.undeformed_gap + lagged)
            solution = options.solved(shifted, solution.pressure, on)
            iterations += solution.iterations
            convolutions += solution.convolutions
            passes += 1
        status = solution.status
        if status is Status.CONVERGED and not change <= options.tolerance:
            status = Status.STALLED
        return replace(
            solution,
            problem=problem,
            displacement=solution.displacement + lagged,
            status=status,
            iterations=iterations,
            convolutions=convolutions,
            residual=max(solution.residual, change),
            note=" ".join(filter(None, (solution.note, f"{passes} passes over the shear."))),
            traction=self._traction(solution.pressure, passes),
        )

    def _traction(self, pressure: Array, passes: int) -> Traction:
        """Return the traction of full sliding under `pressure` (x, y) [Pa]."""
        shear = np.stack([self.coefficient * pressure, np.zeros_like(pressure)])
        method = "full sliding" if self.coupling is None else "full sliding, shear lagged"
        return Traction(shear, np.zeros(pressure.shape, dtype=bool), method, passes)


def uneven_change(change: Array, pressure: Array) -> float:
    """Return the effect of a `change` of the gap: its largest deviation in the contact from its mean there."""
    touching = pressure > 0
    if not touching.any():
        return 0.0
    within = change[touching]
    return float(np.abs(within - within.mean()).max())


# Newton's steps of the projection onto disks with a resultant; each doubles the digits.
NEWTON = 200


@dataclass(frozen=True, eq=False)
class Superposed:
    """Shear as a difference of two normal contacts: ``q = mu (p(P) - p(P - Q / mu))``.

    Cells stick where the second contact presses. It is exact where the surface gives way along x as it does along z up
    to a factor: in plane strain, and where Poisson's ratio is zero. `coefficient` is mu; `share` is Q / (mu P), between
    -1 and 1. Source: Ciavarella (1998), Int. J. Solids Struct. 35, 2349; Jaeger (1998).
    """

    coefficient: float
    share: float

    def solved(
        self, problem: Problem, options: SolveOptions, start: Array | None, on: Device
    ) -> Solution:
        """Return the solution with its shear from two normal contacts; its status is that of the worse."""
        outer = options.solved(problem, start, on)
        if self.share == 0:
            shear = np.zeros((2, *outer.pressure.shape))
            stick = outer.pressure > 0
            return replace(outer, traction=Traction(shear, stick, "Ciavarella-Jaeger", 1))
        reduced = replace(problem, resultant=problem.resultant.scaled(1 - abs(self.share)))
        inner = options.solved(reduced, outer.pressure, on)
        across = self.coefficient * np.maximum(outer.pressure - inner.pressure, 0)
        across *= np.sign(self.share)
        # to the exact resultant after clipping
        across *= self.coefficient * self.share * outer.pressure.sum() / across.sum()
        shear = np.stack([across, np.zeros_like(across)])
        traction = Traction(shear, inner.pressure > 0, "Ciavarella-Jaeger", 2)
        return _with_traction(
            outer, inner.status, inner.residual, inner.iterations, inner.convolutions, traction
        )


@dataclass(frozen=True, eq=False)
class CoulombDisks:
    """Shear of least complementary energy among ``|q| <= mu p`` with a given resultant along x.

    It minimises ``1/2 q A q`` over q of two components: A is symmetric and positive and the set convex, so that there is
    one answer. Cells within their disk stick, those on its rim slip against the shear. Loading is monotonic.
    `coefficient` is mu, `share` is Q / (mu P), and `response` is A. Source: Kalker (1990), ch. 4; Beck & Teboulle (2009)
    with restart (O'Donoghue & Candes 2015).
    """

    coefficient: float
    share: float
    response: ShearResponse

    def solved(
        self, problem: Problem, options: SolveOptions, start: Array | None, on: Device
    ) -> Solution:
        """Return the normal contact with its shear, by accelerated projected gradients from :class:`Superposed`."""
        normal = Superposed(self.coefficient, self.share).solved(problem, options, start, on)
        assert normal.traction is not None
        if self.share == 0 or normal.status is Status.NO_ADMISSIBLE_PRESSURE:
            return normal
        radius = self.coefficient * normal.pressure
        total = np.array([self.share * radius.sum(), 0.0])
        scale = self.coefficient * problem.scales.gap
        disks = Disks(radius, total)
        shear = disks.nearest(normal.traction.shear)
        extrapolated, inertia, step = shear, 1.0, 1 / self.response.largest
        residual, iteration, best = np.inf, 0, np.inf
        last_improvement = 0
        while True:
            displacement = self.response(extrapolated)
            trial = disks.nearest(extrapolated - step * displacement)
            size = np.abs(trial)
            residual = float(np.abs(trial - extrapolated).sum() / (size.sum() * step * scale))
            residual *= float(size.max())
            if residual < 0.7 * best:
                best, last_improvement = residual, iteration
            iteration += 1
            stalled = iteration - last_improvement > 400
            if residual <= options.tolerance or iteration >= options.max_iterations or stalled:
                shear = trial
                break
            change = trial - shear
            if np.einsum("cxy,cxy->", extrapolated - trial, change) > 0:
                inertia = 1.0
            following = (1 + np.sqrt(1 + 4 * inertia**2)) / 2
            extrapolated = trial + (inertia - 1) / following * change
            shear, inertia = trial, following
        status = Status.CONVERGED
        if residual > options.tolerance:
            limited = iteration >= options.max_iterations
            status = Status.ITERATION_LIMIT if limited else Status.STALLED
        size = np.hypot(*shear)
        rounding = 1e-9 * radius.max()
        stick = (radius > 0) & (size < radius - rounding)
        traction = Traction(shear, stick, "Coulomb disks", iteration)
        return _with_traction(normal, status, residual, iteration, 2.0 * iteration, traction)


def _with_traction(
    solution: Solution,
    status: Status,
    residual: float,
    iterations: int,
    convolutions: float,
    traction: Traction,
) -> Solution:
    """Return a `solution` with a `traction`, whose own solve ended with this status and residual after this work."""
    return replace(
        solution,
        status=status if solution.status is Status.CONVERGED else solution.status,
        residual=max(solution.residual, residual),
        iterations=solution.iterations + iterations,
        convolutions=solution.convolutions + convolutions,
        traction=traction,
    )


class Disks:
    """Convex set of tractions (2, x, y) with ``|q| <= radius`` (x, y) in each cell and the sum `total` (2,)."""

    def __init__(self, radius: Array, total: Array) -> None:
        self._cells, self._total = np.flatnonzero(radius), total
        self._radius = radius.ravel()[self._cells]
        self._shift: Array | None = None

    @property
    def shift(self) -> Array:
        """Vector (2,) by which the last trial was shifted."""
        assert self._shift is not None
        return self._shift

    def nearest(self, trial: Array) -> Array:
        """Return the traction of this set that is nearest to a `trial` one.

        The trial is shifted by one vector and cut off at the disks. The vector is found by Newton's method on two
        unknowns, damped, whose residual is the gradient of a convex function. It begins with the vector found before.
        """
        total, r = self._total, self._radius
        x, y = trial.reshape(2, -1)[:, self._cells]
        shift, guessed = self._shift, self._shift is not None
        if shift is None:
            shift = (total - np.array([x.sum(), y.sum()])) / r.size
        size, ridge = float(r.sum()), 1e-12 * r.size
        reach = 4 * float(max(r.max(), np.abs(x).max(initial=0.0), np.abs(y).max(initial=0.0)))
        u = v = cut = np.zeros(0)
        origin, step, slope = shift, np.zeros(2), 0.0
        error = worst = np.inf
        for _ in range(NEWTON):
            u, v = x + shift[0], y + shift[1]
            distance = np.sqrt(u * u + v * v)
            farther = np.maximum(distance, r)
            cut = r / farther
            missing = total - np.array([np.einsum("i,i->", cut, u), np.einsum("i,i->", cut, v)])
            worst = float(np.abs(missing).max())
            if float(missing @ step) < -0.5 * slope:
                # past the lowest point of the convex function: where all cells are on their rims it has no curvature
                step, slope = step / 2, slope / 2
                reach = float(np.abs(step).max())
                shift = origin + step
                continue
            if worst <= 1e-14 * size or (worst >= error * (1 - 1e-3) and worst <= 1e-10 * size):
                break
            error = worst
            # derivative of a cell: the identity within, cut (1 - e e^T) on the rim, e = (u, v) / distance
            rim = (distance > r) * cut / farther**2
            diagonal, across = float(cut.sum()) + ridge, rim * u
            xx, xy = (
                diagonal - float(np.einsum("i,i->", across, u)),
                -float(np.einsum("i,i->", across, v)),
            )
            yy = diagonal - float(np.einsum("i,i->", rim * v, v))
            direction = np.linalg.solve(np.array([[xx, xy], [xy, yy]]), missing)
            longest = float(np.abs(direction).max())
            step = (min(1.0, reach / longest) if longest else 1.0) * direction
            origin, slope = shift, float(missing @ step)
            shift = origin + step
            reach *= 2
        if guessed and not worst <= 1e-9 * size:
            # a shift that brought all cells to their rims leaves Newton's method without a slope
            self._shift = None
            return self.nearest(trial)
        self._shift = shift
        result = np.zeros_like(trial)
        result.reshape(2, -1)[:, self._cells] = cut * u, cut * v
        return result
