"""
A wavy surface pressed flat
===========================

Westergaard's contact of a wavy surface has a closed form at every load, up to full contact. It tests both exact
periodicity and the error estimate.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactstudy as cs

steel = cs.HalfSpace(youngs_modulus=210e9, poisson_ratio=0.3)
rigid = cs.HalfSpace(youngs_modulus=np.inf, poisson_ratio=0.0)
wavelength, amplitude = 1e-4, 1e-7
wave = cs.Waviness(amplitude=amplitude, across=wavelength)  # a crest lies at the origin
grid = cs.Grid(cells=(512, 1), extent=(wavelength, wavelength))
periodic = (cs.ExactPeriodicity(), cs.ExactPeriodicity())

figure, ax = plt.subplots(layout="constrained")
flat = cs.Scene(cs.LineLoad(1.0), (steel, rigid), (wave,))
complete = np.pi * flat.contact_modulus * amplitude / wavelength
errors = []
for share in (0.1, 0.3, 0.6, 0.9):
    scene = cs.Scene(cs.LineLoad(share * complete * wavelength), (steel, rigid), (wave,))
    solution = cs.solve(scene.problem(grid, periodic))
    closed = cs.analytic.westergaard(share * complete, amplitude, wavelength, scene.contact_modulus)
    exact = closed.pressure(grid.x)
    errors.append(np.abs(solution.pressure[:, 0] - exact).sum() / exact.sum())
    ax.plot(
        grid.x / wavelength, solution.pressure[:, 0] / complete, label=f"{share:.0%} of closing"
    )
    ax.plot(grid.x / wavelength, exact / complete, ":", color="black")
ax.set(xlabel="across / wavelength", ylabel="pressure / closing pressure")
ax.legend()

# %%
print("errors in L1:", [f"{error:.1e}" for error in errors])
assert max(errors) < 2e-3
