"""
From the film to asperities
===========================

The speed of a rough line contact is reduced. At first a film of oil separates the surfaces; then asperities carry more and more of the load on a
boundary film of 3 nm, and the friction rises to that of the asperities: a Stribeck curve. The ridges lie across the motion, in plane strain: all oil
has to pass them, so that the change from film to contact takes a small range of speeds.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactstudy as cs

steel = cs.HalfSpace(youngs_modulus=210e9, poisson_ratio=0.3)
oil = cs.Lubricant(viscosity=0.04, pressure_viscosity=1.5e-8, shear=cs.Eyring(5e6))
boundary = cs.Boundary(film=3e-9, coefficient=0.12)
ridges = tuple(
    cs.Waviness(height, across=wave, phase=phase)
    for height, wave, phase in ((2e-8, 5e-5, 0.3), (1.2e-8, 3.1e-5, 1.1), (0.8e-8, 1.7e-5, 2.0))
)


def case_at(speed):
    motion = cs.Lubrication(oil, mean_speed=speed, slide_roll_ratio=0.1, boundary=boundary)
    return cs.Scene(cs.LineLoad(1e5), (steel, steel), (cs.Cylinder(0.01), *ridges), lubrication=motion)


# %%
# Twenty speeds downwards, each from the film of the one before.

grid = cs.Grid((480, 1), (6.3e-4, 1e-3))
speeds = np.geomspace(0.5, 1e-4, 20)
contacts, last = [], None
for speed in speeds:
    contact = cs.solve(case_at(speed), grid, start=last)
    contacts.append(contact)
    last = contact
converged = [one.status is not cs.Status.FILM_NOT_CONVERGED for one in contacts]
fraction = np.array([one.contact_load_fraction for one in contacts])
friction = np.array([one.friction for one in contacts])
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
left.semilogx(speeds[converged], friction[converged], "o-")
left.set(xlabel="mean speed [m/s]", ylabel="friction at 10 % sliding", ylim=(0, 0.13))
right.semilogx(speeds[converged], fraction[converged], "o-", color="#D55E00")
right.set(xlabel="mean speed [m/s]", ylabel="fraction of the load on asperities")
print(f"{sum(converged)} of {len(speeds)} speeds, fractions from {fraction.min():.2f} to {fraction.max():.2f}")
assert sum(converged) >= 18
assert fraction[0] == 0
assert fraction[-1] > 0.99
assert abs(friction[-1] / 0.12 - 1) < 0.01

# %%
# Pressure of the oil and of the asperities, where both carry load.

both = contacts[int(np.argmin(np.abs(fraction - 0.5)))]
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
x = grid.x * 1e3
axes.plot(x, both.lubricant_pressure[:, 0] / 1e9, label="oil")
axes.plot(x, both.contact_pressure[:, 0] / 1e9, label="asperities")
axes.set(xlabel="across [mm]", ylabel="pressure [GPa]", xlim=(-0.15, 0.15))
axes.legend()
print(both)
assert both.film.min() >= 3e-9 * (1 - 1e-6)

# %%
# Roughness that varies along the length lets oil flow around asperities: the load passes from oil to asperities over a wide range of speeds. On
# 256 x 64 cells all twenty speeds converge, each from the film of the one before.

rough = cs.Roughness(rms=5e-8, hurst=0.8, roll_off=5e-5, cut_off=2e-5, seed=1)
cylinder, roughness_grid = cs.Cylinder(0.01), cs.Grid((256, 64), (6.3e-4, 2.1e-4))
boundary_of_additives = cs.Boundary(film=1e-8, coefficient=0.12)
speeds, contacts, last = np.geomspace(0.5, 1e-3, 20), [], None
for speed in speeds:
    motion = cs.Lubrication(oil, mean_speed=speed, slide_roll_ratio=0.1, boundary=boundary_of_additives)
    scene = cs.Scene(cs.LineLoad(1e5), (steel, steel), (cylinder, rough), lubrication=motion)
    last = cs.solve(scene, roughness_grid, start=last)
    contacts.append(last)
fraction = np.array([one.contact_load_fraction for one in contacts])
friction = np.array([one.friction for one in contacts])
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
left.semilogx(speeds, friction, "o-")
left.set(xlabel="mean speed [m/s]", ylabel="friction at 10 % sliding", ylim=(0, 0.13))
right.semilogx(speeds, fraction, "o-", color="#D55E00")
right.set(xlabel="mean speed [m/s]", ylabel="fraction of the load on asperities")
print(", ".join(f"{one:.3f}" for one in fraction))
assert all(one.status is not cs.Status.FILM_NOT_CONVERGED for one in contacts)
assert fraction[0] == 0
assert (np.diff(fraction) >= 0).all()
assert np.count_nonzero((fraction > 0.05) & (fraction < 0.9)) >= 4
assert abs(fraction[-1] - 0.992) < 2e-3
