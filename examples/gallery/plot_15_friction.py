"""
Stick and slip
==============

A tangential force below the friction limit: the middle of the contact sticks, its edges slip. For like bodies the stick zone is
``c / a = sqrt(1 - Q / (mu P))`` (Cattaneo, Mindlin).
"""

import matplotlib.pyplot as plt
import numpy as np

import contactstudy as cs

steel = cs.HalfSpace(youngs_modulus=210e9, poisson_ratio=0.3)
load, mu = 1e5, 0.3
smooth = cs.Scene(cs.LineLoad(load), (steel, steel), (cs.Cylinder(radius=0.01),))
a, p_hertz = smooth.hertz.half_width, smooth.hertz.peak_pressure
grid = cs.Grid(cells=(512, 1), extent=(2.4 * a, a))

figure, ax = plt.subplots(layout="constrained")
ax.plot(
    grid.x / a,
    mu * smooth.hertz.pressure(grid.x) / (mu * p_hertz),
    ":",
    color="black",
    label="limit",
)
for share in (0.2, 0.5, 0.8):
    friction = cs.PartialSlip(coefficient=mu, tangential=share * mu * load)
    scene = cs.Scene(smooth.load, smooth.solids, smooth.shapes, friction=friction)
    solution = cs.solve(scene.problem(grid, cs.ExactPeriodicity()))
    ax.plot(grid.x / a, solution.shear[0, :, 0] / (mu * p_hertz), label=f"Q = {share:g} mu P")
    stick = np.count_nonzero(solution.stick) * grid.cell[0] / (2 * a)
    print(f"Q = {share:g} mu P: stick zone {stick:.3f} a, closed form {np.sqrt(1 - share):.3f} a")
    assert abs(stick - np.sqrt(1 - share)) < 2 * grid.cell[0] / a
ax.set(xlabel="across / a", ylabel="shear / (mu p_H)")
ax.legend()
