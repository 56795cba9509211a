import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from contactstudy.scene.surfaces import measurement as reader
from contactstudy.scene.surfaces.measurement import Measurement, measurement
from contactstudy.scene.surfaces.text_surface import Reading

HEIGHTS = np.random.default_rng(0).standard_normal((6, 4)) * 1e-7


def read(path: Path, extent: tuple[float, float] | None = None, unit: str | None = None, **keys: Any) -> Measurement:
    """Points and sizes of a file."""
    return reader.read(path, Reading(extent=extent, unit=unit, **keys))[:2]


def labelled(**coordinates: Any) -> xr.DataArray:
    return xr.DataArray(HEIGHTS, dims=("width", "length"), coords=coordinates)


def test_points_are_a_copy_that_nobody_can_write_to() -> None:
    heights = HEIGHTS.copy()
    points, _ = measurement(heights)
    heights[0, 0] = 1.0
    assert points[0, 0] == HEIGHTS[0, 0]
    with pytest.raises(ValueError, match="read-only"):
        points[0, 0] = 1.0


def test_masked_points_and_infinite_ones_are_missing() -> None:
    heights = np.ma.masked_less(np.arange(12).reshape(4, 3), 2)
    assert np.isnan(measurement(heights)[0]).sum() == 2
    assert np.isnan(measurement(np.array([[np.inf, 1.0, -np.inf]]))[0]).sum() == 2


@pytest.mark.parametrize("names", [("width", "length"), ("x", "y"), ("row", "column")])
def test_coordinates_give_the_sizes(names: tuple[str, str]) -> None:
    """Of as many cells as there are points, wherever the coordinates start."""
    x, y = 1e-6 * np.arange(6) + 3, 2e-6 * np.arange(4) - 1
    array = xr.DataArray(HEIGHTS, dims=names, coords={names[0]: x, names[1]: y})
    points, extent = measurement(array)
    assert extent == pytest.approx((6e-6, 8e-6))
    np.testing.assert_array_equal(points, HEIGHTS)
    if names[0] != "row":
        points, extent = measurement(array.T.chunk(3))
        assert extent == pytest.approx((6e-6, 8e-6))
        np.testing.assert_array_equal(points, HEIGHTS)


def test_coordinates_that_fall_are_turned_to_rise() -> None:
    x, y = np.arange(6), np.arange(4)
    falling = labelled(width=x, length=y).isel(length=slice(None, None, -1))
    np.testing.assert_array_equal(measurement(falling)[0], HEIGHTS)


@pytest.fixture
def written(tmp_path: Path) -> Path:
    """An X3P file of HEIGHTS over 6 um x 8 um, written in um."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ImportWarning)
        surfaces = pytest.importorskip("SurfaceTopography")
    path = tmp_path / "surface.x3p"
    surfaces.Topography(HEIGHTS * 1e6, (6.0, 8.0), unit="µm").to_x3p(str(path))
    return path


@pytest.mark.whole
def test_a_surface_from_a_file_is_that_of_its_heights(written: Path) -> None:
    surface = cs.MeasuredSurface.read(str(written))
    points, extent = read(written)
    given = cs.MeasuredSurface(points, extent, trend="plane", seam=cs.Tapered())
    assert surface == given
    with pytest.raises(cs.InvalidInput, match=r"give MeasuredSurface\.read\(path\)"):
        cs.MeasuredSurface(written)


@pytest.mark.whole
def test_missing_points_of_a_file_are_missing(tmp_path: Path, written: Path) -> None:
    surfaces = pytest.importorskip("SurfaceTopography")
    heights = np.ma.masked_greater(HEIGHTS, HEIGHTS.mean())
    path = tmp_path / "holes.x3p"
    surfaces.Topography(heights, (6e-6, 8e-6), unit="m").to_x3p(str(path))
    np.testing.assert_array_equal(np.isnan(read(path)[0]), heights.mask)


@pytest.mark.whole
def test_a_file_that_is_none_is_refused(tmp_path: Path, written: Path) -> None:
    nothing = tmp_path / "nothing.x3p"
    nothing.write_bytes(b"\0nothing")
    with pytest.raises(cs.InvalidInput, match=r"^path is '.*nothing\.x3p', in which .* no surface .*: give a file"):
        read(nothing)
    with pytest.raises(FileNotFoundError):
        read(tmp_path / "absent.x3p")


@pytest.mark.whole
def test_a_file_without_sizes_is_refused(tmp_path: Path, written: Path) -> None:
    heights = tmp_path / "matrix.txt"
    np.savetxt(heights, LARGE)
    with pytest.raises(cs.InvalidInput, match=r"matrix\.txt' is None: give the unit of its numbers"):
        read(heights)


def test_points_are_written_at_the_middle_of_their_cells(tmp_path: Path) -> None:
    path = tmp_path / "surface.nc"
    cs.MeasuredSurface(HEIGHTS, (6e-6, 8e-6)).write(path)
    with xr.open_dataset(path) as dataset:
        for name, size, count in zip("xy", (6e-6, 8e-6), HEIGHTS.shape, strict=True):
            expected = [size * (n + 0.5) / count for n in range(count)]
            np.testing.assert_allclose(dataset[name], expected, rtol=1e-14)
            assert dataset[name].attrs["units"] == "m"
    points, extent = read(path)
    np.testing.assert_array_equal(points, HEIGHTS)
    assert extent == pytest.approx((6e-6, 8e-6), rel=1e-14)


def test_a_file_without_sizes_has_the_given_extent(tmp_path: Path) -> None:
    cs.MeasuredSurface(HEIGHTS).write(tmp_path / "surface.nc")
    assert read(tmp_path / "surface.nc", (6e-6, 8e-6))[1] == (6e-6, 8e-6)


@pytest.mark.whole
@pytest.mark.parametrize("name", ["surface.nc", "surface.xyz", "surface.x3p"])
def test_an_extent_or_a_unit_other_than_the_file_has_is_refused(name: str, tmp_path: Path, written: Path) -> None:
    cs.MeasuredSurface(HEIGHTS, (6e-6, 8e-6)).write(tmp_path / "surface.nc")
    (tmp_path / "surface.xyz").write_text("0 0 1\n3 0 2\n0 4 3\n3 4 4\n")
    unit = "um" if name == "surface.xyz" else "m"
    assert read(tmp_path / name, (6e-6, 8e-6), unit)[1] == pytest.approx((6e-6, 8e-6))
    with pytest.raises(cs.InvalidInput, match=r"^MeasuredSurface\.extent is .*: leave it out"):
        read(tmp_path / name, (6e-6, 9e-6), unit)
    if name != "surface.xyz":
        with pytest.raises(cs.InvalidInput, match=r"^MeasuredSurface\.unit of .*: leave it out"):
            read(tmp_path / name, None, "nm")


def test_a_missing_library_names_its_extra(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    (tmp_path / "surface.x3p").write_bytes(b"PK\3\4")
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'contactstudy\[measured\]'"):
        read(tmp_path / "surface.x3p")


TABLE = np.array([[1.0, 2.0, 4.0], [3.0, 5.0, 9.0]])
LARGE = np.arange(1.0, 73.0).reshape(8, 9) / 4


def rows(separator: str, *, decimal: str = ".", end: str = "") -> str:
    lines = (separator.join(f"{value:g}" for value in row) for row in LARGE)
    return "".join(f"{line.replace('.', decimal)}{end}\n" for line in lines)


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("heights.csv", rows(",")),
        ("heights.csv", "# heights\n" + rows(";")),
        ("comma.csv", rows(";", decimal=",")),
        ("blanks.txt", rows("  ", decimal=",")), ("titles.csv", "a,b,c\na\n" + rows(",")), ("rows.txt", rows(" ")),
        ("rows.asc", rows("\t", end="\t")),
    ],
)  # fmt: skip
def test_rows_of_numbers_are_read_in_their_unit(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text)
    points, extent = read(tmp_path / name, (2e-3, 3e-3), "um")
    np.testing.assert_allclose(points, LARGE * 1e-6, rtol=1e-15)
    assert extent == (2e-3, 3e-3)


def test_an_array_in_a_file_is_read_in_its_unit(tmp_path: Path) -> None:
    np.save(tmp_path / "heights.npy", TABLE)
    points, extent = read(tmp_path / "heights.npy", None, "nm")
    np.testing.assert_allclose(points, TABLE * 1e-9, rtol=1e-15)
    assert extent is None


def test_points_in_columns_make_a_grid_with_sizes(tmp_path: Path) -> None:
    lines = [f"{0.5 * i - 3} {0.25 * j + 7} {TABLE[i, j]}" for j in range(3) for i in range(2) if (i, j) != (1, 1)]
    (tmp_path / "points.xyz").write_text("\n".join(lines))
    points, extent = read(tmp_path / "points.xyz", None, "mm", sizes="confirmed")
    expected = TABLE * 1e-3
    expected[1, 1] = np.nan
    np.testing.assert_allclose(points, expected, rtol=1e-12)
    np.testing.assert_allclose(extent, (1e-3, 0.75e-3), rtol=1e-12)  # type: ignore[arg-type]


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("words.csv", "not,numbers\nat,all\n", "without rows of numbers: give rows"),
        ("small.csv", "a;b;c\n1;2;3\n", "1 rows of 3 numbers: give a surface of at least 8 x 8"),
        ("word.csv", rows(";").replace("11.75", "um"), "row 6 has 'um', which stands for a height"),
        (
            "two.csv",
            rows(";") + "second\n" + rows(";"),
            "row 9 has 1 numbers beside 9: .* one table",
        ),
        ("comma.csv", rows(",") + "1.5 2.5\n", "give rows of equally many numbers"),
        (
            "thousands.csv",
            rows(";").replace("1.75", "1.000,75"),
            "'11.000,75', which stands for a height",
        ),
        ("ragged.csv", "1,2\n3\n", "row 2 has 1 numbers beside 2: give rows of equally many"),
        ("two.xyz", "0 0\n1 1\n", "columns named x, y and z, columns x and z"),
        ("uneven.xyz", "0 0 1\n1 0 1\n3 0 1\n0 1 1\n", "not equidistant"),
        ("twice.xyz", "0 0 1\n1 0 1\n0 1 1\n0 0 2\n", "two heights at one place"),
    ],
)
def test_a_table_that_is_no_surface_is_refused_in_a_sentence(
    tmp_path: Path, name: str, text: str, sentence: str
) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(cs.InvalidInput, match=sentence) as refused:
        read(tmp_path / name, None, "um")
    assert len(str(refused.value)) < 300


def test_a_surface_says_what_was_subtracted_from_it(tmp_path: Path) -> None:
    tilted = np.linspace(0, 2, 8)[:, None] + np.linspace(0, 3, 10)
    np.savetxt(tmp_path / "tilted.csv", tilted, delimiter=",")
    freed, kept = (
        cs.MeasuredSurface.read(tmp_path / "tilted.csv", extent=(4e-3, 5e-3), unit="um", trend=trend)
        for trend in ("plane", "none")
    )
    assert "a plane that rises 2 um across and 3 um along was subtracted" in freed.description
    assert "a plane that rises 2 um across and 3 um along is left;" in kept.description
