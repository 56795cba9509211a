"""Mixed lubrication: the starts of a film on which asperities may touch.

The film ``H = H0 + gap + K (P_f + P_c)`` is no thinner than the boundary film ``H_b``, and where ``H = H_b`` asperities
carry a pressure ``P_c >= 0``. Lubricant flows in every cell, by its own pressure ``P_f`` and the thickness. The
iteration of :mod:`contactstudy.lubrication.newton.pseudo_time` solves both together.

Transverse ridges may have two solutions at one speed: ridges in a thick film, or flattened by contact. The film at a
higher speed leads to the first where it exists, the dry contact to the second. Where cold starts fail, any film is
followed from a higher speed down.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from contactstudy.lubrication.film_equation import Film, Mask
from contactstudy.lubrication.newton.pseudo_time import FilmControls, FilmIteration, iterate
from contactstudy.lubrication.posed_film import PosedFilm, hertz_start, linear_solver
from contactstudy.solvers.solve import SolveOptions, solve_contact


@dataclass(frozen=True)
class SpeedSteps:
    """Factor of each step in speed, the most increases, and the least factor of a decrease."""

    factor: float
    max_increases: int
    min_factor: float


def from_higher_speeds(
    posed: PosedFilm,
    steps: SpeedSteps,
    tolerance: float,
    cold: Callable[[PosedFilm], FilmIteration],
    warm: Callable[[PosedFilm, FilmIteration], FilmIteration],
) -> FilmIteration | None:
    """Return the film that is followed from the first higher speed where a ``cold`` start converges.

    Each lower speed has a ``warm`` start from the last; a step down that fails is tried again with the square root of
    its factor. None where no higher speed converges, or the factor falls below the least.
    """
    wanted = faster = posed.equation.speed_parameter
    for _ in range(steps.max_increases):
        faster *= steps.factor
        last = cold(posed.at(faster))
        if last.converged(tolerance):
            break
    else:
        return None
    factor = steps.factor
    while faster > wanted:
        slower = faster / factor
        if slower <= wanted * steps.min_factor:  # avoid a tiny last step
            slower = wanted
        trial = warm(posed.at(slower), last)
        if trial.converged(tolerance):
            last, faster = trial, slower
        else:
            factor = sqrt(factor)
            if factor <= steps.min_factor:
                return None
    return last


@dataclass(frozen=True)
class MixedTuning:
    """Tuning constants of the starts, chosen by what converges on ridges at 1 to 1e-6 times a speed.

    At that speed Moes's load parameter M was 20 and 100.

    Attributes
    ----------
    from_film, from_dry
        First steps in pseudo-time. From the dry contact it is nearly Newton's: 5 to 9 steps at load
        fractions above 0.88.
    change
        Largest change of ln(eta) in a step from a film.
    max_active_set_iterations, max_active_set_iterations_along
        Largest number of iterations for the active sets of a step, in plane strain and along the length. There a set
        moves downstream by a few cells in an iteration, and need not converge in each step: with 12, films of a narrow
        transition took three times the linear iterations.
    dry_steps
        Steps from the dry contact in plane strain: more are spent where there is a film.
    dry_residual
        Residual of the dry contact to start from.
    speeds
        Speeds of the continuation where neither start converges.
    faster, slower
        Factors on the speed of the films and the dry contacts from which other films are sought: of eight speeds of
        three waves, where two films were known, one or both led to the other.
    """

    from_film: float = 0.1
    from_dry: float = 10.0
    change: float = 6.0
    max_active_set_iterations: int = 12
    max_active_set_iterations_along: int = 3
    dry_steps: int = 30
    dry_residual: float = 1e-10
    speeds: SpeedSteps = SpeedSteps(1.3, 5, 1.02)
    faster: float = 4.0
    slower: float = 3.0


TUNING = MixedTuning()


def solve_mixed(posed: PosedFilm, controls: FilmControls, warm: tuple[Film, Mask] | None = None) -> FilmIteration:
    """Return the film from the first start that converges, else that of the least residual.

    The starts are ``warm`` (a film and its cavitated cells), Hertz's pressure on the film of Moes, the dry contact, and
    in plane strain higher speeds. The dry contact comes before Hertz's pressure where the film of Moes is thinner than
    the boundary film.
    """
    controls, film_controls, dry_controls = _controls(posed, controls)
    in_plane_strain = posed.upstream.cells[1] == 1
    iterations: list[FilmIteration] = []
    if warm is not None:
        film, cavitated = warm
        near_dry = not in_plane_strain and 2 * film.asperity_pressure.sum() > film.total_pressure.sum()
        if near_dry:
            iterations.append(_iterated(posed, film, dry_controls, cavitated))
        if not (iterations and iterations[-1].converged(controls.tolerance)):
            iterations.append(_iterated(posed, film, film_controls, cavitated))
    starts = [(_film_start, film_controls), (_dry_start, dry_controls)]
    if posed.scales.expected_film < posed.equation.boundary_film:
        starts.reverse()
    for start, start_controls in starts:
        if iterations and iterations[-1].converged(controls.tolerance):
            return iterations[-1]
        iterations.append(_iterated(posed, start(posed), start_controls))
    if in_plane_strain and not iterations[-1].converged(controls.tolerance):
        from_higher_speed = from_higher_speeds(
            posed,
            TUNING.speeds,
            controls.tolerance,
            lambda faster: _iterated(faster, _film_start(faster), film_controls),
            lambda slower, last: _iterated(slower, last.film, film_controls),
        )
        iterations += [from_higher_speed] if from_higher_speed else []
    return min(iterations, key=lambda iteration: iteration.residual)


def other_films(posed: PosedFilm, controls: FilmControls) -> Iterator[FilmIteration]:
    """Iterate over films in plane strain from a faster one, and from the dry contact at a lower speed."""
    controls, film_controls, dry_controls = _controls(posed, controls)
    speed = posed.equation.speed_parameter
    for factor, start, start_controls in (
        (TUNING.faster, _film_start, film_controls),
        (1 / TUNING.slower, _dry_start, dry_controls),
    ):
        other = posed.at(factor * speed)
        at_other_speed = _iterated(other, start(other), start_controls)
        if at_other_speed.converged(controls.tolerance):
            yield _iterated(posed, at_other_speed.film, film_controls)


def _controls(posed: PosedFilm, controls: FilmControls) -> tuple[FilmControls, FilmControls, FilmControls]:
    """Return the controls of a mixed film, those from a film, and those from the dry contact."""
    in_plane_strain = posed.upstream.cells[1] == 1
    controls = replace(
        controls,
        max_active_set_iterations=TUNING.max_active_set_iterations
        if in_plane_strain
        else TUNING.max_active_set_iterations_along,
    )
    film_controls = replace(
        controls, time_step=TUNING.from_film, viscosity_change=TUNING.change, converged_only=in_plane_strain
    )
    dry_controls = replace(controls, time_step=TUNING.from_dry)
    if in_plane_strain:
        dry_controls = replace(dry_controls, max_iterations=TUNING.dry_steps)
    return controls, film_controls, dry_controls


def _film_start(posed: PosedFilm) -> Film:
    """Return Hertz's pressure on the film of Moes, raised to the boundary film, without contact."""
    start, equation = hertz_start(posed), posed.equation
    rise = max(0.0, equation.boundary_film - float(start.thickness.min()))
    return equation.film_of(start.pressure, start.void, start.separation + rise)


def _dry_start(posed: PosedFilm) -> Film:
    """Return the dry contact on the boundary film, in a gap full of lubricant without pressure."""
    equation = posed.equation
    options = SolveOptions(tolerance=TUNING.dry_residual)
    dry = solve_contact(posed.problem, options, posed.dry_pressure).pressure[: len(posed.x)]
    asperity_pressure = np.asarray(dry / posed.scales.hertz.peak_pressure)
    zeros = np.zeros_like(asperity_pressure)
    below = (equation.gap + equation.deflection(asperity_pressure)).min()
    return equation.film_of(zeros, zeros, equation.boundary_film - float(below), asperity_pressure)


def _iterated(posed: PosedFilm, start: Film, controls: FilmControls, cavitated: Mask | None = None) -> FilmIteration:
    return iterate(posed.equation, start, linear_solver(posed), controls, cavitated=cavitated)
