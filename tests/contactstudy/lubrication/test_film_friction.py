from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.lubrication import film_friction
from contactstudy.lubrication.film_friction import moving_source, thermal_reduction
from contactstudy.lubrication.steady_film import solve_lubricated
from tests.contactstudy.lubrication.scenes import STEEL, by_moes, grid, with_motion

OF_STEEL = cs.FilmHeat()


def heated(slide: float = 0.5, heat: cs.FilmHeat | None = OF_STEEL, **laws: object) -> cs.Scene:
    """A film at M = 20, L = 5 that slides."""
    scene = by_moes(20, 5, **({"shear": cs.Eyring(5e6)} | laws))
    return with_motion(scene, slide_roll_ratio=slide, thermal=heat)


@pytest.mark.parametrize("peclet", [20.0, 200.0])
def test_a_fast_even_source_heats_as_blok_and_jaeger_have_it(peclet: float) -> None:
    """At the trailing edge ``2 q / k sqrt(kappa l / (pi u))``, which Jaeger's law reaches as Peclet numbers grow."""
    body, cells = cs.ThermalBody(), cs.Grid((400, 1), (2e-3, 1e-3))
    band = np.abs(cells.x) < 1e-4
    diffusivity = body.conductivity / body.heat_capacity
    speed = peclet * 2 * diffusivity / 1e-4
    rise = moving_source(cells, body, speed) @ band
    largest = 2 / body.conductivity * sqrt(diffusivity * 2e-4 / (pi * speed))
    assert rise.max() == pytest.approx(largest, rel=1.5 / peclet)
    # far downstream all heat has passed: the rise of a line source, 1 / sqrt(x)
    far = cells.x[-1]
    assert rise[-1] == pytest.approx(2e-4 / sqrt(pi * body.conductivity * body.heat_capacity * speed * far), rel=0.02)


def test_the_friction_is_isothermal_with_perfect_conduction_or_without_thinning() -> None:
    cold = solve_lubricated(heated(heat=None), grid(160, 4.5))
    assert cold.temperatures is None
    perfect = cs.FilmHeat(0.04, 1e12, cs.ThermalBody(1e12), cs.ThermalBody(1e12))
    for heat in (perfect, cs.FilmHeat(temperature_viscosity=0.0)):
        hot = solve_lubricated(heated(heat=heat), grid(160, 4.5))
        assert hot.friction == pytest.approx(cold.friction, rel=1e-6)


def test_a_heated_film_on_asperities_has_no_friction_in_pure_rolling() -> None:
    rolling = heated(slide=0.0)
    boundary = cs.Boundary(1.2 * solve_lubricated(rolling, grid(160, 4.5)).minimum_film, 0.1)
    contact = solve_lubricated(with_motion(rolling, boundary=boundary), grid(160, 4.5))
    assert contact.contact_load_fraction > 0
    assert contact.friction == contact.flash_temperature == 0


def test_traction_rises_with_sliding_and_falls_again_as_the_film_frictions_up() -> None:
    law = {"viscosity_law": cs.Roelands(0.6, reference_pressure=2.63e8)}
    hot = [solve_lubricated(_at(heated(slide, **law), 40.0), grid(160, 8)) for slide in (0.02, 0.2, 1.9)]
    cold = solve_lubricated(_at(heated(1.9, heat=None, **law), 40.0), grid(160, 8))
    small, middle, large = (contact.friction for contact in hot)
    assert small < middle
    assert large < 0.95 * middle < 0.95 * cold.friction
    assert hot[0].flash_temperature < hot[1].flash_temperature < hot[2].flash_temperature


@pytest.mark.parametrize("pressure", [1e5, 1e9])
def test_viscosity_falls_with_temperature_as_measured_in_a_mineral_oil(pressure: float) -> None:
    """M100, viscosimeter of Mann, fitted by Arana, Larranaga & Ulacia (2019), eq. 30 and table 3; supply at 60 C."""

    def log_viscosity(temperature: float, pressure: float) -> float:
        stiffness = -2.28e7 + 2.26e5 * temperature
        growth = -0.0682 + 2.768e-4 * temperature
        at_rest = np.log(86.86e-6) + 890 / (temperature - 182)
        return float(at_rest + pressure / (stiffness + growth * pressure))

    supply = 333.15
    heat = cs.FilmHeat(890 / (supply - 182) ** 2, supply_temperature=supply)
    for rise in (1.0, 20.0, 50.0):
        thinning = heat.thinning(np.array(rise), np.exp(log_viscosity(supply, 0.0)))
        fall = cs.Roelands(0.602).temperature_factor(np.array(pressure)) * thinning
        measured = log_viscosity(supply + rise, pressure) - log_viscosity(supply, pressure)
        assert fall == pytest.approx(measured, rel=0.11)


def test_a_starved_film_is_as_thick_as_its_supply_with_heat_too() -> None:
    """The inlet's factor is that of a flooded inlet; a supply just below that film leaves a part of it."""
    scene = _at(heated(1e-3), 20.0)
    flooded = solve_lubricated(scene, grid(160, 8))
    factors = []
    for fraction in (0.3, 0.97, 3.0):
        layer = fraction * flooded.flow / flooded.mean_speed
        starved = solve_lubricated(with_motion(scene, supply=layer), grid(160, 8))
        factors.append(starved.temperatures.reduction)
    assert factors[0] == 1
    assert factors[2] == flooded.temperatures.reduction <= factors[1] < 1


def test_a_film_whose_passes_end_early_keeps_the_temperature_of_its_shear(monkeypatch: pytest.MonkeyPatch) -> None:
    converged = solve_lubricated(heated(0.005), grid(160, 4.5)).temperatures
    monkeypatch.setattr(film_friction, "MAX_PASSES", 1)
    early = solve_lubricated(heated(0.005), grid(160, 4.5)).temperatures
    assert early.residual > film_friction.NEW_START
    assert early.film.max() >= converged.film.max() > 0


def test_a_coating_conducts_heat_between_its_own_values_and_those_of_the_substrate() -> None:
    """Of the substrate's material, without thickness or endlessly thick it is one material; glass on steel is warmer."""
    cells, steel, glass = cs.Grid((160, 1), (8e-4, 1e-3)), cs.ThermalBody(), cs.ThermalBody(1.1, 2e6)
    band = np.abs(cells.x) < 1e-4

    def rise(coating: cs.ThermalBody, thickness: float, speed: float = 0.5) -> np.ndarray:
        coated = cs.ThermalBody(steel.conductivity, steel.heat_capacity, coating)
        return moving_source(cells, coated, speed, thickness) @ band

    plain, soft = (moving_source(cells, body, 0.5) @ band for body in (steel, glass))
    assert rise(steel, 1e-6) == pytest.approx(plain, rel=1e-6)
    assert rise(glass, 1e-12) == pytest.approx(plain, rel=1e-3, abs=1e-3 * plain.max())
    assert rise(glass, 1e-3) == pytest.approx(soft, rel=0.03, abs=0.03 * soft.max())
    # a layer thinner than heat diffuses is a resistance, d / k
    assert rise(glass, 1e-8)[80] - plain[80] == pytest.approx(1e-8 / 1.1, rel=0.05)
    assert rise(glass, 1e-6, -0.5) == pytest.approx(rise(glass, 1e-6)[::-1], rel=1e-9)


def test_what_conducts_is_named_for_bodies_other_than_steel() -> None:
    with pytest.raises(cs.InvalidInput, match=r"FilmHeat.first is None, .* Scene.solids\[0\]"):
        replace(heated(), solids=(cs.HalfSpace(310e9, 0.26), STEEL))


def test_equal_bodies_share_the_heat_evenly_at_equal_speeds_and_else_the_slower_is_hotter() -> None:
    rolling, slow, fast = (solve_lubricated(heated(slide), grid(160, 4.5)) for slide in (0.0, 1e-3, 1.0))
    assert rolling.flash_temperature == rolling.film_temperature == 0
    first, second = slow.temperatures.surface
    assert first == pytest.approx(second, rel=5e-3, abs=1e-3 * float(first.max()))
    assert fast.temperatures.surface[1].max() > fast.temperatures.surface[0].max()


def test_the_film_is_hotter_than_its_surfaces_by_conduction_over_its_heated_thickness() -> None:
    """Heat tau du, uniform over the thickness h, has a mean rise of tau du h / (12 k) above that of the surfaces."""
    boundary = 4.6e-7
    contact = solve_lubricated(with_motion(_at(heated(1.0), 20.0), boundary=cs.Boundary(boundary)), grid(160, 6))
    temperatures = contact.temperatures
    assert temperatures.reduction < 0.95
    thickness = np.maximum(temperatures.reduction * contact.film, boundary)
    above = np.abs(contact.shear) * contact.sliding_speed * thickness / (12 * OF_STEEL.conductivity)
    rise = temperatures.film - temperatures.surface.mean(axis=0)
    # the surfaces slip by a part less where their shear grows
    assert rise == pytest.approx(above, abs=2e-3 * float(rise.max()))


def test_a_heated_inlet_thins_the_film_by_more_at_higher_speeds() -> None:
    slow, fast = (solve_lubricated(_at(heated(), factor), grid(160, 4.5)) for factor in (0.1, 20.0))
    assert 0 < fast.temperatures.reduction < slow.temperatures.reduction < 1
    assert thermal_reduction(slow.scales, cs.FilmHeat(0.0)) == 1


def test_an_inlet_beyond_the_range_of_its_factor_leaves_the_friction_without_a_bound() -> None:
    contact = cs.solve(_at(heated(), 400.0), grid(200, 30))
    assert contact.quantities["friction_coefficient"].bound == np.inf
    assert "thermal loading" in contact.quantities["flash_temperature"].reason


def test_temperatures_have_bounds() -> None:
    scene = heated(shear=cs.Carreau(5e6, 0.6))
    contact = cs.solve(scene, grid(200, 4.5))
    fine = solve_lubricated(scene, grid(800, 4.5))
    for name in ("flash_temperature", "film_temperature", "heated_film"):
        quantity = contact.quantities[name]
        assert abs(quantity.value - getattr(fine, name)) <= quantity.bound < np.inf


def test_carreau_thins_as_a_power_of_the_rate_and_not_at_all_at_rest() -> None:
    law, rates = cs.Carreau(1e6, 0.4), np.array([1e2, 1e10, 1e11])
    slow, fast, faster = law.stress(rates, np.zeros(3))
    assert slow == pytest.approx(1e2, rel=1e-6)
    assert faster / fast == pytest.approx(10**0.4, rel=1e-6)


def _at(scene: cs.Scene, factor: float) -> cs.Scene:
    """Return the scene at a multiple of its speed."""
    faster = factor * scene.lubrication.largest_speed
    return with_motion(scene, mean_speed=faster)
