"""Relaxation and creep as sums of exponentials, and the one from the other."""

from dataclasses import dataclass

import numpy as np

from contactstudy.domain.devices.arrays import Array

# Halvings, in the logarithm, of a bracket as wide as the floating-point numbers: down to rounding.
HALVINGS = 80


@dataclass(frozen=True)
class Creep:
    """``instantaneous + fluidity t + sum(J_i (1 - exp(-t / lambda_i)))``, the answer to a unit step.

    ``instantaneous`` and every ``J_i`` in one unit, ``fluidity`` in that unit per second; ``terms`` are pairs
    (J_i, lambda_i [s]).
    """

    instantaneous: float
    terms: tuple[tuple[float, float], ...] = ()
    fluidity: float = 0.0

    def __call__(self, time: float | Array) -> Array:
        """Its value at ``time`` [s] from 0 on."""
        time = np.asarray(time, dtype=np.float64)
        value = self.instantaneous + self.fluidity * time
        for size, duration in self.terms:
            value = value - size * np.expm1(-time / duration)
        return value

    @property
    def equilibrium(self) -> float:
        """Its limit after infinite time; infinite for a fluid."""
        if self.fluidity:
            return float("inf")
        return self.instantaneous + sum(size for size, _ in self.terms)

    def times(self, factor: float) -> "Creep":
        """The same, ``factor`` times as large."""
        terms = tuple((factor * size, duration) for size, duration in self.terms)
        return Creep(factor * self.instantaneous, terms, factor * self.fluidity)


def creep(equilibrium: float, relaxation: tuple[tuple[float, float], ...]) -> Creep:
    """The creep of a body whose modulus relaxes as ``equilibrium + sum(E_i exp(-t / tau_i))``.

    ``relaxation`` are pairs (E_i > 0, tau_i > 0 [s]); without an ``equilibrium`` modulus the body is a Maxwell
    fluid. The rates 1 / lambda_i are the zeros of ``E(s) = equilibrium + sum(E_i s / (s + 1 / tau_i))``, which lie one
    between each pair of neighbouring rates 1 / tau_i, so each is bracketed.
    Source: Park & Schapery (1999), Int. J. Solids Struct. 36, eqs. 13 to 23.
    """
    merged: dict[float, float] = {}
    for modulus, time in relaxation:
        merged[1 / time] = merged.get(1 / time, 0.0) + modulus
    rates = np.array(sorted(merged))
    moduli = np.array([merged[rate] for rate in rates])
    instantaneous = 1 / (equilibrium + float(moduli.sum()))
    if equilibrium == 0:
        # one zero is at s = 0: what flows
        fluidity = 1 / float((moduli / rates).sum())
        low, high = rates[:-1], rates[1:]
    else:
        fluidity = 0.0
        slowest = rates[:1] * min(0.5, equilibrium / (2 * moduli.sum())) if rates.size else rates
        low, high = np.concatenate([slowest, rates[:-1]]), rates
    zeros = _zeros(equilibrium, moduli, rates, low.copy(), high.copy())
    steepness = (moduli * rates / (rates - zeros[:, None]) ** 2).sum(axis=1)
    sizes = 1 / (zeros * steepness)
    terms = tuple((float(size), float(1 / zero)) for size, zero in zip(sizes, zeros, strict=True))
    return Creep(instantaneous, terms, fluidity)


def _zeros(equilibrium: float, moduli: Array, rates: Array, low: Array, high: Array) -> Array:
    """Where ``equilibrium + sum(E_i z / (z - 1 / tau_i))`` falls through zero, in each bracket, by halving."""
    for _ in range(HALVINGS):
        middle = np.sqrt(low) * np.sqrt(high)
        middle = np.clip(middle, np.nextafter(low, high), np.nextafter(high, low))
        value = equilibrium + (moduli * middle[:, None] / (middle[:, None] - rates)).sum(axis=1)
        low, high = np.where(value > 0, middle, low), np.where(value > 0, high, middle)
    return np.asarray(np.sqrt(low) * np.sqrt(high))
