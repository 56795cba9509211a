"""Preconditioned conjugate gradients with a trial step and a start from coarser grids."""

from dataclasses import dataclass
from math import prod

from contactstudy.domain.device import arrays
from contactstudy.domain.fields import Array, equal, inner, total
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.problem.constraint import Gap
from contactstudy.problem.operator import ApproximateInverse, Extension
from contactstudy.problem.passes import Direction, Passes, TrialSums
from contactstudy.solvers.iterate import Iterate, Stall
from contactstudy.solvers.polonsky_keer import PolonskyKeer


@dataclass(frozen=True)
class PressureStep:
    """Pressure and displacement before and after a step, and the inner product `curvature` of their changes."""

    before: Array
    after: Array
    displacement_before: Array
    displacement_after: Array
    curvature: float


@dataclass
class ContactPreconditioner:
    """Preconditioner of a contact that changes: it keeps its `extension` as long as the same cells bear."""

    problem: BareProblem
    inverse: ApproximateInverse
    extension: Extension | None = None
    punch: tuple[float, float] = 0.0, 0.0
    convolutions: float = 0.0

    def rigid(self, cells: Array, height: Array) -> float:
        """Return the uniform pressure on `cells` that moves the mean of their `height` to zero, as a flat punch would.

        The compliance of the punch is found again where the number of cells has changed by a tenth.
        """
        count, compliance = self.punch
        bearing = total(cells)
        if abs(bearing - count) > count / 10:
            compliance = inner(cells, self.problem.operator(cells.astype(height.dtype))) / bearing
            self.punch, self.convolutions = (bearing, compliance), self.convolutions + 1
        return inner(cells, height) / bearing / compliance

    def closing(self, pressure: Array, gap: Gap, step_length: float) -> tuple[Array, Array, bool]:
        """Return the pressure that would close the gap of the cells that will bear.

        These cells are those that bear pressure, and those that would penetrate after a step that closes their gap and
        takes the surroundings along. Judged by its gap before the step, a contact that is slightly too high over a wide
        region would gather every cell there whose gap is small.

        Returns
        -------
        closing
            The pressure (x, y).
        cells
            The cells that will bear (x, y): 1, others 0.
        joined
            Whether any cell joined those that bear.
        """
        passes = self.problem.passes
        contact, unlevel = passes.contact(pressure, gap.height, self.inverse.real)
        extension = self._extension(contact)
        cells = extension.contact
        del contact
        extended = extension(unlevel)
        joined = passes.joined(pressure, gap.height, extended, step_length, cells, unlevel)
        if joined:
            self.extension = None  # it was that of fewer cells,
            del extension, extended  # and would stand beside that of more
            extension = self._extension(cells)
            extended = extension(unlevel)
        del unlevel
        return extension.closing(extended), cells, joined

    def _extension(self, contact: Array) -> Extension:
        """Return the extension of a `contact` (x, y): the last one where it is that of the same cells."""
        if self.extension is None or not equal(self.extension.contact, contact):
            self.extension = None  # or it would stand beside the next one
            self.extension = self.inverse.extension(contact)
        return self.extension


def trial_along(
    problem: BareProblem,
    pressure: Array,
    gap: Gap,
    closing: Array,
    cells: Array,
    last: PressureStep | None,
    conjugate_to: PressureStep | None,
    step_length: float,
    rigid: float | None = None,
) -> tuple[Array, TrialSums]:
    """Return the pressure (x, y) one step ahead, and sums over it.

    The direction is against `closing` and conjugate to a step of the same cells, if there is one, where that is
    downhill. It is zero outside `cells`, and such that the load stays as it is; under a given approach it is also
    against the uniform pressure `rigid`, and the load follows. The pressure before the `last` step is overwritten.
    """
    passes, height = problem.passes, gap.height
    terms = _direction(passes, height, closing, cells, conjugate_to, rigid)
    direction = Direction(closing, cells, *terms)
    trial = arrays().empty_like(pressure) if last is None else last.before
    return trial, passes.trial(pressure, height, direction, step_length, trial)


def _direction(
    passes: Passes,
    height: Array,
    closing: Array,
    cells: Array,
    last: PressureStep | None,
    rigid: float | None = None,
) -> tuple[float, float]:
    """Return what to add to the direction against `closing`: a constant, and a multiple of the last step."""
    if last is None or last.curvature <= 0:
        if rigid is not None:
            return -rigid, 0.0
        count, closed = passes.totals(cells, closing)
        return closed / count, 0.0
    steps = last.before, last.after, last.displacement_before, last.displacement_after
    sums = passes.products(height, closing, cells, *steps)
    count, closed, downhill, along, across, uphill, shifted = sums
    if rigid is not None:
        conjugate = (along + rigid * across) / last.curvature
        downhill += rigid * inner(cells, height)
        return -rigid, conjugate if conjugate * uphill < downhill else 0.0
    level = closed / count
    conjugate = (along - level * across) / last.curvature
    if conjugate * uphill < downhill:
        return level - conjugate * shifted / count, conjugate
    return level, 0.0


def step_to_nearest(problem: BareProblem, trial: Array, pressure: Array, gap: Gap) -> float:
    """Write over `trial` the nearest pressure to a step against the `gap`, and return the energy's slope along it."""
    trial[...] = pressure - gap.height / problem.operator.self_compliance
    problem.nearest(trial)
    return problem.passes.slope(trial, pressure, gap.height)


def share_to_take(
    passes: Passes, trial: Array, pressure: Array, best: float, *, cut: bool
) -> float:
    """Return the share to take of a step to `trial`: `best`, that of least energy, unless limits are in the way."""
    if cut:
        # zeros are left where tension was; beyond the whole they would turn to tension
        return 1.0 if best > WHOLE else best
    # nor beyond it to just where a cell meets a limit: rounding would say which of many did
    meets = best > 1 and passes.meets_a_limit(trial, pressure, best)
    return 1.0 if meets else best


# A trial step that meets a limit is taken whole where that lowers the energy: half the best step is less.
WHOLE = 0.5
# The preconditioner takes a contact to be stiffer than it is, not softer: a step is at most this many
# times as long as it says. Nor shorter than this, or rounding could make it shorter and shorter.
LONGEST, SHORTEST = 1.0, 0.1
# On grids of more cells along an axis a start is the closer, the smaller the cells are: smooth contacts of 1024 x 1024
# cells then take 3 iterations for 6.
LOOSE = 128
# A start has the error of its interpolation, however far the coarser grid was solved: on rough surfaces it has about a
# third of the residual that the coarser grid began with. On smooth ones it has far less, and a 20th costs iterations.
REDUCTION = 0.02
# Grids of so few cells begin on springs: an iteration costs nearly as much on coarser ones.
SMALL = 4096


@dataclass(frozen=True)
class PreconditionedCG:
    """Preconditioned conjugate gradients with a trial step and a start from coarser grids.

    An iteration takes one convolution and one preconditioning. The direction is the preconditioned gap of the cells that
    bear pressure or will: those expected to penetrate once the contact's own gap is closed. Where the same cells bear as
    before, it is made conjugate to the last step. A trial pressure one step ahead is made admissible first: tension is
    cut off, and these cells are shifted to carry the load. Its convolution gives the energy along the whole step, on
    which the best point is known exactly; so every step lowers the energy.

    Source: active sets Hintermueller, Ito & Kunisch (2002), here with one step of the inner iteration to each set;
    preconditioner Vollebregt (2014); conjugacy Hestenes & Stiefel (1952), eq. 3:1.

    Parameters
    ----------
    coarse_tolerance
        Residual at which coarser grids, which give the start, end; on grids of more than 128 cells along an axis it is
        smaller by the square of their number. They also end at a 50th of the residual that they began with.
    patience
        Iterations without a halving of the residual after which Polonsky & Keer's scheme goes on from there, and the
        solution's note says so.
    """

    coarse_tolerance: float = 1e-3
    patience: int = 40

    def iterate(
        self,
        problem: BareProblem,
        *,
        tolerance: float,
        max_iterations: int,
        start: Array | None = None,
    ) -> Iterate:
        """Iterate until ``problem.residual(pressure, gap) <= tolerance``, the limit, or a stall."""
        last = self._descend(problem, start, tolerance, max_iterations)
        ended = problem.ends(last.residual, last.displacement, tolerance)
        if ended or last.iterations == max_iterations:
            return last
        following = PolonskyKeer().iterate(
            problem,
            tolerance=tolerance,
            max_iterations=max_iterations - last.iterations,
            start=last.pressure,
        )
        better = min(last, following, key=lambda iterate: iterate.residual)
        return Iterate(
            better.pressure,
            better.displacement,
            better.approach,
            better.residual,
            last.iterations + following.iterations,
            last.convolutions + following.convolutions,
            f"Preconditioned conjugate gradients stalled at a residual of {last.residual:.1e} after "
            f"{last.iterations} iterations; Polonsky & Keer's scheme went on from there.",
        )

    def _begin(
        self, problem: BareProblem, start: Array | None, tolerance: float
    ) -> tuple[Array, float]:
        """Return a new array with the admissible pressure to begin with, and the convolutions it took."""
        if start is not None:
            admitted = problem.admit(arrays().asarray(start, copy=True))
            if problem.resultant.approach is None or arrays().any(admitted > 0):
                return admitted, 0.0
            return problem.on_springs(), 1.0
        shape = problem.undeformed_gap.shape
        coarse = problem.coarsened() if prod(shape) > SMALL else None
        if coarse is None:
            return problem.on_springs(), 1.0
        share = min(1.0, (LOOSE / max(shape)) ** 2)
        enough = max(tolerance, share * self.coarse_tolerance)
        last = self._descend(coarse, None, enough, self.patience, REDUCTION)
        blocks = [n // m for n, m in zip(shape, last.pressure.shape, strict=True)]
        xp = arrays()
        fine = xp.repeat(xp.repeat(last.pressure, blocks[1], axis=1), blocks[0], axis=0)
        return fine, last.convolutions * coarse.operator.work / problem.operator.work

    def _descend(
        self,
        problem: BareProblem,
        start: Array | None,
        tolerance: float,
        max_iterations: int,
        reduction: float = 0.0,
    ) -> Iterate:
        """Return the state in which the iteration from `start`, or from coarser grids, ends or stalls.

        It also ends at a residual of this `reduction` times the first one.
        """
        operator, passes = problem.operator, problem.passes
        inverse = operator.approximate_inverse(passes.preconditioner(problem.undeformed_gap))
        preconditioner = ContactPreconditioner(problem, inverse)
        pressure, work = self._begin(problem, start, tolerance)
        displacement = operator(pressure)
        work += 1
        gap: Gap | None = None
        last: PressureStep | None = None
        step_length, cut, iteration = 1.0, False, 0
        rounding = 16 * float(arrays().finfo(pressure.dtype).eps)
        stall = Stall(self.patience)
        follows = problem.resultant.approach is not None  # the load from the approach
        while True:
            gap = problem.gap(pressure, displacement, gap)
            residual = problem.residual(pressure, gap)
            if not iteration:
                tolerance = max(tolerance, reduction * residual)
            ended = problem.ends(residual, displacement, tolerance, gap.farthest)
            if ended or iteration == max_iterations or stall.sees(residual):
                work += inverse.work / operator.work + preconditioner.convolutions
                return Iterate(pressure, displacement, gap.approach, residual, iteration, work)
            iteration += 1
            work += 1
            if follows and not arrays().any(pressure > 0):
                # no contact to precondition: the cells that penetrate begin it
                trial, slope = arrays().empty_like(pressure), 0.0
            else:
                closing, cells, joined = preconditioner.closing(pressure, gap, step_length)
                conjugate_to = last if not (cut or joined) else None
                rigid = preconditioner.rigid(cells, gap.height) if follows else None
                trial, trial_sums = trial_along(
                    problem, pressure, gap, closing, cells, last, conjugate_to, step_length, rigid
                )
                cut, slope = trial_sums.cut, trial_sums.slope
                if cut or problem.resultant.error(trial_sums.load) > rounding:
                    slope = passes.levelled(
                        trial, trial_sums, cells, problem.resultant, pressure, gap.height
                    )
                # or they would stand through the next convolution
                del closing, cells, conjugate_to
            last = None
            if slope >= 0:
                # balancing the load has turned the step uphill: that to the nearest pressure never is
                cut, step_length = True, max(step_length / 4, SHORTEST)
                slope = step_to_nearest(problem, trial, pressure, gap)
            trial_displacement = operator(trial)
            curvature = passes.curvature(trial, pressure, trial_displacement, displacement)
            best = -slope / curvature if curvature > 0 else 0.0
            share = share_to_take(passes, trial, pressure, best, cut=cut)
            if share != 1:
                passes.advance(trial, pressure, trial_displacement, displacement, share)
            last = PressureStep(
                pressure, trial, displacement, trial_displacement, curvature * share**2
            )
            pressure, displacement = trial, trial_displacement
            del trial, trial_displacement  # or they would stand beside the next ones
            step_length = min(max(step_length * min(max(best, 0.3), 3.0), SHORTEST), LONGEST)
