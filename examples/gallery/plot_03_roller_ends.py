"""
The end of a roller and its profile
===================================

A straight roller on a longer plate has a pressure peak at its ends, infinite in theory. A crown or Lundberg's
logarithmic profile removes it.
"""

import matplotlib.pyplot as plt

import contactstudy as cs

steel = cs.HalfSpace(youngs_modulus=210e9, poisson_ratio=0.3)
cylinder, length = cs.Cylinder(radius=0.01), 1e-3
smooth = cs.Scene(cs.LineLoad(1e5), (steel, steel), (cylinder,))
profiles = {
    "straight": cs.FiniteLength(length),
    "crown": cs.Crown.of_drop(1.5e-6, length),
    "Lundberg": cs.LundbergProfile.for_load(
        1e5, contact_modulus=smooth.contact_modulus, radius=0.01, length=length
    ),
}
grid = cs.Grid(cells=(64, 256), extent=(3.2e-4, 1.05 * length))

figure, ax = plt.subplots(layout="constrained")
highest = {}
for name, profile in profiles.items():
    shapes = (
        (cylinder, profile) if name == "straight" else (cylinder, profile, cs.FiniteLength(length))
    )
    scene = cs.Scene(cs.LineLoad(1e5 * length / grid.period), (steel, steel), shapes)
    solution = cs.solve(scene.problem(grid, cs.ZeroPadding()))
    middle = solution.pressure[grid.cells[0] // 2]
    highest[name] = solution.pressure.max() / smooth.hertz.peak_pressure
    ax.plot(grid.y * 1e3, middle / 1e6, label=name)
ax.axhline(
    smooth.hertz.peak_pressure / 1e6, linestyle=":", color="black", label="Hertz, infinitely long"
)
ax.set(xlabel="along the roller [mm]", ylabel="pressure on the axis [MPa]")
ax.legend()

# %%
# The straight roller's peak depends on the grid, since it is infinite; the profiled ones have none.

for name, value in highest.items():
    print(f"{name}: highest pressure {value:.2f} p_H")
assert highest["straight"] > 1.5
assert highest["Lundberg"] < highest["crown"] < highest["straight"]
