import pytest

from studies.report.formatting import percent


@pytest.mark.parametrize(
    ("share", "text"),
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
def test_a_share_is_in_per_cent_with_two_digits(share: float, text: str | None) -> None:
    assert percent(share) == ("not known" if text is None else f"{text}\u00a0%")
