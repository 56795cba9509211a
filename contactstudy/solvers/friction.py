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
    """Traction ``coefficient * pressure`` along x on the first body, and its reaction on the second.

    ``coupling`` is the normal displacement under unit shear [m/Pa]; None where both bodies give way
    alike, so that shear does not change the pressure.
    """

    coefficient: float
    coupling: Correlated | None

    def solved(
        self, problem: Problem, options: SolveOptions, start: Array | None, on: Device
    ) -> Solution:
        """The pressure, in one pass or with the shear of the pass before until it no longer changes.

        The coupling is odd, so that it has no place in a symmetric operator: its displacement is added to the
        gap. The pass is the last whose own shear changes the gap by less than the tolerance.
        """
        found = options.solved(problem, start, on)
        if self.coupling is None:
            return replace(found, traction=self._traction(found.pressure, 1))
        moved = np.zeros_like(found.gap)
        iterations, convolutions = found.iterations, found.convolutions
        passes, left = 1, np.inf
        while True:
            now = self.coefficient * self.coupling(found.pressure)
            convolutions += 1
            left = _difference(now - moved, found.pressure) / problem.scales.gap
            if left <= options.tolerance or passes == MOST_PASSES or not np.isfinite(left):
                break
            moved = now
            shifted = replace(problem, undeformed_gap=problem.undeformed_gap + moved)
            found = options.solved(shifted, found.pressure, on)
            iterations, convolutions = (
                iterations + found.iterations,
                convolutions + found.convolutions,
            )
            passes += 1
        status = found.status
        if status is Status.CONVERGED and not left <= options.tolerance:
            status = Status.STALLED
        return replace(
            found,
            problem=problem,
            displacement=found.displacement + moved,
            status=status,
            iterations=iterations,
            convolutions=convolutions,
            residual=max(found.residual, left),
            note=" ".join(filter(None, (found.note, f"{passes} passes over the shear."))),
            traction=self._traction(found.pressure, passes),
        )

    def _traction(self, pressure: Array, passes: int) -> Traction:
        shear = np.stack([self.coefficient * pressure, np.zeros_like(pressure)])
        method = "full sliding" if self.coupling is None else "full sliding, shear lagged"
        return Traction(shear, np.zeros(pressure.shape, dtype=bool), method, passes)


def _difference(change: Array, pressure: Array) -> float:
    """How much a change of the gap is felt: its largest deviation in the contact from its mean there."""
    touching = pressure > 0
    if not touching.any():
        return 0.0
    within = change[touching]
    return float(np.abs(within - within.mean()).max())


# Newton's steps of the projection onto disks with a resultant; each doubles the digits.
NEWTON = 60


@dataclass(frozen=True, eq=False)
class Superposed:
    """Shear from two normal contacts: ``q = mu (p(P) - p(P - Q / mu))``, which sticks where the second presses.

    Exact where the surface gives way along x as it does along z but for a factor: in plane strain, and where
    Poisson's ratio is zero. ``share`` is Q / (mu P), between -1 and 1.
    Source: Ciavarella (1998), Int. J. Solids Struct. 35, 2349; Jaeger (1998).
    """

    coefficient: float
    share: float

    def solved(
        self, problem: Problem, options: SolveOptions, start: Array | None, on: Device
    ) -> Solution:
        """Two normal contacts; the status is that of the worse."""
        found = options.solved(problem, start, on)
        if self.share == 0:
            shear = np.zeros((2, *found.pressure.shape))
            stick = found.pressure > 0
            return replace(found, traction=Traction(shear, stick, "Ciavarella-Jaeger", 1))
        less = replace(problem, resultant=problem.resultant.scaled(1 - abs(self.share)))
        inner = options.solved(less, found.pressure, on)
        across = self.coefficient * np.maximum(found.pressure - inner.pressure, 0)
        across *= np.sign(self.share)
        # what clipping has left of the resultant
        across *= self.coefficient * self.share * found.pressure.sum() / across.sum()
        shear = np.stack([across, np.zeros_like(across)])
        traction = Traction(shear, inner.pressure > 0, "Ciavarella-Jaeger", 2)
        return _with(
            found, inner.status, inner.residual, inner.iterations, inner.convolutions, traction
        )


@dataclass(frozen=True, eq=False)
class CoulombDisks:
    """Shear of least complementary energy among ``|q| <= mu p`` with the resultant along x.

    ``min 1/2 q A q`` over q of two components: A is symmetric and positive, the set convex, so that there is
    one answer. Cells within their disk stick, those on its rim slip against the shear. Loading is monotonic.
    ``share`` is Q / (mu P). Source: Kalker (1990), ch. 4; Beck & Teboulle (2009) with restart
    (O'Donoghue & Candes 2015).
    """

    coefficient: float
    share: float
    response: ShearResponse

    def solved(
        self, problem: Problem, options: SolveOptions, start: Array | None, on: Device
    ) -> Solution:
        """The normal contact, then shear by projected gradients, accelerated, from Ciavarella and Jaeger's."""
        normal = Superposed(self.coefficient, self.share).solved(problem, options, start, on)
        assert normal.traction is not None
        if self.share == 0 or normal.status is Status.NO_ADMISSIBLE_PRESSURE:
            return normal
        radius = self.coefficient * normal.pressure
        total = np.array([self.share * radius.sum(), 0.0])
        scale = self.coefficient * problem.scales.gap
        shear = _nearest(normal.traction.shear, radius, total)
        ahead, inertia, step = shear, 1.0, 1 / self.response.largest
        left, iteration, best = np.inf, 0, np.inf
        last_better = 0
        while True:
            moved = self.response(ahead)
            trial = _nearest(ahead - step * moved, radius, total)
            left = float(np.abs(trial - ahead).sum() / (np.abs(trial).sum() * step * scale))
            left *= float(np.abs(trial).max())
            if left < 0.7 * best:
                best, last_better = left, iteration
            iteration += 1
            stalled = iteration - last_better > 400
            if left <= options.tolerance or iteration >= options.max_iterations or stalled:
                shear = trial
                break
            change = trial - shear
            if np.sum((ahead - trial) * change) > 0:
                inertia = 1.0
            following = (1 + np.sqrt(1 + 4 * inertia**2)) / 2
            ahead = trial + (inertia - 1) / following * change
            shear, inertia = trial, following
        status = Status.CONVERGED
        if left > options.tolerance:
            limited = iteration >= options.max_iterations
            status = Status.ITERATION_LIMIT if limited else Status.STALLED
        size = np.hypot(*shear)
        rounding = 1e-9 * radius.max()
        stick = (radius > 0) & (size < radius - rounding)
        traction = Traction(shear, stick, "Coulomb disks", iteration)
        return _with(normal, status, left, iteration, 2.0 * iteration, traction)


def _with(
    found: Solution,
    status: Status,
    residual: float,
    iterations: int,
    convolutions: float,
    traction: Traction,
) -> Solution:
    """``found`` with a traction whose own solve ended so."""
    return replace(
        found,
        status=status if found.status is Status.CONVERGED else found.status,
        residual=max(found.residual, residual),
        iterations=found.iterations + iterations,
        convolutions=found.convolutions + convolutions,
        traction=traction,
    )


def _nearest(trial: Array, radius: Array, total: Array) -> Array:
    """Return the field nearest to `trial` with ``|q| <= radius`` in each cell and the sum `total`.

    It is `trial` shifted by one vector and cut off at the disks; the vector by Newton's method on two unknowns,
    damped, for its residual is the gradient of a convex function.
    """
    cells = radius > 0
    x, y, r = trial[0][cells], trial[1][cells], radius[cells]
    shift = (total - np.array([x.sum(), y.sum()])) / r.size
    size, ridge = float(r.sum()), 1e-12 * r.size
    reach = 4 * float(max(r.max(), np.abs(x).max(initial=0.0), np.abs(y).max(initial=0.0)))
    u = v = cut = np.zeros(0)
    error = np.inf
    for _ in range(NEWTON):
        u, v = x + shift[0], y + shift[1]
        distance = np.hypot(u, v)
        farther = np.maximum(distance, r)
        cut = r / farther
        missing = total - np.array([(cut * u).sum(), (cut * v).sum()])
        now = float(np.abs(missing).max())
        if now <= 1e-14 * size or (now >= error * (1 - 1e-3) and now <= 1e-10 * size):
            break
        error = now
        # derivative of a cell: the identity within, cut (1 - e e^T) on the rim, e = (u, v) / distance
        rim = (distance > r) * cut / farther**2
        whole, across = float(cut.sum()) + ridge, rim * u
        xx, xy = whole - float((across * u).sum()), -float((across * v).sum())
        yy = whole - float((rim * v * v).sum())
        direction = np.linalg.solve(np.array([[xx, xy], [xy, yy]]), missing)
        longest = float(np.abs(direction).max())
        shift = shift + (min(1.0, reach / longest) if longest else 1.0) * direction
    result = np.zeros_like(trial)
    result[0][cells], result[1][cells] = cut * u, cut * v
    return result
