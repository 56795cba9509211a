"""
Traction of a mineral oil
=========================

Two steel discs roll and slide in a mineral oil of 96 mm²/s at 40 °C (M100). Traction first grows with the slip, then the oil thins under its shear, and
at last the heat of the shear lets it fall. All properties of the oil are from Arana, Larrañaga & Ulacia (2019): viscosity (eq. 30, table 3, fitted to
a high-pressure viscosimeter) and limiting stress (table 2), which gives the Eyring stress. They derive a formula for the friction, and report that
it follows the curves that Mann measured with this oil on twin discs at 1 GPa and 60 °C within 10 % at the highest speeds and slips. The measured
points are only drawn there, so that the formula stands beside the curve here. Radius and properties of steel are not given; those below are assumed.
"""

from math import asinh, exp, log, pi, sqrt

import matplotlib.pyplot as plt
import numpy as np

import contactstudy as cs

supply, peak = 333.15, 1e9  # K, Pa


def log_viscosity(temperature, pressure):
    rise = pressure / (-2.28e7 + 2.26e5 * temperature + (-0.0682 + 2.768e-4 * temperature) * pressure)
    return log(86.86e-6) + 890 / (temperature - 182) + rise


def pressure_viscosity(temperature, pressure):
    return 1 / (-2.28e7 + 2.26e5 * temperature + (-0.0682 + 2.768e-4 * temperature) * pressure)


# %%
# Roelands' law has the same viscosity at rest and at 1 GPa, and the same slopes with pressure and temperature at rest.

viscosity, slope = exp(log_viscosity(supply, 0)), pressure_viscosity(supply, 0)
growth = log_viscosity(supply, peak) - log_viscosity(supply, 0)
exponents = np.linspace(0.5, 0.8, 3001)
height = log(viscosity) + 9.67
laws = height * ((1 + peak * slope / (height * exponents)) ** exponents - 1)
exponent = float(exponents[np.argmin(abs(laws - growth))])
law = cs.Roelands(exponent, reference_pressure=exponent * height / slope)
limit = 0.047
eyring = cs.Eyring(2 * limit / pressure_viscosity(supply, peak))
oil = cs.Lubricant(viscosity, slope, law, shear=eyring)
heat = cs.FilmHeat(890 / (supply - 182) ** 2, conductivity=0.14, supply_temperature=supply)
steel, disc = cs.HalfSpace(210e9, 0.3), cs.Cylinder(0.02)
modulus = 210e9 / (2 * (1 - 0.3**2))
half_width = 2 * peak * 0.02 / modulus
load = cs.LineLoad(pi * half_width * peak / 2)
print(f"Roelands' exponent {exponent:.3f}, Eyring stress {eyring.reference / 1e6:.1f} MPa")
assert abs(exponent - 0.649) < 1e-3

# %%
# The film does not depend on the slip, so that each point starts from the one before. The curve is below the formula by a tenth at most: the formula takes a mean pressure for the distribution of it, and lets the Eyring stress grow as the oil heats
# up, which here is that of the supply.

slips = np.array([0.005, 0.01, 0.02, 0.04, 0.07, 0.1, 0.15, 0.2, 0.3, 0.4])


def curve(speed):
    grid, contact, friction = cs.Grid((320, 1), (6 * half_width, 1e-3)), None, []
    for slip in slips:
        motion = cs.Lubrication(oil, speed, float(slip), thermal=heat)
        scene = cs.Scene(load, (steel, steel), (disc,), lubrication=motion)
        contact = cs.solve(scene, grid, start=contact)
        friction.append(contact.friction)
    return contact.central_film * contact.temperatures.reduction, np.array(friction)


def formula(speed, slip, film):
    """Friction by eq. 13 at the mean pressure and temperature, of eqs. 26 to 28 with the heat shared evenly."""
    mean, temperature = pi / 4 * peak, supply
    body, _ = heat.bodies
    for _ in range(200):
        steepness = pressure_viscosity(temperature, peak)
        stress = exp(log_viscosity(temperature, mean)) * speed * slip / film
        friction = min(2 * limit / (steepness * mean) * asinh(stress * steepness / (2 * limit)), limit)
        flux = friction * mean * speed * slip
        flash = 0.53 * flux * sqrt(half_width / (body.conductivity * body.heat_capacity * speed))
        temperature += 0.3 * (supply + flash + flux * film / (8 * heat.conductivity) - temperature)
    return friction


figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
for speed, colour in ((2.0, "#0072B2"), (4.0, "#009E73"), (8.0, "#D55E00")):
    film, friction = curve(speed)
    expected = np.array([formula(speed, slip, film) for slip in slips])
    axes.plot(100 * slips, friction, "o-", color=colour, label=f"{speed:.0f} m/s")
    axes.plot(100 * slips, expected, "--", color=colour)
    off = friction / expected - 1
    print(f"{speed:.0f} m/s: " + ", ".join(f"{one:.4f}" for one in friction))
    print("  beside the formula: " + ", ".join(f"{100 * one:+.0f} %" for one in off))
    assert abs(off).max() < 0.12
    # it rises, and falls at high slip, the sooner the faster the discs
    assert 0 < friction.argmax() < len(slips) - 1
    assert friction[-1] < 0.97 * friction.max()
axes.set(xlabel="slip [%]", ylabel="friction (dashed: formula)", ylim=(0, 0.06))
axes.legend()
