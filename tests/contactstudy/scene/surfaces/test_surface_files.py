"""Files of surfaces as instruments, people and this program write them: one map, whose right numbers are known."""

import re
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs

# Heights [um] of 12 points across by 9 along, 2 um and 4 um apart; a row of a matrix runs along.
MAP = np.round(np.random.default_rng(3).normal(0, 0.3, (12, 9)), 4)
EXTENT = (24e-6, 36e-6)
SIZED: dict[str, Any] = {"unit": "um", "extent": EXTENT}


def matrix(separator: str = "\t", scale: float = 1.0, heights: Any = MAP, number: str = "%.4f") -> str:
    return "\n".join(separator.join(number % (scale * z) for z in row) for row in heights)


def columns(separator: str = ",", scales: tuple[float, float, float] = (1, 1, 1), jitter: float = 0.0) -> str:
    """Points, with positions in um off their grid by up to `jitter` steps, times a scale a column."""
    shifts = jitter * np.random.default_rng(0).uniform(-1, 1, (2, *MAP.shape))
    places = 2 * (np.arange(12)[:, None] + shifts[0]), 4 * (np.arange(9) + shifts[1])
    points = np.stack([*places, MAP], axis=-1).swapaxes(0, 1).reshape(-1, 3) * scales
    return "\n".join(separator.join(f"{value:.10f}" for value in point) for point in points)


def trace(title: str) -> str:
    return title + "\n" + "\n".join(f"{50.0 * n}\t{z}" for n, z in enumerate(MAP[:, 0]))


def surface(folder: Path, text: str | bytes, name: str = "map.txt", **keys: Any) -> cs.MeasuredSurface:
    data = text if isinstance(text, bytes) else text.encode()
    (folder / name).write_bytes(data)
    return cs.MeasuredSurface.read(folder / name, trend="none", **keys)


def assert_is_map(computed: cs.MeasuredSurface, heights: np.ndarray = MAP, extent: Any = EXTENT) -> None:
    np.testing.assert_allclose(computed.heights, heights * 1e-6, atol=1e-14)
    assert computed.extent == pytest.approx(extent, rel=1e-6)


GWYDDION = "# Channel: Topography\n# Width: 36.00 µm\n# Height: 24.00 µm\n# Value units: m\n"
IN_METRES = GWYDDION + matrix(scale=1e-6, number="%.4e")
SPREADSHEET = "XPixelSize;4,0;µm\nYPixelSize;2,0;µm\nHeight Unit;nm\n"
MARGINS = "\n".join(
    [";".join(["", *(f"{4 * j}" for j in range(9))])]
    + [";".join([f"{2 * i}", *(f"{z:.4f}" for z in row)]) for i, row in enumerate(MAP)]
)
# Whole numbers with a point between thousands.
THOUSANDS = re.sub(r"(?<=\d)(?=\d{3}\b)", ".", matrix(scale=1e4, number="%.0f"))
DECIMAL_COMMAS = "\n".join(f"{abs(z):.4f}".replace(".", ",") for z in MAP.ravel())


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("text", "unit"),
    [
        (IN_METRES, None),
        (GWYDDION.replace("Value units: m", "Value units: μm") + matrix(), None),
        ("ncols 9\nnrows 12\ndx 4 um\ndy 2 um\n" + matrix(" "), "um"),
        (SPREADSHEET + matrix(";", 1e3, number="%.1f").replace(".", ","), None),
        ("w=9 h=12\nScan size: 36 x 24 um\nheight conversion factor (-> m)=1e-9\n" + matrix(" ", 1e3), None),
        ("X[mm],Y[um],Z[nm]\n" + columns(scales=(1e-3, 1, 1e3)), None),
        ("x;y;z\n[um];[um];[um]\n" + columns(";").replace("\n", "\n\n"), None),
        (columns(" "), "um"),
        (MARGINS, "um"),
        ("nx: 9\nny: 12\nX spacing 4 um\nY spacing 2 um\nUnit: um\n" + matrix("\n"), None),
        ("Horizontal pixel size: 4 µm\nVertical pixel size: 2 µm\nZ resolution: 1 nm\nUnit: µm\n" + matrix(), None),
        ("Pixel size X/Y: 4 µm / 2 µm\nUnit: µm\n" + matrix(), None),
        ("Size (y, x): 24 µm, 36 µm\nUnit: µm\n" + matrix(), None),
        ("Objective: 50x\nX-Resolution (µm/px): 4,0\nY-Resolution (µm/px): 2\nUnit: µm\n" + matrix(), None),
        ("IMAGE SIZE: 36 µm by 24 µm\nFaktor: 0,001\nUnit: µm\n" + matrix(scale=1e3), None),
        ("Lateral calibration: 4 µm/px (X), 2 µm/px (Y)\nUnit: µm\n" + matrix(), None),
        ("Slow axis size: 24 µm\nFast axis size: 36 µm\nUnit: µm\n" + matrix(), None),
        ("Pixelabstand X: 4,0 µm\nPixelabstand Y: 2,0 µm\nEinheit: µm\n" + matrix(), None),
        ("FOV: 36 x 24 um\nZ sensitivity: 0.1 nm/count\nValue units: counts\n" + matrix(" ", 1e4, number="%.0f"), None),
        ("Pixel size: 4 x 2 µm\nOptical resolution: 0.4 µm\nbit2nm = 0.1\n" + matrix(" ", 1e4, number="%.0f"), None),
        ("X (in),Y (in),Z (µin)\n" + columns(scales=(1 / 25400, 1 / 25400, 1e3 / 25.4)), None),
        ("Sampling length 0.8 mm\nScale factor: 0.001\ndx = 4 um\ndy = 2 um\n" + matrix(scale=1e3), "um"),
    ],
)  # fmt: skip
def test_one_map_is_one_surface_by_its_content(tmp_path: Path, text: str, unit: str | None) -> None:
    for name in ("map.txt", "map.csv"):
        assert_is_map(surface(tmp_path, text, name, unit=unit))


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    "text",
    [
        matrix(","), "# heights\n" + matrix(";"), matrix(";").replace(".", ","), matrix("  ").replace(".", ","),
        "a,b,c\na\n" + matrix(","), matrix("\t").replace("\n", "\t\n") + "\t",
        "\n".join(f"{i};{row}" for i, row in enumerate(matrix(";").split("\n"))),  # rows that are counted
    ],
)  # fmt: skip
def test_rows_of_numbers_are_a_map_by_their_unit_and_extent(tmp_path: Path, text: str) -> None:
    assert_is_map(surface(tmp_path, text, **SIZED))


@pytest.mark.cases(100)
@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "latin-1"])
def test_a_heading_with_the_micro_sign_is_read_in_any_encoding(tmp_path: Path, encoding: str) -> None:
    text = "Höhe [µm]\r\n" + matrix(";").replace(".", ",").replace("-", "\u2212" if "utf" in encoding else "-")
    assert_is_map(surface(tmp_path, text.encode(encoding), extent=EXTENT))


@pytest.mark.cases(100)
@pytest.mark.parametrize("mark", ["-9999", "3.4028235e38", "-32768", "-inf", "no data", "#N/A", "", "***", "--", "7.5"])
def test_points_that_were_not_measured_are_missing(tmp_path: Path, mark: str) -> None:
    holed = matrix(";").split("\n")
    holed[4] = ";".join([mark, *holed[4].split(";")[1:]])
    text = "NODATA_value 7.5\n" * (mark == "7.5") + "\n".join(holed)
    computed = surface(tmp_path, text, missing=cs.HarmonicFill(), **SIZED)
    assert np.argwhere(np.isnan(computed.heights)).tolist() == [[4, 0]]
    assert "missing points: 1 (0.93%) filled by Laplace's equation" in computed.description


@pytest.mark.parametrize(("height", "cells"), [(-77.0, 2), (0.0, 30)])
def test_repeated_heights_are_refused_until_a_key_says_what_they_are(tmp_path: Path, height: float, cells: int) -> None:
    heights = MAP.copy()
    heights.flat[:cells] = height
    with pytest.raises(cs.InvalidInput, match=rf"{cells} points .* give invalid = {height:g}, or"):
        surface(tmp_path, matrix(heights=heights), **SIZED)
    masked = surface(tmp_path, matrix(heights=heights), invalid=height, missing=cs.HarmonicFill(0.5), **SIZED)
    assert np.isnan(masked.heights).sum() == cells
    assert_is_map(surface(tmp_path, matrix(heights=heights), sizes="confirmed", **SIZED), heights)


def test_a_flat_with_dimples_has_a_height_that_most_points_share(tmp_path: Path) -> None:
    heights = np.minimum(MAP - np.round(np.quantile(MAP, 0.3), 4), 0)
    assert_is_map(surface(tmp_path, matrix(heights=heights), **SIZED), heights)


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ({"unit": "mm", "extent": EXTENT}, r"heights of 1.\d+ mm over 36 µm: give unit and extent"),
        ({"unit": "um", "extent": (24.0, 36.0)}, r"points 4 m apart over 36 m: give unit"),
        ({"unit": "nm", "extent": (1e-9, 1e-9)}, r"points .* apart, closer than atoms"),
        ({"unit": "m"}, r"heights of 1.\d+ m in all: give unit"),
        ({"unit": "um", "extent": (2e-6, 2e-5)}, r"an rms slope of "),
    ],
)  # fmt: skip
def test_implausible_sizes_are_refused_in_a_sentence(tmp_path: Path, keys: dict[str, Any], sentence: str) -> None:
    with pytest.raises(cs.InvalidInput, match=sentence):
        surface(tmp_path, matrix(), **keys)
    assert surface(tmp_path, matrix(), sizes="confirmed", **keys)


def test_spikes_are_said_and_high_ones_refused(tmp_path: Path) -> None:
    heights = np.add.outer(np.sin(np.arange(40.0) / 5), np.cos(np.arange(40.0) / 7)) * 0.3
    keys: Any = {"unit": "um", "extent": (2e-4, 2e-4)}
    assert "steps" not in surface(tmp_path, matrix(heights=heights), **keys).description
    heights[20, 20] += 9.0
    assert "4 steps between neighbours of up to 9" in surface(tmp_path, matrix(heights=heights), **keys).description
    heights[20, 20] += 21.0
    with pytest.raises(cs.InvalidInput, match=r"4 steps .*: spikes, or points that were not"):
        surface(tmp_path, matrix(heights=heights), **keys)


def test_a_key_that_contradicts_the_header_is_refused_until_it_is_confirmed(tmp_path: Path) -> None:
    for key, value, sentence in (
        ("unit", "um", r"is 'um': leave it out, since its heights are in m"),
        ("extent", (1e-3, 2e-3), r"is 1 mm x 2 mm .*: leave it out, since .* 24 µm x 36 µm"),
        ("invalid", -1.0, r"is -1\.0: leave it out, since the file says 5\.0"),
    ):
        given: Any = {key: value}
        with pytest.raises(cs.InvalidInput, match=sentence):
            surface(tmp_path, "# Invalid: 5\n" + IN_METRES, **given)
        assert surface(tmp_path, "# Invalid: 5\n" + IN_METRES, sizes="confirmed", **given)


def test_a_comma_or_a_point_with_two_readings_needs_the_decimal_sign(tmp_path: Path) -> None:
    for text in (DECIMAL_COMMAS, THOUSANDS):
        with pytest.raises(cs.InvalidInput, match=r'give decimal = "," or decimal = "\."'):
            surface(tmp_path, text, unit="um")
    profile = surface(tmp_path, DECIMAL_COMMAS, unit="um", decimal=",")
    np.testing.assert_allclose(profile.heights[:, 0], abs(MAP.ravel()) * 1e-6, atol=1e-14)
    with pytest.raises(cs.InvalidInput, match="no marks between thousands"):
        surface(tmp_path, THOUSANDS, unit="nm", decimal=",")


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("not,numbers\nat,all\n", "without rows of numbers: give rows"),
        ("12,34\n", "'12,34' is two numbers or one with a decimal comma"),
        ("1,2,3,\n4,5,6,\n", "2 rows of 3 numbers: give a surface of at least 8 x 8"),
        ("a;b;c\n1;2;3\n", "1 rows of 3 numbers: give a surface of at least 8 x 8"),
        (matrix().replace(f"{MAP[5, 1]:.4f}", "um"), "row 6 has 'um', which stands for a height"),
        (matrix() + "\n1.5\t2.5\n", "give rows of equally many numbers"),
        ("0 0 1\n1 0 1\n3 0 1\n0 1 1\n", "not equidistant"),
        ("0 0 1\n1 0 1\n0 1 1\n0 0 2\n", "two heights at one place"),
        (trace("Angle [deg]\tZ [µm]"), "Angle .* is no length"),
        (trace("t\tZ\ns\tµm"), "'t s' is no length"),
        (matrix() + "\n\n" + matrix(), "2 blocks of numbers between blank lines: give a file of one map"),
        ("Pixel size: 2\nUnit: nm\n" + matrix(), "sizes have no unit: give extent"),
        ("Pixel size 1: 2 µm\nPixel size 2: 4 µm\n" + matrix(), "two sizes for one"),
        ("Width: 24 µm\nHeight: 24 µm\nPixel size: 5 µm\n" + matrix(), "two sizes for one: y 2.4e-05 and 12 times"),
        ("ncols 9\nnrows 12\n" + matrix(heights=MAP[:9]), "of 81 numbers, where its header says 108"),
    ],
)
def test_a_file_that_is_no_surface_or_two_is_refused_in_a_sentence(tmp_path: Path, text: str, sentence: str) -> None:
    with pytest.raises(cs.InvalidInput, match=sentence) as refused:
        surface(tmp_path, text, unit=None if "Unit" in text or "µm]" in text else "um")
    assert len(str(refused.value)) < 300


def test_points_near_a_grid_are_put_onto_it_and_a_missing_one_is_missing(tmp_path: Path) -> None:
    computed = surface(tmp_path, "x [um],y [um],z [um]\n" + columns(jitter=0.08))
    np.testing.assert_allclose(computed.heights, MAP * 1e-6, atol=1e-14)
    assert computed.extent == pytest.approx(EXTENT, rel=0.02)
    assert "points moved by up to" in computed.description
    holed = "\n".join(columns().split("\n")[1:])
    missing = surface(tmp_path, holed, unit="um", missing=cs.HarmonicFill()).heights
    assert np.argwhere(np.isnan(missing)).tolist() == [[0, 0]]


def test_the_length_of_a_part_is_no_size_of_the_map_and_what_is_not_used_is_said(tmp_path: Path) -> None:
    text = "Roller, diameter 10 mm, length 12 mm\n" + matrix()
    assert_is_map(surface(tmp_path, text, **SIZED))
    assert surface(tmp_path, "Pixel size: 2 µm\n" + text, unit="um").extent == pytest.approx((24e-6, 18e-6))
    computed = surface(tmp_path, "Sample: 10 mm wide\n" + IN_METRES)
    assert "these lines of the header were not used: 'Sample: 10 mm wide'" in computed.description


def test_a_size_without_unit_or_of_one_axis_alone_gives_way_to_an_extent(tmp_path: Path) -> None:
    lines = "\n".join(f"{2 * i}\t{row}" for i, row in enumerate(matrix().split("\n")))
    for text, fault in ((lines, "a size along one axis alone"), ("Pixel size: 2\n" + matrix(), "sizes have no unit")):
        assert_is_map(surface(tmp_path, text, **SIZED))
        with pytest.raises(cs.InvalidInput, match=f"{fault}: give extent"):
            surface(tmp_path, text, unit="um")


def test_a_stylus_trace_runs_across_and_transposed_along(tmp_path: Path) -> None:
    text = trace("Lateral um\tRaw Micrometer")
    computed = surface(tmp_path, text)
    np.testing.assert_allclose(computed.heights, MAP[:, :1] * 1e-6, atol=1e-14)
    assert computed.extent is not None
    assert computed.extent[0] == pytest.approx(6e-4)
    assert surface(tmp_path, text, transpose=True).heights.shape == (1, 12)


def test_points_on_one_line_are_a_profile_of_square_cells(tmp_path: Path) -> None:
    points = "\n".join(f"{5e-5 * n:.6f},0.002,{z * 1e-6:.10f}" for n, z in enumerate(MAP[:, 0]))
    assert_is_map(surface(tmp_path, "x [m],y [m],z [m]\n" + points), MAP[:, :1], (6e-4, 5e-5))


def test_a_surface_is_transposed_and_flipped_as_it_is_read_and_written_so(tmp_path: Path) -> None:
    computed = surface(tmp_path, IN_METRES, transpose=True, flip="across")
    assert_is_map(computed, MAP.T[::-1], EXTENT[::-1])
    assert "exchanged (transpose); reversed (flip across)" in computed.description
    steel = cs.HalfSpace(210e9, 0.3)
    scene = cs.SceneFile(cs.Scene(cs.LineLoad(1e3), (steel, steel), (computed,)))
    cs.write_scene(scene, tmp_path / "scene.toml")
    assert cs.read_scene(tmp_path / "scene.toml").scene == scene.scene


def test_a_surface_says_what_was_subtracted_from_it(tmp_path: Path) -> None:
    np.save(tmp_path / "tilted.npy", np.linspace(0, 2, 8)[:, None] + np.linspace(0, 3, 10))
    keys: Any = {"extent": (4e-3, 5e-3), "unit": "um"}
    freed, kept = (cs.MeasuredSurface.read(tmp_path / "tilted.npy", trend=trend, **keys) for trend in ("plane", "none"))
    assert "a plane that rises 2 um across and 3 um along was subtracted" in freed.description
    assert "a plane that rises 2 um across and 3 um along is left;" in kept.description


def test_points_are_written_at_the_middle_of_their_cells(tmp_path: Path) -> None:
    path = tmp_path / "surface.nc"
    cs.MeasuredSurface(MAP * 1e-6, EXTENT).write(path)
    with xr.open_dataset(path) as dataset:
        for name, size, count in zip("xy", EXTENT, MAP.shape, strict=True):
            np.testing.assert_allclose(dataset[name], size * (np.arange(count) + 0.5) / count, rtol=1e-14)
            assert dataset[name].attrs["units"] == "m"
    assert_is_map(cs.MeasuredSurface.read(path, trend="none"))
    with pytest.raises(cs.InvalidInput, match=r"^MeasuredSurface\.extent is .*: leave it out"):
        cs.MeasuredSurface.read(path, extent=(24e-6, 9e-6))
    cs.MeasuredSurface(MAP * 1e-6).write(path)
    assert_is_map(cs.MeasuredSurface.read(path, extent=EXTENT, trend="none"))


@pytest.mark.whole
def test_an_x3p_file_has_its_sizes_its_unit_and_its_missing_points(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ImportWarning)
        surfaces = pytest.importorskip("SurfaceTopography")
    path = tmp_path / "surface.x3p"
    surfaces.Topography(np.ma.masked_greater(MAP, 0.5), (24.0, 36.0), unit="µm").to_x3p(str(path))
    computed = cs.MeasuredSurface.read(path, missing=cs.HarmonicFill())
    np.testing.assert_allclose(computed.heights, np.where(MAP > 0.5, np.nan, MAP * 1e-6), atol=1e-14)
    assert computed.extent == pytest.approx(EXTENT)
    for keys in ({"extent": (24e-6, 9e-6)}, {"unit": "nm"}):
        with pytest.raises(cs.InvalidInput, match=r"^MeasuredSurface\.(extent|unit) .*: leave it out"):
            cs.MeasuredSurface.read(path, missing=cs.HarmonicFill(), **keys)  # type: ignore[arg-type]
    with pytest.raises(cs.InvalidInput, match=r"give MeasuredSurface\.read\(path\)"):
        cs.MeasuredSurface(path)
    path.write_bytes(10 * bytes(range(256)))
    with pytest.raises(cs.InvalidInput, match=r"^path is '.*surface\.x3p', in which .* no surface: give a file"):
        cs.MeasuredSurface.read(path)
    assert capsys.readouterr() == ("", "")


def test_a_missing_library_names_its_extra(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    (tmp_path / "surface.x3p").write_bytes(b"PK\3\4")
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'contactstudy\[measured\]'"):
        cs.MeasuredSurface.read(tmp_path / "surface.x3p")
