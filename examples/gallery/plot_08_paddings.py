"""
Four approximate paddings and the exact one
===========================================

A window of images that reaches D to each side raises the peak pressure of a line contact by about ``a^2 / (8 D^2)``, on any
grid. Only exact periodicity leaves no such error.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactstudy as cs

steel = cs.HalfSpace(youngs_modulus=210e9, poisson_ratio=0.3)
scene = cs.Scene(cs.LineLoad(1e5), (steel, steel), (cs.Cylinder(radius=0.01),))
a, p_hertz = scene.hertz.half_width, scene.hertz.peak_pressure
grid = cs.Grid(cells=(128, 32), extent=(2.4 * a, 2.4 * a))
paddings = {
    "duplicated": cs.DuplicatedPadding(),
    "circular, n = 1": cs.CircularSuperposition(1),
    "circular, n = 3": cs.CircularSuperposition(3),
    "circular, n = 6": cs.CircularSuperposition(6),
    "circular, n = 12": cs.CircularSuperposition(12),
}
exact = cs.solve(scene.problem(grid, cs.ExactPeriodicity())).pressure.max()

reaches, errors = [], []
for name, padding in paddings.items():
    peak = cs.solve(scene.problem(grid, padding)).pressure.max()
    reaches.append(padding.reach(grid.period))
    errors.append(peak / exact - 1)
    print(f"{name}: {100 * errors[-1]:.3f} % above exact periodicity")
law = cs.analytic.truncation_error(a, np.array(reaches))

figure, ax = plt.subplots(layout="constrained")
ax.loglog(np.array(reaches) / a, errors, "o", label="solved")
ax.loglog(np.array(reaches) / a, law, ":", color="black", label="$a^2 / (8 D^2)$")
ax.set(xlabel="reach D / a", ylabel="error of the peak pressure")
ax.legend()

# %%
# From D = 3 a on the law holds within 10 %; exact periodicity agrees with Hertz to 1e-5.

far = np.array(reaches) > 3 * a
assert np.allclose(np.array(errors)[far], law[far], rtol=0.1)
assert abs(exact / p_hertz - 1) < 2e-5
