import pytest

import contactstudy as cs
from contactstudy.planning.forecast import GridForecast


@pytest.mark.parametrize(
    ("cells", "errors"),
    [((64, 1), (0.07, 0.0)), ((64, 48), (0.02, 0.05)), ((64, 48), (0.05, 0.0))],
)
def test_the_grid_for_an_error_is_expected_to_meet_it(
    cells: tuple[int, int], errors: tuple[float, float]
) -> None:
    grid = cs.Grid(cells, (2.0, 1.0))
    forecast = GridForecast(
        grid, errors, (1.5, 0.5), (16, 12), contact_exceeds_grid=False, message="", seconds=1.0
    )
    for error in (0.1, 0.01, 2e-3):
        found = forecast.grid_for(error)
        assert forecast.error_of(found.cell_size) <= error * (1 + 1e-12)
