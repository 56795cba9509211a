"""Pressure and plastic strain at the end of a load step, together: a semismooth Newton method.

S maps pressure to deviatoric stress, and B plastic strain to minus its residual stress. S^T, the transpose of S under
sums over volumes and cell areas, maps plastic strain to the displacement of the surface. Deviators have C components in
an orthonormal basis, 3 in plane strain and 5 otherwise: plain sums of their squares are norms. A subscript n means the
start of a step. The bodies yield by von Mises' criterion, with linear hardening; their volumes that may yield are one
list of cells. The contact acts by its tangent operator Pi, minus the derivative of the pressure with respect to the
gap. Adhesion and friction, which make further stress, are left to the caller.
"""

from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass
from functools import cached_property
from math import prod

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.grid import Array
from contactstudy.elasticity.eigenstrain.plane_strain_operator import EigenstrainOperator
from contactstudy.solvers.conjugate_gradients import Stall, conjugate_gradients
from contactstudy.solvers.solution import Solution

# The norm of a deviator over von Mises' stress, and the equivalent plastic strain over the norm of plastic strain.
SQRT_TWO_THIRDS = (2 / 3) ** 0.5


@dataclass(frozen=True, eq=False)
class VonMisesPlasticity:
    """Von Mises' yield criterion with linear hardening, with one value per cell (cells,) [Pa].

    `twice_shear_modulus` is 2G, and `yield_stress` that in tension. Hardening moduli, `isotropic` and `kinematic`
    (Prager), are the rise of the stress in tension over the plastic strain.
    """

    twice_shear_modulus: Array
    yield_stress: Array
    isotropic: Array
    kinematic: Array

    @property
    def deviatoric_hardening(self) -> Array:
        """Hardening of the deviatoric stress along the flow, ``d|s| / d|e| = 2/3 (H_i + H_k)`` (cells,) [Pa]."""
        return np.asarray(2 / 3 * (self.isotropic + self.kinematic))

    def return_mapping(self, stress: Array, strain: Array, strain_n: Array, equivalent_n: Array) -> "ReturnMapping":
        """Return the plastic strain that puts the trial stress onto the yield surface.

        `stress` (C, cells) [Pa] is that with the plastic `strain`; the trial stress is that of a cell without flow in
        the step, ``stress + 2G (strain - strain_n)``, less the back stress. `strain_n` and `equivalent_n` (cells,) are
        the plastic strain and its equivalent at the start of the step. This radial return (Simo & Hughes 1998, box 3.1)
        is one proximal-gradient step, of length 1 / 2G, on the energy.
        """
        trial = stress + self.twice_shear_modulus * (strain - strain_n) - (2 / 3) * self.kinematic * strain_n
        norm = np.sqrt(np.einsum("ck,ck->k", trial, trial))
        limit = SQRT_TWO_THIRDS * (self.yield_stress + self.isotropic * equivalent_n)
        multiplier = np.maximum(norm - limit, 0.0) / (self.twice_shear_modulus + self.deviatoric_hardening)
        flows = multiplier > 0
        direction = np.divide(trial, norm, out=np.zeros_like(trial), where=flows)
        return ReturnMapping(self, strain_n + multiplier * direction, direction, norm, multiplier, flows)

    def incremental_potential(self, strain: Array, strain_n: Array, equivalent_n: Array) -> Array:
        """Return the potential of the step from `strain_n` to `strain`, per volume (cells,) [Pa].

        It is the work that the yield stress dissipates in the step, with the energy of isotropic hardening in the step
        and that of kinematic hardening at its end.
        """
        squared = np.einsum("ck,ck->k", strain - strain_n, strain - strain_n)
        limit = SQRT_TWO_THIRDS * (self.yield_stress + self.isotropic * equivalent_n)
        stored = self.kinematic / 3 * np.einsum("ck,ck->k", strain, strain)
        return np.asarray(limit * np.sqrt(squared) + self.isotropic / 3 * squared + stored)


@dataclass(frozen=True, eq=False)
class ReturnMapping:
    """Return mapping of a trial stress to the yield surface.

    It has the plastic `strain` (C, cells) on the yield surface, the unit `direction` of flow (C, cells), and of shape
    (cells,) the `norm` of the trial stress [Pa], the increment of the plastic `multiplier` in the step, and whether a
    cell `flows`.
    """

    law: VonMisesPlasticity
    strain: Array
    direction: Array
    norm: Array
    multiplier: Array
    flows: NDArray[np.bool_]

    @property
    def _transverse(self) -> Array:
        """Inverse of the derivative across the direction of flow, ``|trial| / multiplier`` (cells,) [Pa].

        It is 0 where nothing flows. The derivative is that of the plastic strain with respect to the trial stress.
        """
        return np.asarray(self.norm / np.where(self.flows, self.multiplier, np.inf))

    def inverse_derivative(self, strain: Array) -> Array:
        """Return the inverse of the derivative of the return mapping times `strain` (C, cells) [Pa].

        It is 0 where nothing flows. The derivative is that of the plastic strain with respect to the trial stress.
        """
        law, transverse = self.law, self._transverse
        along = np.einsum("ck,ck->k", self.direction, strain) * self.direction
        return np.asarray(along * (law.twice_shear_modulus + law.deviatoric_hardening) + transverse * (strain - along))

    @property
    def consistent_plastic_moduli(self) -> Array:
        """Matrices ``D^-1 - 2G`` (flowing cells, C, C) [Pa], where D is the derivative of the return mapping.

        They are positive semidefinite.
        """
        flows, direction = self.flows, self.direction[:, self.flows]
        transverse = (self._transverse - self.law.twice_shear_modulus)[flows][:, None, None]
        along = self.law.deviatoric_hardening[flows][:, None, None]
        dyads = np.einsum("ik,jk->kij", direction, direction)
        return np.asarray(transverse * np.eye(len(direction)) + (along - transverse) * dyads)


@dataclass(frozen=True)
class Hardening:
    """Yield stress and moduli of isotropic and kinematic hardening of a body [Pa]."""

    yield_stress: float
    isotropic: float
    kinematic: float


@dataclass(frozen=True, eq=False)
class YieldingBodies:
    """Operators on plastic strain of one or two bodies, and how each hardens.

    Fields are (C, cells): the cells of the first body, then those of the second.
    """

    operators: tuple[EigenstrainOperator, ...]
    hardening: tuple[Hardening, ...]

    @cached_property
    def law(self) -> VonMisesPlasticity:
        """Yield criterion and hardening of all cells; its fields after 2G are those of `Hardening`, in their order."""
        rows = [(2 * o.moduli.shear, *astuple(h)) for o, h in zip(self.operators, self.hardening, strict=True)]
        return VonMisesPlasticity(*map(self._per_cell, np.transpose(rows)))

    @cached_property
    def yield_strain(self) -> Array:
        """Yield stress over Young's modulus (cells,)."""
        bodies = zip(self.operators, self.hardening, strict=True)
        return self._per_cell([h.yield_stress / o.moduli.youngs_modulus for o, h in bodies])

    @cached_property
    def volumes(self) -> Array:
        """Volume of each cell (cells,) [m^3]."""
        return self.concatenated([np.broadcast_to(o.volume.cell_volumes, o.volume.shape) for o in self.operators])

    def diagonal_blocks(self, cells: NDArray[np.bool_]) -> Array:
        """Return minus the residual stress of each chosen cell by its own unit strain (chosen cells, C, C) [Pa]."""
        shapes = [operator.volume.shape for operator in self.operators]
        layers = np.repeat(range(sum(n for n, _, _ in shapes)), [nx * ny for n, nx, ny in shapes for _ in range(n)])
        blocks = np.concatenate([operator.diagonal_blocks for operator in self.operators])
        return np.asarray(blocks[layers[cells]])

    @property
    def cell_area(self) -> float:
        """Area of a cell of the surface grid [m^2]."""
        return self.operators[0].volume.grid.cell_area

    def concatenated(self, fields: Sequence[Array]) -> Array:
        """Return the fields (..., layers, x, y) of all bodies as one field (..., cells)."""
        return np.concatenate([field.reshape(*field.shape[:-3], -1) for field in fields], axis=-1)

    def split(self, field: Array) -> list[Array]:
        """Return the field (..., layers, x, y) of each body in one `field` (..., cells)."""
        parts = np.split(field, np.cumsum(self._sizes)[:-1], axis=-1)
        shapes = (operator.volume.shape for operator in self.operators)
        return [part.reshape(*field.shape[:-1], *shape) for part, shape in zip(parts, shapes, strict=True)]

    def stress_of_pressure(self, pressure: Array) -> Array:
        """Return the deviatoric stress S p (C, cells) [Pa] under `pressure` (x, y) [Pa]."""
        return self.concatenated([o.stress_of_pressure(pressure) for o in self.operators])

    def negative_residual_stress(self, strain: Array) -> Array:
        """Return B e, minus the deviatoric residual stress (C, cells) [Pa] of plastic `strain` e."""
        parts = zip(self.operators, self.split(strain), strict=True)
        return self.concatenated([operator.negative_residual_stress(part) for operator, part in parts])

    def residual_displacement(self, strain: Array) -> Array:
        """Return the surface displacement ``S^T e`` (x, y) [m] by plastic `strain`, of all bodies together."""
        parts = zip(self.operators, self.split(strain), strict=True)
        return np.asarray(sum(operator.residual_displacement(part) for operator, part in parts))

    def inner(self, first: Array, second: Array) -> float:
        """Return the inner product of two fields (C, cells), integrated over the volume [m^3 times their units]."""
        return float(np.einsum("ck,ck,k->", first, second, self.volumes))

    @property
    def _sizes(self) -> list[int]:
        """Number of cells of each body."""
        return [prod(operator.volume.shape) for operator in self.operators]

    def _per_cell(self, values: Sequence[float] | Array) -> Array:
        """Return the `values` of the bodies for every cell (cells,)."""
        return np.repeat(values, self._sizes)


# Map from a change of the gap (x, y) [m] to minus the change of the pressure (x, y) [Pa].
Tangent = Callable[[Array], Array]


# The numbers seen are those of 48 contacts, smooth and wavy along, of no to 10 % hardening. They reach two to eight
# times the load of first yield in one step or three, with tolerances of 1e-5 and 1e-8.
# Largest number of Newton iterations of a step; up to 14 were seen.
MAX_ITERATIONS = 40
# Iterations without a halving of the residual after which a step ends: the tolerance of the contact limits it then.
STALL_ITERATIONS = 12
# Smallest fraction of a Newton step that is tried before a step of plain return mapping is taken; the smallest seen was
# a half.
MIN_FRACTION = 1e-3
# Range of the relative residual of a linear system. In between, the square root of the residual of the plastic strain
# keeps the convergence superlinear (Eisenstat & Walker 1996). Half or twice of the larger changes the convolutions of
# three contacts by less than a tenth; a hundredth or a hundred times the smaller changed none.
MAX_FORCING, MIN_FORCING = 0.1, 1e-6
# Largest number of operator applications in the solution of a linear system; up to 35 were seen.
MAX_APPLICATIONS = 400


@dataclass(frozen=True, eq=False)
class ElastoplasticStep:
    """State at the end of a load step.

    Parameters
    ----------
    solution
        The last solution of the contact, over the displacement by the strain before its last return mapping.
    strain
        Plastic strain (C, cells), mapped to the yield surface.
    equivalent_increment
        Increment of the equivalent plastic strain in the step (cells,).
    residual
        Largest residual of the plastic strain, in units of yield stress over Young's modulus.
    iterations
        Number of Newton iterations.
    contacts
        All solutions of the contact on the way, in order.
    energy
        Incremental energy [J]: that of the residual stress, with what the step dissipates and hardening stores.
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
    tangent: Callable[[Solution], Tangent] | None,
    strain_n: Array,
    equivalent_n: Array,
    tolerance: float,
    outer_stress: Array,
    guess: Array | None = None,
) -> ElastoplasticStep:
    """Return pressure and plastic strain at the end of a load step.

    Backward Euler in load. The plastic strain e is that of the return mapping of its own trial stress, by the stress
    ``S p - B e``. The pressure p is that over the surface lowered by the residual displacement ``S^T e``. These
    equations are those of the minimum of a convex energy. Source: Simo & Hughes (1998), box 3.1 (return mapping);
    semismooth Newton with conjugate gradients and a line search on the forward-backward envelope of Stella, Themelis &
    Patrinos (2017).

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
        """Return the state of a plastic strain (C, cells) with the contact over its residual displacement."""
        solution = contact(bodies.residual_displacement(strain))
        contacts.append(solution)
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

    state = state_of(strain_n if guess is None else guess)
    stall, iterations = Stall(STALL_ITERATIONS), 0
    while tolerance < state.residual_norm and iterations < MAX_ITERATIONS and not stall.stalled(state.residual_norm):
        iterations += 1
        step = _newton_step(bodies, tangent and tangent(state.solution), state)
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

    The `residual` r (C, cells) is the strain less the mapped one, `residual_norm` the largest of it in units of yield
    stress over Young's modulus. The `energy` [J] is the forward-backward envelope
    ``f(strain) + g(mapped) - <grad f, r> + G |r|^2``, with the potential g of the step and ``grad f = -stress``. Here f
    is the energy of the residual stress, less the work of the outer stress and the complementary energy of the contact.
    `incremental_energy` [J] is the first part of f, with g.
    """

    strain: Array
    solution: Solution
    mapped: ReturnMapping
    residual: Array
    residual_norm: float
    energy: float
    incremental_energy: float


def _contact_energy(solution: Solution, cell_area: float) -> float:
    """Return the complementary energy of the contact [J], ``1/2 p K p + p h``.

    The gap h is the undeformed one of the solution's own problem, over the surface lowered by the residual displacement.
    """
    heights = solution.problem.undeformed_gap + solution.displacement / 2
    return float(np.einsum("xy,xy->", solution.pressure, heights)) * cell_area


def _line_search(state_of: Callable[[Array], _State], state: _State, step: Array) -> _State:
    """Return the first state on a halved `step` that lowers the energy or halves the residual, else the mapped one."""
    fraction = 1.0
    while fraction >= MIN_FRACTION:
        trial = state_of(state.strain + fraction * step)
        if trial.energy < state.energy or trial.residual_norm < state.residual_norm / 2:
            return trial
        fraction /= 2
    return state_of(state.mapped.strain)


def _newton_step(bodies: YieldingBodies, tangent: Tangent | None, state: _State) -> Array:
    """Return the step of the plastic strain (C, cells) that solves the linearised return mapping.

    On the flowing cells it solves ``(B + S Pi S^T + D^-1 - 2G) step = -D^-1 r``, with the residual r and the derivative
    D of the return mapping. Cells that do not flow take their whole residual at once.
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
        """Return the strain (C, cells) by which each flowing cell alone makes a `residual` stress (C, cells) [Pa]."""
        strain = np.zeros_like(residual)
        strain[:, flows] = np.einsum("kij,jk->ik", inverse, residual[:, flows])
        return strain

    def product(strain: Array) -> Array:
        """Return the left side of the system (C, cells) [Pa] for a `strain` that is zero where nothing flows."""
        stress = _negative_stress_change(bodies, tangent, strain) * flows
        stress[:, flows] += np.einsum("kij,jk->ik", moduli, strain[:, flows])
        return stress

    forcing = max(min(MAX_FORCING, state.residual_norm**0.5), MIN_FORCING)
    return step + conjugate_gradients(product, precondition, bodies.inner, rhs, forcing, MAX_APPLICATIONS)


def _negative_stress_change(bodies: YieldingBodies, tangent: Tangent | None, strain: Array) -> Array:
    """Return minus the change of stress (C, cells) [Pa] by `strain`, with that of the pressure: ``(B + S Pi S^T) e``."""
    if tangent is None:
        return bodies.negative_residual_stress(strain)
    change = tangent(bodies.residual_displacement(strain))
    return bodies.negative_residual_stress(strain) + bodies.stress_of_pressure(change)
