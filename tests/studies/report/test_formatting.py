import pytest
import xarray as xr

from studies.report.style import percent, variation_text


@pytest.mark.parametrize(
    ("fraction", "text"),
    [
        (0.0, "0"),
        (0.0123, "1.2"),
        (-0.0123, "1.2"),
        (0.123, "12"),
        (1.23, "123"),
        (1.23e-7, "0.000012"),
        (1.23e-8, "1.2e-06"),
        (float("nan"), None),
    ],
)
def test_a_fraction_is_in_per_cent_with_two_digits(fraction: float, text: str | None) -> None:
    assert percent(fraction) == ("not known" if text is None else f"{text}\u00a0%")


@pytest.mark.parametrize(
    ("variation", "text"),
    [
        (0.012, "1.2\u00a0% of p_{H}"),
        (1.5e-12, "1.5e-10\u00a0% of p_{H}"),
        (1e-12, "rounding only"),
    ],
)
def test_what_varies_by_no_more_than_1e_12_is_rounding(variation: float, text: str) -> None:
    assert variation_text(xr.Dataset({"length_variation": variation})) == text
