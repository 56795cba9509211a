"""Pressure and plastic strain at the end of a load step, together: a semismooth Newton method.

S maps pressure to deviatoric stress, B plastic strain to minus its residual stress, and C is the number of independent
components of a deviator.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.solvers.conjugate_gradients import conjugate_gradients
from contactstudy.solvers.iterate import Stall
from contactstudy.solvers.plasticity.yielding_bodies import (
    SQRT_TWO_THIRDS,
    ReturnMapping,
    YieldingBodies,
)
from contactstudy.solvers.solution import Solution

# Map from a change of the gap (x, y) [m] to minus the change of the pressure (x, y) [Pa].
Tangent = Callable[[Array], Array]


@dataclass(frozen=True)
class PlasticConstants:
    """Constants of the Newton method of a load step.

    Attributes
    ----------
    max_iterations
        Newton iterations of a step; up to 15 were seen for a load of 5 times that of first yield in one step.
    stall_iterations
        Iterations without a halving of the residual after which a step ends: the tolerance of the contact limits it.
    min_fraction
        Smallest fraction of a Newton step that is tried before a step of plain return mapping is taken.
    max_forcing, min_forcing
        Range of the relative residual of a linear system; it is the square root of the residual in between (Eisenstat &
        Walker 1996), so that the convergence stays superlinear.
    maxiter
        Largest number of operator applications in a linear system.
    """

    max_iterations: int = 40
    stall_iterations: int = 12
    min_fraction: float = 1e-3
    max_forcing: float = 0.1
    min_forcing: float = 1e-6
    maxiter: int = 400


CONSTANTS = PlasticConstants()


@dataclass(frozen=True, eq=False)
class ElastoplasticStep:
    """State at the end of a load step.

    Parameters
    ----------
    solution
        The last solution of the contact.
    strain
        Plastic strain (C, cells).
    equivalent_increment
        Increment of the equivalent plastic strain in the step (cells,).
    residual
        Largest residual of the plastic strain, in units of yield stress over Young's modulus.
    iterations
        Number of Newton iterations.
    contacts
        All solutions of the contact on the way, in order.
    energy
        Energy [J] of the residual stress, with what the step dissipates and hardening stores.
    """

    solution: Solution
    strain: Array
    equivalent_increment: Array
    residual: float
    iterations: int
    contacts: tuple[Solution, ...]
    energy: float


def solve_elastoplastic_step(
    bodies: YieldingBodies,
    contact: Callable[[Array], Solution],
    tangent: Callable[[Solution], Tangent | None],
    strain_n: Array,
    equivalent_n: Array,
    tolerance: float,
    outer_stress: Array,
    guess: Array | None = None,
) -> ElastoplasticStep:
    """Return pressure and plastic strain at the end of a load step.

    Backward Euler in load. The plastic strain e is that of the return mapping of its own trial stress: with the pressure
    p over the surface lowered by the residual displacement ``S^T e``, the stress ``S p - B e`` is mapped back to the
    yield surface. These equations are those of the minimum of a convex energy. Source: Simo & Hughes (1998), box 3.1
    (return mapping); semismooth Newton with conjugate gradients and a line search on the forward-backward envelope of
    Stella, Themelis & Patrinos (2017).

    Parameters
    ----------
    bodies
        Operators, yield criteria and hardening of the bodies that yield.
    contact
        Solves for the pressure over a surface that is lowered by a field (x, y) [m].
    tangent
        Linearisation of `contact` at a solution; None for a given pressure.
    strain_n
        Plastic strain (C, cells) at the end of the last step.
    equivalent_n
        Equivalent plastic strain (cells,) at the end of the last step.
    tolerance
        Largest residual of the plastic strain, in units of yield stress over Young's modulus.
    outer_stress
        Further stress (C, cells) [Pa], as by plastic strain outside the volume.
    guess
        Plastic strain (C, cells) to begin with; None begins with that before the step.

    Returns
    -------
    ElastoplasticStep
        The last state, also where the tolerance was not reached.
    """
    contacts: list[Solution] = []

    def state_of(strain: Array) -> _State:
        solution = contact(bodies.residual_displacement(strain))
        contacts.append(solution)
        return _mapped_state(bodies, solution, strain, strain_n, equivalent_n, outer_stress)

    state = state_of(strain_n if guess is None else guess)
    stall, iterations = Stall(CONSTANTS.stall_iterations), 0
    while (
        tolerance < state.residual_norm
        and iterations < CONSTANTS.max_iterations
        and not stall.stalled(state.residual_norm)
    ):
        iterations += 1
        step = _newton_step(bodies, tangent(state.solution), state)
        state = _line_search(state_of, state, step)
    equivalent_increment = SQRT_TWO_THIRDS * state.mapped.multiplier
    return ElastoplasticStep(
        state.solution,
        state.mapped.strain,
        equivalent_increment,
        state.residual_norm,
        iterations,
        tuple(contacts),
        state.incremental_energy,
    )


@dataclass(frozen=True, eq=False)
class _State:
    """Plastic strain (C, cells), the contact under it, and the return mapping of its trial stress.

    The `residual` (C, cells) is the difference of the strain from the mapped one, `residual_norm` the largest of it in
    units of yield stress over Young's modulus, `energy` [J] the forward-backward envelope, and
    `incremental_energy` [J] its part that does not depend on the contact.
    """

    strain: Array
    solution: Solution
    mapped: ReturnMapping
    residual: Array
    residual_norm: float
    energy: float
    incremental_energy: float


def _mapped_state(
    bodies: YieldingBodies,
    solution: Solution,
    strain: Array,
    strain_n: Array,
    equivalent_n: Array,
    outer_stress: Array,
) -> _State:
    """Return the state of a plastic `strain` (C, cells) with the contact `solution` over its residual displacement."""
    reduction = bodies.negative_residual_stress(strain)
    stress = bodies.stress_of_pressure(solution.pressure) + outer_stress - reduction
    mapped = bodies.law.return_mapping(stress, strain, strain_n, equivalent_n)
    residual = strain - mapped.strain
    residual_norm = float((np.abs(residual) / bodies.yield_strain).max(initial=0.0))
    potential = bodies.law.incremental_potential(mapped.strain, strain_n, equivalent_n)
    incremental_energy = bodies.inner(strain, reduction) / 2 + float((potential * bodies.volumes).sum())
    energy = incremental_energy - bodies.inner(strain, outer_stress) - _contact_energy(solution, bodies.cell_area)
    energy += bodies.inner(stress + bodies.law.twice_shear_modulus / 2 * residual, residual)
    return _State(strain, solution, mapped, residual, residual_norm, energy, incremental_energy)


def _contact_energy(solution: Solution, cell_area: float) -> float:
    """Return the complementary energy of the contact [J], ``1/2 p K p + p h`` with the undeformed gap h."""
    heights = solution.problem.undeformed_gap + solution.displacement / 2
    return float(np.einsum("xy,xy->", solution.pressure, heights)) * cell_area


def _line_search(state_of: Callable[[Array], _State], state: _State, step: Array) -> _State:
    """Return the first state on a halved `step` that lowers the energy or halves the residual, else the mapped one."""
    fraction = 1.0
    while fraction >= CONSTANTS.min_fraction:
        trial = state_of(state.strain + fraction * step)
        if trial.energy < state.energy or trial.residual_norm < state.residual_norm / 2:
            return trial
        fraction /= 2
    return state_of(state.mapped.strain)


def _newton_step(bodies: YieldingBodies, tangent: Tangent | None, state: _State) -> Array:
    """Return the step of the plastic strain (C, cells) that solves the linearised return mapping.

    Cells that do not flow take their whole residual at once.
    """
    mapped, residual = state.mapped, state.residual
    flows = mapped.flows
    step = np.where(flows, 0.0, -residual)
    if not flows.any():
        return step
    moduli = mapped.consistent_plastic_moduli
    rhs = -mapped.inverse_derivative(residual)
    if step.any():
        rhs -= _negative_stress_change(bodies, tangent, step)
    rhs *= flows
    inverse = np.linalg.inv(moduli + bodies.diagonal_blocks(flows))

    def precondition(residual: Array) -> Array:
        strain = np.zeros_like(residual)
        strain[:, flows] = np.einsum("kij,jk->ik", inverse, residual[:, flows])
        return strain

    def product(strain: Array) -> Array:
        stress = _negative_stress_change(bodies, tangent, strain) * flows
        stress[:, flows] += np.einsum("kij,jk->ik", moduli, strain[:, flows])
        return stress

    forcing = max(min(CONSTANTS.max_forcing, state.residual_norm**0.5), CONSTANTS.min_forcing)
    return step + conjugate_gradients(product, precondition, bodies.inner, rhs, forcing, CONSTANTS.maxiter)


def _negative_stress_change(bodies: YieldingBodies, tangent: Tangent | None, strain: Array) -> Array:
    """Return minus the change of stress (C, cells) [Pa] by `strain`, with that of the pressure: ``(B + S Pi S^T) e``."""
    if tangent is None:
        return bodies.negative_residual_stress(strain)
    change = tangent(bodies.residual_displacement(strain))
    return bodies.negative_residual_stress(strain) + bodies.stress_of_pressure(change)
