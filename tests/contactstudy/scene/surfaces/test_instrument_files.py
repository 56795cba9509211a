"""Files as instruments and people write them: one map, whose right numbers are known."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import contactstudy as cs

# Heights [um] of 12 points across by 9 along, 2 um and 4 um apart; a row of a matrix runs along.
MAP = np.round(np.random.default_rng(3).normal(0, 0.3, (12, 9)), 4)
EXTENT = (24e-6, 36e-6)


def matrix(separator: str = "\t", scale: float = 1.0, heights: Any = MAP, number: str = "%.4f") -> str:
    return "\n".join(separator.join(number % (scale * z) for z in row) for row in heights)


def columns(separator: str = ",", across: float = 2.0, jitter: float = 0.0) -> str:
    shifts = jitter * np.random.default_rng(0).uniform(-1, 1, (2, *MAP.shape))
    return "\n".join(
        separator.join(
            f"{value:.5f}" for value in (across * (i + shifts[0, i, j]), 4 * (j + shifts[1, i, j]), MAP[i, j])
        )
        for j in range(9)
        for i in range(12)
    )


def inches() -> str:
    points = np.array([row.split(",") for row in columns().split("\n")], dtype=float)
    lines = points * [1 / 25400, 1 / 25400, 1 / 25.4e-3]
    return "\n".join(",".join(f"{value:.10f}" for value in line) for line in lines)


# Whole numbers with a point between thousands.
THOUSANDS = matrix(heights=MAP, scale=1e4, number="%.0f")
THOUSANDS = re.sub(r"(?<=\d)(?=\d{3}\b)", ".", THOUSANDS)


def surface(folder: Path, text: str | bytes, name: str = "map.txt", **keys: Any) -> cs.MeasuredSurface:
    data = text if isinstance(text, bytes) else text.encode()
    (folder / name).write_bytes(data)
    return cs.MeasuredSurface.read(folder / name, trend="none", **keys)


GWYDDION = "# Channel: Topography\n# Width: 36.00 µm\n# Height: 24.00 µm\n# Value units: m\n"
SPREADSHEET = "XPixelSize;4,0;µm\nYPixelSize;2,0;µm\nHeight Unit;nm\n"
MARGINS = "\n".join(
    [";".join(["", *(f"{4 * j}" for j in range(9))])]
    + [";".join([f"{2 * i}", *(f"{z:.4f}" for z in row)]) for i, row in enumerate(MAP)]
)


@pytest.mark.cases(100)
@pytest.mark.parametrize("name", ["map.txt", "map.csv"])
@pytest.mark.parametrize(
    ("text", "unit"),
    [
        (GWYDDION + matrix(scale=1e-6, number="%.4e"), None),
        (GWYDDION.replace("Value units: m", "Value units: μm") + matrix(), None),
        ("ncols 9\nnrows 12\ndx 4 um\ndy 2 um\n" + matrix(" "), "um"),
        (SPREADSHEET + matrix(";", 1e3, number="%.1f").replace(".", ","), None),
        ("w=9 h=12\nScan size: 36 x 24 um\nheight conversion factor (-> m)=1e-9\n" + matrix(" ", 1e3), None),
        ("X[mm],Y[um],Z[nm]\n" + columns(across=2e-3), "skip"),
        ("x;y;z\n[um];[um];[um]\n" + columns(";"), None),
        ("# X [mm]  Y [mm]  Z [um]\n" + columns("  ", across=2.0).replace("\n", "\n\n"), "in mm"),
        (columns(" "), "um"),
        (MARGINS, "um"),
        ("nx: 9\nny: 12\nX spacing 4 um\nY spacing 2 um\nUnit: um\n" + matrix("\n"), None),
        ("Horizontal pixel size: 4 µm\nVertical pixel size: 2 µm\nZ resolution: 1 nm\nUnit: µm\n" + matrix(), None),
        ("Lateral resolution X: 4 µm\nLateral resolution Y: 2 µm\nUnit: µm\n" + matrix(), None),
        ("Pixel size X/Y: 4 µm / 2 µm\nUnit: µm\n" + matrix(), None),
        ("Lateral calibration: 4 µm/px (X), 2 µm/px (Y)\nUnit: µm\n" + matrix(), None),
        ("Width;Height\nµm;µm\n36;24\nUnit: µm\n" + matrix(), None),
        ("Slow axis size: 24 µm\nFast axis size: 36 µm\nUnit: µm\n" + matrix(), None),
        ("Pixelabstand X: 4,0 µm\nPixelabstand Y: 2,0 µm\nEinheit: µm\n" + matrix(), None),
        ("Width,Height,XY unit,Z unit\n36,24,um,nm\n" + matrix(",", 1e3, number="%.1f"), None),
        ("FOV: 36 x 24 um\nZ sensitivity: 0.1 nm/count\nValue units: counts\n" + matrix(" ", 1e4, number="%.0f"), None),
        ("Pixel size: 4 x 2 µm\nOptical resolution: 0.4 µm\nbit2nm = 0.1\n" + matrix(" ", 1e4, number="%.0f"), None),
        ("X (in),Y (in),Z (µin)\n" + inches(), None),
        ("Sampling length 0.8 mm\nScale factor: 0.001\ndx = 4 um\ndy = 2 um\n" + matrix(scale=1e3), "um"),
    ],
)  # fmt: skip
def test_one_map_is_one_surface_by_its_content(tmp_path: Path, name: str, text: str, unit: str | None) -> None:
    if unit == "skip":  # heights are in nm there
        found = surface(tmp_path, text, name)
        np.testing.assert_allclose(found.heights, MAP * 1e-9, atol=1e-18)
    else:
        given: Any = {"sizes": "confirmed"} if unit == "in mm" else {"unit": unit}
        found = surface(tmp_path, text, name, **given)
        np.testing.assert_allclose(found.heights, MAP * 1e-6, atol=1e-14)
    scale = 1e3 if unit == "in mm" else 1.0
    assert found.extent == pytest.approx([scale * side for side in EXTENT], rel=1e-6)


@pytest.mark.cases(100)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "latin-1"])
def test_a_heading_with_the_micro_sign_is_read_in_any_encoding(tmp_path: Path, encoding: str) -> None:
    text = "Höhe [µm]\r\n" + matrix(";").replace(".", ",").replace("-", "\u2212" if "utf" in encoding else "-")
    found = surface(tmp_path, text.encode(encoding), extent=EXTENT)
    np.testing.assert_allclose(found.heights, MAP * 1e-6, atol=1e-14)


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("mark", "header", "keys"),
    [
        ("-9999", "", {}), ("1e38", "", {}), ("3.4028235e38", "", {}), ("-32768", "", {}), ("-inf", "", {}),
        ("no data", "", {}), ("#N/A", "", {}), ("", "", {}), ("NaN", "", {}), ("***", "", {}),
        ("BAD", "", {}), ("--", "", {}),
        ("0.123", "", {"invalid": 0.123}), ("7.5", "NODATA_value 7.5\n", {}),
    ],
)  # fmt: skip
def test_points_that_were_not_measured_are_missing(
    tmp_path: Path, mark: str, header: str, keys: dict[str, Any]
) -> None:
    holed = matrix(";").split("\n")
    holed[4] = ";".join([mark, *holed[4].split(";")[1:]])
    text = header + "\n".join(holed)
    found = surface(tmp_path, text, unit="um", extent=EXTENT, missing=cs.HarmonicFill(), **keys)
    assert np.argwhere(np.isnan(found.heights)).tolist() == [[4, 0]]
    assert "1 missing points (0.93%) filled by Laplace's equation" in found.description


@pytest.mark.parametrize(("height", "cells"), [(-77.0, 2), (0.0, 30)])
def test_repeated_heights_are_refused_until_a_key_says_what_they_are(tmp_path: Path, height: float, cells: int) -> None:
    heights = MAP.copy()
    heights.flat[:cells] = height
    with pytest.raises(cs.InvalidInput, match=rf"{cells} points .* give invalid = {height:g}, or"):
        surface(tmp_path, matrix(heights=heights), unit="um", extent=EXTENT)
    keys: Any = {"unit": "um", "extent": EXTENT, "missing": cs.HarmonicFill(0.5)}
    masked = surface(tmp_path, matrix(heights=heights), invalid=height, **keys)
    assert np.isnan(masked.heights).sum() == cells
    kept = surface(tmp_path, matrix(heights=heights), sizes="confirmed", **keys)
    np.testing.assert_allclose(kept.heights, heights * 1e-6, atol=1e-14)


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ({"unit": "mm", "extent": EXTENT}, r"likely heights in um, not mm"),
        ({"unit": "um", "extent": (24.0, 36.0)}, r"points 4 m apart .* 1e-06 times these"),
        ({"unit": "nm", "extent": (1e-9, 1e-9)}, r"likely sizes across and along"),
        ({"unit": "m"}, r"heights of 1.\d+ m in all \(likely heights in mm, not m\)"),
    ],
)  # fmt: skip
def test_implausible_sizes_are_refused_with_the_likely_unit(
    tmp_path: Path, keys: dict[str, Any], sentence: str
) -> None:
    with pytest.raises(cs.InvalidInput, match=sentence):
        surface(tmp_path, matrix(), **keys)
    assert surface(tmp_path, matrix(), sizes="confirmed", **keys)


def test_a_flat_with_dimples_has_a_height_that_most_points_share(tmp_path: Path) -> None:
    heights = np.minimum(MAP - np.quantile(MAP, 0.3), 0)
    found = surface(tmp_path, matrix(heights=heights), unit="um", extent=EXTENT)
    np.testing.assert_allclose(found.heights, heights * 1e-6, atol=1e-10)
    masked = np.where(np.arange(12)[:, None] < 4, MAP, 0)
    with pytest.raises(cs.InvalidInput, match="give invalid = 0, or"):
        surface(tmp_path, matrix(heights=masked), unit="um", extent=EXTENT)


def test_slopes_above_one_are_refused(tmp_path: Path) -> None:
    zigzag = 0.5 * (-1.0) ** np.add.outer(np.arange(40), np.arange(40))
    with pytest.raises(cs.InvalidInput, match=r"an rms slope of 2\.83 \(likely heights in nm"):
        surface(tmp_path, matrix(heights=zigzag), unit="um", extent=(2e-5, 2e-5))


def test_a_key_that_contradicts_the_header_is_refused_until_it_is_confirmed(tmp_path: Path) -> None:
    text = GWYDDION + "# Invalid: 5\n" + matrix(scale=1e-6, number="%.4e")
    for key, value, sentence in (
        ("unit", "um", r"is 'um': leave it out, since its heights are in m"),
        ("extent", (1e-3, 2e-3), r"is 1 mm x 2 mm .*: leave it out, since .* 24 µm x 36 µm"),
        ("invalid", -1.0, r"is -1\.0: leave it out, since the file says 5\.0"),
    ):
        given: Any = {key: value}
        with pytest.raises(cs.InvalidInput, match=sentence):
            surface(tmp_path, text, **given)
        assert surface(tmp_path, text, sizes="confirmed", **given)


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    "text",
    [
        "\n".join(f"{abs(z):.4f}".replace(".", ",") for z in MAP.ravel()),
        "\n".join(f"{abs(1e4 * z):,.0f}\t{abs(1e4 * z):,.0f}" for z in MAP.ravel()[:50]).replace("\t", "\t100\t"),
        THOUSANDS,
    ],
)  # fmt: skip
def test_a_comma_with_two_readings_needs_the_decimal_sign(tmp_path: Path, text: str) -> None:
    with pytest.raises(cs.InvalidInput, match=r'give decimal = "," or decimal = "\."'):
        surface(tmp_path, text, unit="um")


def test_a_column_of_decimal_commas_is_a_profile_with_its_key(tmp_path: Path) -> None:
    text = "\n".join(f"{abs(z):.4f}".replace(".", ",") for z in MAP.ravel())
    found = surface(tmp_path, text, unit="um", decimal=",")
    np.testing.assert_allclose(found.heights[:, 0], abs(MAP.ravel()) * 1e-6, atol=1e-14)


def test_points_near_a_grid_are_put_onto_it_and_others_refused(tmp_path: Path) -> None:
    found = surface(tmp_path, "x [um],y [um],z [um]\n" + columns(jitter=0.08))
    np.testing.assert_allclose(found.heights, MAP * 1e-6, atol=1e-14)
    assert found.extent == pytest.approx(EXTENT, rel=0.02)
    assert "points moved by up to" in found.description
    with pytest.raises(cs.InvalidInput, match="not equidistant"):
        surface(tmp_path, columns(jitter=0.3), unit="um")


def test_the_length_of_a_part_is_no_size_of_the_map(tmp_path: Path) -> None:
    text = "Roller, diameter 10 mm, length 12 mm\n" + matrix()
    assert surface(tmp_path, text, unit="um").extent is None
    assert surface(tmp_path, "Pixel size: 2 µm\n" + text, unit="um").extent == pytest.approx((24e-6, 18e-6))


def test_a_file_shorter_than_its_header_says_is_refused(tmp_path: Path) -> None:
    text = "ncols 9\nnrows 12\n" + "\n".join(matrix(" ").split("\n")[:9])
    with pytest.raises(cs.InvalidInput, match="of 81 numbers, where its header says 108"):
        surface(tmp_path, text, unit="um")


def test_a_column_that_counts_the_rows_is_no_height_and_said(tmp_path: Path) -> None:
    text = "\n".join(f"{i};{row}" for i, row in enumerate(matrix(";").split("\n")))
    found = surface(tmp_path, text, unit="um", extent=EXTENT)
    np.testing.assert_allclose(found.heights, MAP * 1e-6, atol=1e-14)
    assert "numbers that count the points in y are left out" in found.description


def test_a_stylus_trace_runs_across_and_transposed_along(tmp_path: Path) -> None:
    text = "Lateral um,Raw Micrometer\n" + "\n".join(f"{50.0 * n},{z}" for n, z in enumerate(MAP[:, 0]))
    trace = surface(tmp_path, text)
    np.testing.assert_allclose(trace.heights, MAP[:, :1] * 1e-6, atol=1e-14)
    assert trace.extent is not None
    assert trace.extent[0] == pytest.approx(6e-4)
    assert surface(tmp_path, text, transpose=True).heights.shape == (1, 12)


def test_a_surface_is_transposed_and_flipped_as_it_is_read_and_written_so(tmp_path: Path) -> None:
    found = surface(tmp_path, GWYDDION + matrix(scale=1e-6, number="%.4e"), transpose=True, flip="across")
    np.testing.assert_allclose(found.heights, MAP.T[::-1] * 1e-6, atol=1e-14)
    assert found.extent == pytest.approx(EXTENT[::-1])
    assert "exchanged (transpose); reversed (flip across)" in found.description
    steel = cs.HalfSpace(210e9, 0.3)
    scene = cs.SceneFile(cs.Scene(cs.LineLoad(1e3), (steel, steel), (found,)))
    cs.write_scene(scene, tmp_path / "scene.toml")
    assert cs.read_scene(tmp_path / "scene.toml").scene == scene.scene


def test_thousands_are_read_with_the_decimal_sign(tmp_path: Path) -> None:
    found = surface(tmp_path, THOUSANDS, unit="nm", extent=(1e-3, 2e-3), decimal=",")
    np.testing.assert_allclose(found.heights, np.round(MAP * 1e4) * 1e-9, atol=1e-14)


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("Angle [deg]\tZ [µm]\n" + "\n".join(f"{n}\t{z}" for n, z in enumerate(MAP[:, 0])), "Angle .* is no length"),
        ("Time [ms]\tZ [µm]\n" + "\n".join(f"{n}\t{z}" for n, z in enumerate(MAP[:, 0])), "'Time .* is no length"),
        ("t\tZ\ns\tµm\n" + "\n".join(f"{n}\t{z}" for n, z in enumerate(MAP[:, 0])), "'t s' is no length"),
        ("Unit: µm\n" + matrix() + "\n\n" + matrix(), "2 blocks of numbers between blank lines: give a file of one map"),
        ("Pixel size: 2\nUnit: nm\n" + matrix(), "sizes without a unit, and heights in nm: give extent"),
        ("Pixel size 1: 2 µm\nPixel size 2: 4 µm\nUnit: µm\n" + matrix(), "two sizes for one"),
        (GWYDDION + "Pixel size: 5 µm\n" + matrix(), r"two sizes for one: y 2.4e-05 and 12 times 5e-06 m"),
    ],
)  # fmt: skip
def test_a_file_with_two_readings_is_refused(tmp_path: Path, text: str, sentence: str) -> None:
    with pytest.raises(cs.InvalidInput, match=sentence):
        surface(tmp_path, text)


def test_sizes_that_were_assumed_give_way_to_an_extent(tmp_path: Path) -> None:
    lines = "\n".join(f"{2 * i}\t{row}" for i, row in enumerate(matrix().split("\n")))
    for text in (lines, "Pixel size: 2\n" + matrix()):
        assert surface(tmp_path, text, unit="um", extent=EXTENT).extent == pytest.approx(EXTENT)
    assert "taken as square" in surface(tmp_path, lines, unit="um").description
    with pytest.raises(cs.InvalidInput, match="leave it out"):
        surface(tmp_path, lines, unit="um", extent=(1e-5, 36e-6))


def test_lines_of_a_header_that_are_not_used_are_said(tmp_path: Path) -> None:
    found = surface(tmp_path, "Sample: 10 mm wide\n" + GWYDDION + matrix(scale=1e-6, number="%.4e"))
    assert "these lines of the header were not used: 'Sample: 10 mm wide'" in found.description


def test_steps_that_no_surface_of_these_slopes_has_are_said_and_high_ones_are_spikes(
    tmp_path: Path,
) -> None:
    heights = np.add.outer(np.sin(np.arange(40.0) / 5), np.cos(np.arange(40.0) / 7)) * 0.3
    keys: Any = {"unit": "um", "extent": (2e-4, 2e-4)}
    heights[20, 20] += 9.0
    found = surface(tmp_path, matrix(heights=heights), **keys)
    assert "4 steps between neighbours of up to 9" in found.description
    heights[20, 20] += 21.0
    with pytest.raises(cs.InvalidInput, match=r"4 steps .*: spikes, or points that were not"):
        surface(tmp_path, matrix(heights=heights), **keys)


def test_grooves_have_no_steps(tmp_path: Path) -> None:
    grooves = np.sin(np.arange(40.0) / 3)[:, None] + 1e-3 * MAP[:8, :8].ravel()[:40]
    found = surface(tmp_path, matrix(heights=grooves), unit="um", extent=(2e-4, 2e-4))
    assert "steps" not in found.description
