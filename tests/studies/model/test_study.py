import pytest

from contactstudy import InvalidInput
from studies.registry import BUILT_IN, load


@pytest.mark.parametrize("name", BUILT_IN)
def test_built_in_studies_have_a_title_and_cases(name: str) -> None:
    study = load(name)
    assert study.title.endswith(".")
    assert len(study.cases()) > 1


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("paddin", "did you mean 'padding'"),
        ("xyz", "choose from accuracy, coating, creep"),
        ("nowhere.py", "cannot be read"),
    ],
)
def test_an_unknown_study_is_refused_with_a_remedy(name: str, message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        load(name)


@pytest.mark.parametrize(
    ("axis", "values", "message"),
    [
        ("period", "0", "period is 0.0: give a period above 0"),
        ("period", "-2.4", "period is -2.4"),
        ("grid", "1", "grid is 1: give at least 2 cells"),
        ("images", "-1", "images is -1: must be a whole number, at least 0"),
        ("padding", "exakt", "padding is 'exakt': did you mean 'exact'"),
    ],
)
def test_a_point_that_cannot_be_is_refused_before_anything_runs(
    axis: str, values: str, message: str
) -> None:
    with pytest.raises(InvalidInput, match=f"^{message}"):
        load("padding").override({axis: values}).cases()
