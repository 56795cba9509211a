from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.io.scene_files.scene_schema import materials

EXAMPLES = Path(__file__).parents[3] / "examples"
GOOD = """
hardness = "2.5 GPa"
[load]
per_length = "100 N/mm"
[[solids]]
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
[[solids]]
youngs_modulus = inf
poisson_ratio = 0.25
[[shapes]]
kind = "Cylinder"
radius = "10 mm"
[[shapes]]
kind = "Roughness"
rms = {slope = 0.01}
hurst = 0.8
roll_off = "0.1 mm"
cut_off = "30 um"
extent = ["0.4 mm", "0.4 mm"]
[[shapes]]
kind = "Texture"
pitch = ["50 um", "50 um"]
feature = {kind = "Dimple", depth = "0.1 um", diameter = "20 um", profile = "cosine"}
[grid]
cells = [64, 32]
extent = ["0.4 mm", "0.4 mm"]
[padding]
kind = "Superposition"
images = 3
[solve]
tolerance = 1e-6
solver = "PolonskyKeer"
precision = "single"
"""

WAVY = """
[load]
pressure = "20 MPa"
[[solids]]
material = "steel"
[[solids]]
youngs_modulus = inf
poisson_ratio = 0.3
[[shapes]]
kind = "Waviness"
amplitude = "0.1 um"
across = "1 mm"
[grid]
cells = [128, 1]
extent = ["1 mm", "1 mm"]
"""
RANDOM = '"Roughness"\nrms = 1e-7\nhurst = 0.8\nroll_off = 1e-4\ncut_off = 1e-5\n'
ROLLER = """
[load]
total = "2 kN"
[[solids]]
material = "steel"
[[solids]]
material = "100cr6"
poisson_ratio = 0.28
[[shapes]]
kind = "Cylinder"
radius = "10 mm"
"""
OF_CYLINDER = '"Cylinder"\nradius = "10 mm"'


def read(text: str, folder: Path) -> cs.SceneFile:
    path = folder / "scene.toml"
    path.write_text(text, encoding="utf-8")
    return cs.read_scene(path)


def test_what_a_file_gives_in_vain_is_refused(tmp_path: Path) -> None:
    found = read(GOOD, tmp_path)
    in_vain = replace(found, time_steps=cs.TimeSteps(end=1.0))
    for verb in (in_vain.plan, in_vain.solve):
        with pytest.raises(cs.InvalidInput, match=r"^(plan|solve)\.times is .*\.$"):
            verb()
    assert found.plan().padding == cs.Superposition(3)


def test_what_a_file_leaves_open_is_planned_for_its_error(tmp_path: Path) -> None:
    found = read((EXAMPLES / "smooth.toml").read_text(encoding="utf-8"), tmp_path)
    planned = found.plan()
    assert planned.dimension == 1
    assert planned.error <= 1e-4
    assert found.solve().met
    coarser = replace(found.plan_settings, error=1e-2)
    assert replace(found, plan_settings=coarser).plan().grid.cells[0] < planned.grid.cells[0]


WRONG = (
    (GOOD, '"10 mm"', '"10 N"', "shapes[0].radius is '10 N': give a length, such as '10 mm'"),
    (GOOD, "radius", "radus", "shapes[0]: unknown key 'radus': did you mean 'radius'."),
    (GOOD, "radius", "diameter", "shapes[0]: unknown key 'diameter': did you mean 'radius', half of it."),
    (GOOD, '"Cylinder"', '"Cylindr"', "shapes[0]: its kind is 'Cylindr': did you mean 'Cylinder'."),
    (GOOD, 'kind = "Cylinder"', "", "shapes[0]: it has no kind: choose from Cylinder, "),
    (GOOD, '[load]\nper_length = "100 N/mm"', "", "load: it is missing: give a table with a kind, one of LineLoad, "),
    (
        GOOD,
        '[load]\nper_length = "100 N/mm"',
        'load = "100 N/mm"',
        "load is '100 N/mm': give it as load.per_length.",
    ),
    (GOOD, "[grid]", "[[grid]]", "}]: write the name of this table in single brackets"),
    (
        GOOD,
        "[[shapes]]",
        '[[outputs]]\nkind = "SubsurfaceStress"\ndepths = 1\n[[shapes]]',
        "outputs[0].depths is 1: give [a length of at least 0, ...], or 'auto'.",
    ),
    (GOOD, '"Cylinder"', f'"{"x" * 99}"', f"shapes[0]: its kind is '{'x' * 56}...: choose from"),
    (GOOD, '"Cylinder"', '"MeasuredSurface"', "shapes[0].file: it is missing: give a text, such as 'surface.csv'."),
    (
        ROLLER,
        "total",
        'kind = "TotalLoad"\nper_length',
        "load: 'per_length' is a key of LineLoad: give that kind, or choose from total",
    ),
    (GOOD, "[[solids]]", "[[a]]", "solids: it is missing: give 2 tables, each below its name in double brackets."),
    (GOOD, "rms = {slope = 0.01}", "", "shapes[1].rms: it is missing: give a length"),
    (GOOD, "[load]", '[load]\ntotal = "1 kN"', "load: 'total' is a key of TotalLoad: give that kind, or"),
    (GOOD, '["50 um", "50 um"]', '["50 um"]', "shapes[2].pitch is ['50 um']: give [a length above 0"),
    (GOOD, "[load]", "[load", "is not valid TOML: Expected ']' at the end"),
    (GOOD, '"100 N/mm"', "100 N/mm # on the roller", 'write per_length = "100 N/mm"'),
    (ROLLER, "2 kN", "100 N/mm", "load.total is '100 N/mm': give a load, such as '2 kN'"),
    (ROLLER, '"steel"', '"stel"', "solids[0].material is 'stel': did you mean 'steel'"),
    (ROLLER, '"steel"', '"steel"\nkind = "CoatedHalfSpace"', "solids[0].material is 'steel', and a CoatedHalfSpace"),
    (ROLLER, "[[shapes]]", "[shapes]", "}: give tables, each below its name in double brackets"),
    (ROLLER, OF_CYLINDER, '"Crown"', "give its radius, or its end_drop and length"),
    (WAVY, WAVY[WAVY.index('"Waviness"') :], RANDOM, "give a [grid], of whole waves"),
    (
        WAVY,
        "[grid]",
        "[plan]\nperiod = true\n[grid]",
        "plan.period is True: give a length above 0, such as '10 mm', or a number in m.",
    ),
    (WAVY, "[grid]", "[[shapes]]\nkind = 'Cylinder'\nradius = 1\n[grid]", "a shape is curved: give per_length"),
)


def test_what_is_wrong_is_named_by_its_key(tmp_path: Path) -> None:
    for text, good, bad, said in WRONG:
        with pytest.raises(cs.InvalidInput) as raised:
            read(text.replace(good, bad), tmp_path)
        assert said in str(raised.value)
        assert "scene.toml" in str(raised.value)


def test_either_axis_has_its_padding(tmp_path: Path) -> None:
    text = GOOD.replace('[padding]\nkind = "Superposition"\nimages = 3\n', "")
    both = 'padding = "ExactPeriodicity"\npadding_across = "ZeroPadding"\n' + text
    assert read(both, tmp_path).padding == (cs.ZeroPadding(), cs.ExactPeriodicity())
    with pytest.raises(cs.InvalidInput, match="padding_across is given without padding"):
        read('padding_across = "ZeroPadding"\n' + text, tmp_path)


def test_a_number_in_an_unlikely_unit_is_asked_about(tmp_path: Path) -> None:
    for good, bare, said in (
        ('"10 mm"', "10", "shapes[0].radius is 10, which is 10 m: was '10 mm' meant?"),
        ('"100 N/mm"', "100", "load.per_length is 100, which is 100 N/m: was '100 N/mm' meant?"),
    ):
        assert said in read(GOOD.replace(good, bare, 1), tmp_path).doubts
    assert not read(GOOD.replace('"10 mm"', "0.01"), tmp_path).doubts


def test_a_mean_pressure_on_a_flat_is_periodic_both_ways_as_westergaard_has_it(tmp_path: Path) -> None:
    described = read(WAVY, tmp_path)
    assert described.padding == (cs.ExactPeriodicity(), cs.ExactPeriodicity())
    assert described.scene.load == cs.LineLoad(2e4)
    assert read(WAVY[: WAVY.index("[grid]")], tmp_path).grid.extent == (1e-3, 1e-3)  # one period
    exact = cs.analytic.Westergaard(2e7, 1e-7, 1e-3, described.scene.contact_modulus)
    assert described.solve().pressure.max() == pytest.approx(exact.peak_pressure, rel=1e-2)
    pressed = read(WAVY.replace('"20 MPa"', '"200 MPa"'), tmp_path).solve().quantities
    assert pressed["contact_fraction"].value == 1
    assert "half_width" not in pressed
    [doubt] = read('padding = "ExactPeriodicity"\n' + WAVY, tmp_path).doubts
    assert "leaves the surface free across" in doubt


SOLIDS = '[[solids]]\nmaterial = "steel"\n[[solids]]\nmaterial = "steel"\n'
SWINGING = '[load]\nmean_load = 1e5\namplitude = 1e4\nfrequency = "3000 rpm"\n' + SOLIDS
RING = (
    '[load]\nper_length = 1e5\n[wear]\ncoefficient = "1e-6 mm3/(N m)"\nspeed = "0.5 m/s"\ncircumference = "100 mm"\n'
    '[friction]\nkind = "Sliding"\ncoefficient = 0.1\nstanding = 1\n' + SOLIDS
)


def test_times_are_counted_in_cycles_and_revolutions(tmp_path: Path) -> None:
    for scene, end, seconds in ((SWINGING, "1e3 cycles", 20.0), (RING, "500 rev", 100.0), (RING, "2 h", 7200.0)):
        assert read(f'{scene}[time_steps]\nend = "{end}"', tmp_path).time_steps.end == pytest.approx(seconds)
    with pytest.raises(cs.InvalidInput, match=r"give wear\.circumference, and a speed"):
        read(f'{SWINGING}[time_steps]\nend = "5 rev"', tmp_path)


def test_a_file_with_a_byte_order_mark_is_read_and_one_that_is_no_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(GOOD, encoding="utf-8-sig")
    assert cs.read_scene(path).scene == read(GOOD, tmp_path).scene
    for content in (b"\xff\xfe", b"a = " + b"[" * 5000):
        path.write_bytes(content)
        with pytest.raises(cs.InvalidInput, match=r"scene\.toml"):
            cs.read_scene(path)
    with pytest.raises(cs.InvalidInput, match="cannot be read"):
        cs.read_scene(tmp_path / "none.toml")


def test_every_material_has_a_source() -> None:
    for entry in materials().values():
        assert len(entry.source) > 20, entry.name
        assert cs.material(entry.name) == cs.HalfSpace(
            entry.youngs_modulus, entry.poisson_ratio, entry.yield_stress, entry.hardness
        )
        assert 1.3 * entry.yield_stress < entry.hardness or entry.yield_stress == inf


LENGTH = '[[shapes]]\nkind = "FiniteLength"\nlength = "8 mm"\n'
LINE = ROLLER.replace('total = "2 kN"', 'per_length = "100 N/mm"')
STEEL, PROFILE = 'material = "steel"', '[[shapes]]\nkind = "LundbergProfile"\nlength = "8 mm"\n'
COAT = 'kind = "CoatedHalfSpace"\nthickness = "2 um"\ncoating.material = "DLC"\nsubstrate.material = "steel"'
COATED = cs.CoatedHalfSpace(cs.material("ta-C:H"), 2e-6, cs.material("steel"))
SOFT = 'kind = "ViscoelasticHalfSpace"\nequilibrium_modulus = "1 MPa"\npoisson_ratio = 0.4\nrelaxation = '
HARD = 'youngs_modulus = 2e11\npoisson_ratio = 0.3\nhardness = "300 HV"'
OF_BOTH = 1 / (cs.material("steel").compliance + (1 - 0.28**2) / 207e9)
OTHER = replace(cs.material("100Cr6"), poisson_ratio=0.28)
GIVEN = (
    (ROLLER + LENGTH, "largest_load", 2e3 / 8e-3),
    (ROLLER + '[plan]\nperiod = "4 mm"\n', "largest_load", 2e3 / 4e-3),
    (ROLLER + LENGTH + '[plan]\nperiod = "9 mm"\n', "largest_load", 2e3 / 8e-3),
    (LINE, "solids", (cs.material("steel"), OTHER)),
    (LINE.replace(STEEL, COAT), "solids", (COATED, OTHER)),
    (LINE.replace(STEEL, 'kind = "ElasticPlasticHalfSpace"\nmaterial = "bronze"'), "solids.0",
     cs.ElasticPlasticHalfSpace(113e9, 0.3, 0.14e9)),
    (LINE.replace(STEEL, SOFT + '[["1.5 MPa", "200 ms"], ["0.5 MPa", 3]]'), "solids.0",
     cs.ViscoelasticHalfSpace(1e6, 0.4, ((1.5e6, 0.2), (5e5, 3.0)))),
    (LINE.replace(STEEL, STEEL + '\nfree_faces = "10 mm"'), "solids.0", cs.FreeFaces(cs.material("steel"), 0.01)),
    (LINE.replace(STEEL, HARD), "solids.0.yield_stress", pytest.approx(100 * 9.80665e6)),  # a third
    (LINE + PROFILE + 'for_load = "200 N/mm"', "shapes.1",
     cs.LundbergProfile.for_load(2e5, contact_modulus=OF_BOTH, radius=0.01, length=8e-3)),
    (LINE + PROFILE + 'iso_16281_diameter = "10 mm"', "shapes.1", cs.LundbergProfile.iso_16281(0.01, 8e-3)),
    (LINE + PROFILE + 'amplitude = "1 um"\nend_drop = "9 um"', "shapes.1", cs.LundbergProfile(1e-6, 9e-6, 8e-3)),
    (LINE + '[[shapes]]\nkind = "Crown"\nend_drop = "5 um"\nlength = "8 mm"', "shapes.1", cs.Crown.of_drop(5e-6, 8e-3)),
)  # fmt: skip


def test_a_value_may_be_given_in_its_units_by_a_material_or_by_what_it_is_for(tmp_path: Path) -> None:
    for text, field, value in GIVEN:
        found: object = read(text, tmp_path).scene
        for name in field.split("."):
            found = found[int(name)] if name.isdigit() else getattr(found, name)  # type: ignore[index]
        assert found == value


def test_varied_fields_are_kept_in_groups(tmp_path: Path) -> None:
    table = read(f'{ROLLER}{LENGTH}[vary]\nload.total = "1:4:4 kN"\nplan.error = [0.1]\n', tmp_path)
    assert table.vary == ({"load.total": "1:4:4 kN"}, {"plan.error": [0.1]})
    groups = '[[vary]]\nload.total = "1,2 kN"\nplan.error = [0.1, 0.2]\n'
    assert read(ROLLER + LENGTH + groups, tmp_path).vary == ({"load.total": "1,2 kN", "plan.error": [0.1, 0.2]},)
    with pytest.raises(cs.InvalidInput, match="vary is 3: give a table"):
        read(f"vary = 3\n{ROLLER}{LENGTH}", tmp_path)


def test_a_measured_surface_is_read_from_beside_the_scene_and_written_back(tmp_path: Path) -> None:
    heights = np.arange(72.0).reshape(8, 9) ** 2
    np.savetxt(tmp_path / "heights.csv", heights, delimiter=",")
    surface = '[[shapes]]\nkind = "MeasuredSurface"\nfile = "heights.csv"\nextent = ["1 mm", "2 mm"]\nunit = "nm"\n'
    found = read(LINE + surface + 'trend = "none"\n', tmp_path)
    expected = cs.MeasuredSurface(heights * 1e-9, (1e-3, 2e-3), seam=cs.Tapered())
    assert found.scene.shapes[1] == expected
    cs.write_scene(found, tmp_path / "again.toml")
    assert cs.read_scene(tmp_path / "again.toml").scene == found.scene
    with pytest.raises(cs.InvalidInput, match=r"not-there\.csv.*give the path of an existing file"):
        read(LINE + surface.replace("heights", "not-there"), tmp_path)
    # a flat repeats across by the rule of its length
    flat = f"load.per_length = 1e5\n{SOLIDS}{surface}"
    for seam, across in (("", cs.Tapered()), ('seam = "Mirrored"', cs.Mirrored())):
        assert read(flat + seam, tmp_path).scene.shapes[0].seam_across == across


def test_a_file_requests_the_errors_of_some_numbers(tmp_path: Path) -> None:
    text = LINE.lstrip().replace("[load]", "plan.error = {peak_pressure = '2 %', half_width = 0.05}\n[load]")
    described = read(text, tmp_path)
    assert described.plan_settings.error == {"peak_pressure": 0.02, "half_width": 0.05}
    cs.write_scene(described, tmp_path / "again.toml")
    assert cs.read_scene(tmp_path / "again.toml") == described
    in_words = text.replace("{peak_pressure = '2 %', half_width = 0.05}", "'peak_pressure = 2 %, half_width = 0.05'")
    assert read(in_words, tmp_path) == described
    answer = described.solve()
    assert answer.met
    assert list(answer.judged) == ["peak_pressure", "half_width"]
    with pytest.raises(cs.InvalidInput, match=r"plan.error.*'much'"):
        read(text.replace("'2 %'", "'much'"), tmp_path)
    with pytest.raises(cs.InvalidInput, match=r"plan.error is 'much': give a relative error, such as '1 %'"):
        read(LINE.lstrip().replace("[load]", "plan.error = 'much'\n[load]"), tmp_path)
