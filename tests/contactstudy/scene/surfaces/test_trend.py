import numpy as np
import pytest

import contactstudy as cs

X, Y = np.meshgrid(np.linspace(-3, 2, 13), np.linspace(0, 7, 9), indexing="ij")
FORMS = {
    cs.Trend.NONE: 0 * X,
    cs.Trend.MEAN: 0 * X + 3,
    cs.Trend.PLANE: 3 - 2 * X + 0.5 * Y,
    cs.Trend.QUADRATIC: 3 - 2 * X + 0.5 * Y + X**2 - 3 * X * Y + 2 * Y**2,
}


@pytest.mark.parametrize("trend", FORMS, ids=str)
def test_trend_takes_off_its_own_form_and_no_more(trend: cs.Trend) -> None:
    rough = np.random.default_rng(0).standard_normal(X.shape)
    left = trend.subtracted(rough)
    np.testing.assert_allclose(trend.subtracted(rough + FORMS[trend]), left, rtol=0, atol=1e-12)
    np.testing.assert_allclose(trend.subtracted(left), left, rtol=0, atol=1e-13)
    for form in list(FORMS.values())[1 : trend.value + 2]:  # least squares: nothing of it is left
        assert abs((left * form).sum()) < 1e-11


def test_trend_leaves_the_forms_beyond_it() -> None:
    """Products of deviations from the mean are orthogonal to every polynomial of lower total degree."""
    x, y = X - X.mean(), Y - Y.mean()
    for trend, beyond in (
        (cs.Trend.MEAN, x),
        (cs.Trend.PLANE, x * y),
        (cs.Trend.QUADRATIC, (x**2 - (x**2).mean()) * y),
    ):
        np.testing.assert_allclose(trend.subtracted(beyond), beyond, rtol=0, atol=1e-12)


@pytest.mark.parametrize("shape", [(1, 1), (5, 1), (2, 2), (1, 3)])
def test_few_points_have_no_more_trend_than_they_show(shape: tuple[int, int]) -> None:
    heights = np.random.default_rng(0).standard_normal(shape)
    left = cs.Trend.QUADRATIC.subtracted(heights)
    assert left.shape == shape
    assert abs(left.sum()) < 1e-14 * heights.size
