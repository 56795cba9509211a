from studies.registry import load


def test_every_padding_may_have_one_cell_along_a_contact_that_does_not_vary() -> None:
    study = load("pareto")
    names = {axis.name: axis.values for axis in study.axes}
    for padding in names["padding"]:
        point = {"padding": padding, "images": 1, "period": 2.4, "grid": 48, "along": "one"}
        assert study.case_at(point).grid.cells == (48, 1)  # type: ignore[attr-defined]
        assert study.case_at(point | {"along": "square"}).grid.cells == (48, 48)  # type: ignore[attr-defined]


def test_the_paper_s_methods_are_compared_at_the_length_that_it_names() -> None:
    paper, images = (load(name) for name in ("paper", "images"))
    for study in (paper, images):
        values = {axis.name: axis.values for axis in study.axes}
        assert {"duplicated", "superposed"} <= set(values["padding"])
        assert 6 in values["images"]
        assert 3.0 in values["period"]


def test_the_set_up_of_a_contact_at_rest_makes_its_coefficients() -> None:
    [case] = load("padding").override({"padding": "exact", "period": "2.4", "images": "1"}).cases()
    prepared = case.prepare()
    assert prepared.grid == case.grid  # type: ignore[attr-defined]
    assert case.run(prepared).pressure.any()
