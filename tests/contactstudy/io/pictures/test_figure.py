"""Panels, and one legend for all of them."""

from typing import Any

import pytest

from contactstudy.io.pictures.figure import add_legend, panels


@pytest.mark.parametrize(("count", "columns", "rows"), [(1, 1, 1), (3, 3, 1), (4, 3, 2), (7, 3, 3)])
def test_panels_fill_rows_of_three(count: int, columns: int, rows: int) -> None:
    figure, axes = panels(count, width=2.0, height=1.5)
    assert len(axes) == count
    assert tuple(figure.get_size_inches()) == (2.0 * columns, 1.5 * rows)
    assert [ax.get_visible() for ax in figure.axes] == [True] * count + [False] * (
        rows * columns - count
    )


@pytest.mark.parametrize(
    ("share", "x", "y"), [("none", False, False), ("y", False, True), ("both", True, True)]
)
def test_panels_share_what_they_are_told(share: Any, x: bool, y: bool) -> None:  # noqa: FBT001
    _, (first, second) = panels(2, share=share)
    assert first.get_shared_x_axes().joined(first, second) == x
    assert first.get_shared_y_axes().joined(first, second) == y


def test_a_legend_names_each_line_once_and_a_single_decade_is_widened() -> None:
    figure, (first, second) = panels(2, width=3.4)
    first.plot([1, 2], label="a")
    second.plot([1, 2], label="a")
    second.loglog([1, 100], [5.0, 5.0], label="b")
    second.set_ylim(5.0, 5.001)
    first.set_yscale("log")
    first.set_ylim(5.0, 7.5)
    add_legend(figure)
    assert first.get_ylim() == pytest.approx((5, 7.5))
    [legend] = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["a", "b"]
    assert second.get_ylim() == pytest.approx((2.5, 10.002))
    assert second.get_xlim()[1] > 99


def test_a_legend_has_as_many_columns_as_the_figure_holds() -> None:
    """Of 1.7 inches each: six lines in a figure of 6.8 inches stand in two rows of three."""
    figure, [ax] = panels(1, width=6.8)
    for name in "abcdef":
        ax.plot([1, 2], label=name)
    add_legend(figure)
    assert figure.legends[0]._ncols == 3
    empty, _ = panels(1)
    add_legend(empty)
    assert not empty.legends


@pytest.mark.parametrize(
    ("values", "at_least"), [((3.0, 8.0), 2), ((0.3, 6.0), 3), ((1.0, 200.0), 0)]
)
def test_a_logarithmic_axis_within_a_decade_has_labels_between(
    values: tuple[float, float], at_least: int
) -> None:
    figure, (ax,) = panels(1)
    ax.loglog(values, values)
    add_legend(figure)
    figure.canvas.draw()
    texts = [text.get_text() for text in ax.get_xticklabels(minor=True) if text.get_text()]
    assert bool(texts) == bool(at_least)
    assert len(texts) >= at_least
    boxes = [
        text.get_window_extent() for text in ax.get_xticklabels(which="both") if text.get_text()
    ]
    boxes = [box for box in boxes if ax.bbox.x0 <= (box.x0 + box.x1) / 2 <= ax.bbox.x1]
    assert not any(a.overlaps(b) for n, a in enumerate(boxes) for b in boxes[:n])


def test_ticks_that_are_set_stay_alone() -> None:
    figure, (ax,) = panels(1)
    ax.loglog([16, 256], [1, 2])
    ax.set_xticks([16, 64, 256], ["16", "64", "256"])
    ax.minorticks_off()
    add_legend(figure)
    figure.canvas.draw()
    assert [text.get_text() for text in ax.get_xticklabels(which="both")] == ["16", "64", "256"]
