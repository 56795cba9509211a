import pytest

from contactstudy import InvalidInput
from studies.registry import BUILT_IN, load


@pytest.mark.parametrize("name", BUILT_IN)
def test_built_in_studies_have_a_title_and_cases(name: str) -> None:
    study = load(name)
    assert study.title.endswith(".")
    assert len(study.cases()) > 1


POINTS = [
    ("padding", "period", "0", "period is 0.0: give"),
    ("padding", "period", "-2.4", "period is -2.4"),
    ("padding", "grid", "1", "grid is 1: give"),
    ("padding", "images", "-1", "Superposition.images is -1: give"),
    ("padding", "padding", "exakt", "padding is 'exakt': did you mean 'exact'"),
]


@pytest.mark.cases(len(POINTS))
@pytest.mark.parametrize(("name", "axis", "values", "message"), POINTS)
def test_a_point_that_cannot_be_is_refused_before_anything_runs(
    name: str, axis: str, values: str, message: str
) -> None:
    with pytest.raises(InvalidInput, match=f"^{message}"):
        load(name).override({axis: values}).cases()
