"""
Tractive rolling
================

A driving roller: the surfaces stick where they enter the contact and slip before they leave it. Traction grows with creepage up to the
friction limit (Carter).
"""

import matplotlib.pyplot as plt
import numpy as np

import contactstudy as cs

steel = cs.HalfSpace(youngs_modulus=210e9, poisson_ratio=0.3)
mu, radius = 0.3, 0.01
smooth = cs.Scene(cs.LineLoad(1e5), (steel, steel), (cs.Cylinder(radius),))
a, p_hertz = smooth.hertz.half_width, smooth.hertz.peak_pressure
grid = cs.Grid(cells=(512, 1), extent=(2.4 * a, a))
saturation = mu * a / radius  # creepage at which all of the contact slides

# %%
# Shear traction at three creepages, and the traction curve.

figure, (left, right) = plt.subplots(1, 2, layout="constrained", figsize=(9, 3.6))
parts = (0.1, 0.3, 0.5, 0.7, 0.9)
traction = []
for part in parts:
    friction = cs.TractiveRolling(coefficient=mu, longitudinal=part * saturation, speed=2.0)
    scene = cs.Scene(smooth.load, smooth.solids, smooth.shapes, friction=friction)
    solution = cs.solve(scene, grid, cs.ExactPeriodicity())
    left.plot(grid.x / a, solution.shear[0, :, 0] / (mu * p_hertz), label=f"{part:g}")
    numbers = solution.quantities
    traction.append(numbers["traction_coefficient"].value)
    carter = mu * (1 - (1 - part) ** 2)
    print(
        f"creepage {part:g} of saturation: traction {traction[-1]:.4f}, Carter {carter:.4f}, "
        f"power {numbers['frictional_power'].value:.1f} W/m"
    )
    assert abs(traction[-1] - carter) < 1e-3 * mu
left.set(xlabel="across / a, rolling to the right", ylabel="shear / (mu p_H)")
left.legend(title="creepage / saturation")
curve = np.linspace(0, 1)
right.plot(curve, mu * (1 - (1 - curve) ** 2), ":", color="black", label="Carter")
right.plot(parts, traction, "o", label="512 cells")
right.set(xlabel="creepage / saturation", ylabel="traction coefficient")
right.legend()
