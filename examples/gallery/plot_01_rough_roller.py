"""
A rough roller with a profiled end
==================================

A roller of 1 mm length, 10 mm radius, with Lundberg's profile and self-affine roughness of 50 nm, pressed on a plate with
100 N/mm. The roller ends inside the grid, so both axes are free.
"""

import numpy as np

import contactstudy as cs

steel = cs.HalfSpace(youngs_modulus=210e9, poisson_ratio=0.3)
length = 1e-3
scene = cs.Scene(
    load=cs.LineLoad(1e5),
    solids=(steel, steel),
    shapes=(
        cs.Cylinder(radius=0.01),
        cs.LundbergProfile(amplitude=2.76e-7, end_drop=1.26e-6, length=length),
        cs.Roughness(
            rms=5e-8,
            hurst=0.8,
            roll_off=1e-4,
            cut_off=1.5e-5,
            peklenik=0.5,
            extent=(length, length),
        ),
    ),
)
grid = cs.Grid(cells=(96, 300), extent=(3.2e-4, length))
solution = cs.solve(scene.problem(grid, cs.ZeroPadding()))
print(repr(solution))

# %%
# The picture of a solution: pressure from above, along and across, and the gap.

figure = solution.plot()
figure

# %%
# The pressure carries the load, and roughness raises the highest pressure well above Hertz's.

carried = solution.pressure.sum() * grid.cell_area
print(f"load carried: {carried:.6g} N of {1e5 * length:.6g} N")
assert np.isclose(carried, 1e5 * length, rtol=1e-7)
share = np.mean(solution.pressure > 0) * grid.extent[0] / (2 * scene.hertz.half_width)
print(f"contact area over Hertz's: {share:.2f}")
assert solution.pressure.max() > 1.5 * scene.hertz.peak_pressure
