"""Films over a body that yields and stands still: steady films under a load that changes, over the dent that they press.

Film and plastic strain are solved together as a dry contact and plastic strain are: the film over a surface that is
lowered by the residual displacement gives the pressure, whose stress is mapped back to the yield surface. In Newton's
method for the strain, the pressure of the film changes as that of a dry contact of the loaded cells would. The shear
stress of the film, some hundredths of its pressure, is left out: a tenth raises the largest von Mises stress by 1.4 %.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import ceil, inf

import numpy as np
from numpy.typing import ArrayLike

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.evolution.equilibrium.surface_depth import SurfaceDepth
from contactstudy.evolution.states.plastic import PlasticState, YieldingBody
from contactstudy.evolution.states.state_variables import State
from contactstudy.evolution.warm_started import with_added_gap
from contactstudy.lubrication.evolve_lubricated import check_loaded, instants_of
from contactstudy.lubrication.film_trajectory import FilmTrajectory, errors_from_longer_steps
from contactstudy.lubrication.lubricated_contact import FilmSolution
from contactstudy.lubrication.newton.pseudo_time import FilmControls
from contactstudy.lubrication.steady_film import solve_on
from contactstudy.problem.problem import Problem
from contactstudy.scene.loads.load_history import ChangingLoad, loads_between
from contactstudy.scene.scene import Scene
from contactstudy.scene.solids.bodies import instantaneous
from contactstudy.solvers.plasticity.contact_tangent import ContactTangent
from contactstudy.solvers.solution import Solution, Status, worst
from contactstudy.solvers.solve import SolveOptions

# Increments of the largest load, at least, in the run that estimates the time-discretisation error; the other has twice
# as many. The error of the peak pressure was .9 of its estimate with 4, and 1.8 times the estimate with 2.
INCREMENTS = 4
# Fraction of the highest pressure above which a cell counts as loaded in the derivative of the pressure.
LOADED = 0.02
# Tolerance of the plastic strain over that of each film.
STRAIN_TOLERANCE = 10.0


@dataclass(frozen=True, eq=False, kw_only=True)
class YieldingFilms(FilmTrajectory):
    """Films over a body that yields.

    Attributes
    ----------
    plastic
        State variable of the plastic strain.
    states
        Its state (time,) at each instant.
    """

    plastic: PlasticState
    states: tuple[State, ...]


@dataclass(eq=False)
class FilmContact:
    """Steady film of a scene with a field added to its gap, begun with the one solved before.

    Attributes
    ----------
    scene
        The lubricated scene, under one load.
    dry
        The dry contact of the elastic bodies, whose problem the solutions name.
    padding
        Boundary conditions.
    controls
        Tolerance and limit of the steps of each film.
    film
        The film solved last, or the one to begin with; None begins anew.
    linear_iterations
        Iterations of the linear systems of all films so far.
    """

    scene: Scene
    dry: Problem
    padding: Padding | Paddings
    controls: FilmControls
    film: FilmSolution | None
    linear_iterations: int = field(init=False, default=0)

    def __call__(self, added_gap: Array) -> Solution:
        """Return the film with `added_gap` (x, y) [m] added to its gap, as a contact."""
        grid = self.dry.grid
        dented = replace(self.scene, shapes=(*self.scene.shapes, SurfaceDepth(added_gap, grid)))
        film = self.film = solve_on(dented, grid, self.padding, self.controls, self.film)
        self.linear_iterations += film.linear_iterations
        problem = with_added_gap(self.dry, added_gap)
        return Solution(
            problem=problem,
            pressure=film.pressure,
            displacement=film.film - film.separation - problem.undeformed_gap,
            gap=film.film,
            approach=-film.separation,
            status=film.status,
            iterations=film.iterations,
            convolutions=0.0,
            residual=film.residual,
        )


@dataclass(eq=False)
class PlasticStateBelowFilm(PlasticState):
    """State variable of the plastic strain below a film, in whose tangent lightly loaded cells do not count."""

    def _tangent(self, solution: Solution) -> ContactTangent:
        loaded = solution.pressure > LOADED * solution.pressure.max()
        return super()._tangent(replace(solution, pressure=solution.pressure * loaded))


def follow_yielding_film(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    *,
    times: ArrayLike | None,
    options: SolveOptions,
    progress: Callable[[float, float], None] | None = None,
) -> YieldingFilms:
    """Follow the film of a scene whose body yields, steady at each instant, under a constant load or one that changes.

    The load goes from one turning point or instant to the next, from zero on, in two or more equal increments, each an
    implicit step for the plastic strain. A second run with half as many gives the time-discretisation errors, see
    :func:`~contactstudy.lubrication.film_trajectory.time_discretisation_errors`.

    Parameters
    ----------
    scene
        A lubricated scene in which the body that yields stands still.
    grid, padding
        As for a steady film.
    times
        Instants [s] to record; None records the first and the last of the load history.
    options
        Tolerance and limit of the steps of each film.
    progress
        Called with the time since the start and that of the whole [s], after each instant.
    """
    instants = instants_of(scene, times)
    check_loaded(scene, instants)
    fine, coarse = (
        _with_increments(scene, grid, padding, instants, factor, options, report)
        for factor, report in ((2, progress), (1, None))
    )
    return replace(fine, time_discretisation_errors=errors_from_longer_steps(fine, coarse.contacts))


def _with_increments(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    instants: list[float],
    factor: int,
    options: SolveOptions,
    progress: Callable[[float, float], None] | None,
) -> YieldingFilms:
    """Return the film at all instants, after a `factor` times the least load increments to each."""
    if isinstance(scene.load, ChangingLoad):
        paths = _load_paths(scene.load, instants)
    else:
        paths = [[scene.largest_load] for _ in instants]
    largest = max(value for path in paths for value in path)
    controls = FilmControls(tolerance=options.tolerance, max_iterations=options.max_iterations)
    dry = replace(scene, lubrication=None, solids=instantaneous(scene.solids), outputs=())
    problem = dry.under(largest).problem(grid, padding)

    def contact_under(value: float, start: FilmSolution | None) -> FilmContact:
        return FilmContact(scene.under(value), problem, padding, controls, start)

    plastic = PlasticStateBelowFilm(
        YieldingBody.in_scene(scene),
        contact_under(largest, None)(np.zeros(grid.cells)),
        options.precision,
    )
    state = plastic.start(grid.cells)
    contacts: list[FilmSolution] = []
    states: list[State] = []
    film, steps, iterations, linear_iterations, last = None, 0, 0, 0, 0.0
    for time, path in zip(instants, paths, strict=True):
        statuses: list[Status] = []
        for value in path:
            increments = factor * max(ceil(INCREMENTS * abs(value - last) / largest), 1)
            steps += increments
            for part in range(1, increments + 1):
                contact = contact_under(last + (value - last) * part / increments, film)
                solution, state, _ = plastic.solve_step(
                    state, contact, STRAIN_TOLERANCE * options.tolerance
                )
                film, iterations = contact.film, iterations + solution.iterations
                linear_iterations += contact.linear_iterations
                statuses.append(solution.status)
            last = value
        assert film is not None
        contacts.append(replace(film, scene=scene, status=worst([*statuses, film.status])))
        states.append(state)
        if progress is not None:
            progress(time - instants[0], instants[-1] - instants[0])
    return YieldingFilms(
        tuple(instants),
        tuple(contacts),
        steps,
        iterations,
        linear_iterations,
        plastic=plastic,
        states=tuple(states),
    )


def _load_paths(load: ChangingLoad, instants: list[float]) -> list[list[float]]:
    """Return, for each instant [s], the loads [N/m] to go through since the one before: where it turns, then its own.

    A load of zero, under which no film has a thickness, is left out.
    """
    paths, previous = [], -inf
    for time in instants:
        loads = [*loads_between(load, previous, time), load.at(time)]
        paths.append([a for a, b in pairwise(loads) if 0 < a != b] + loads[-1:])
        previous = time
    return paths
