"""``contactstudy run SCENE.toml --vary FIELD=VALUES``."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from contactstudy import InvalidInput
from studies.registry import load

if TYPE_CHECKING:
    from studies.model.study import Study

EXAMPLE = '--vary "load.per_length=50 N/mm,100 N/mm"'
VARY = click.option(
    "--vary",
    multiple=True,
    metavar="FIELD=VALUES",
    help="An axis of the study and its values, such as period=0.6,2.4 or images=0:10; or a field of the scene file, "
    "such as load.per_length=50:400:8 N/mm (8 values), 50:400:8:log N/mm (in equal ratios) or surfaces=measured/*.x3p.",
)
REFERENCE = click.option(
    "--reference",
    metavar="FIELD=VALUE",
    help="One of the values of a varied field, against which errors are drawn, such as padding=ExactPeriodicity; with "
    "--repeats also over the times.",
)
SENSITIVITY = click.option(
    "--sensitivity",
    "vary_every",
    is_flag=True,
    help="Raise and lower each number of the scene file alone, by the tolerance behind it, as in '10 mm +- 0.05 mm', or "
    "by 1 %; print and draw what the quantities change by.",
)


def sensitivity_of(name: str) -> "Study":
    """Return the study of each number of the scene in the file `name`, raised and lowered."""
    from studies.scene_study.sensitivity import sensitivity_study

    if not name.endswith(".toml"):
        raise InvalidInput(
            f"--sensitivity is for a scene in a .toml file, and {name!r} is a study: leave it out."
        )
    return sensitivity_study(name)


def write_sensitivity(study: "Study", plot: Sequence[str], out: Path) -> str:
    """Write the table of a stored sensitivity as CSV, and return it as text with aligned columns."""
    import csv

    from contactstudy.domain.storage.files import replacing
    from studies.report.drawings import default, sensitivity
    from studies.report.page import stored

    dataset = stored(study, out)
    table = sensitivity.table(dataset, default.chosen(dataset, plot))
    rows = [table.head, *table.rows]
    with (
        replacing(out / f"{study.name}.csv") as partial,
        partial.open("w", newline="", encoding="utf-8") as file,
    ):
        csv.writer(file).writerows(rows)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)


def load_varied(name: str, vary: Sequence[str]) -> "Study":
    """Return the study of a name, or of the scene in a file, over the values `vary`, or over its own.

    Raises :class:`~contactstudy.InvalidInput` for what cannot be varied.
    """
    fields: dict[str, str] = {}
    for text in vary:
        field, equals, values = text.partition("=")
        field = field.strip()
        if not equals or not field or not values.strip():
            raise InvalidInput(
                f"--vary is {text!r}: give a field and its values, such as {EXAMPLE}."
            )
        if field in fields:
            raise InvalidInput(f"--vary names {field} twice: write all its values in one list.")
        fields[field] = values.strip()
    if not name.endswith(".toml"):
        return load(name).override(fields)
    from contactstudy import read_scene
    from studies.scene_study.study_of import study_of

    if not fields and not read_scene(name).vary:
        raise InvalidInput(
            f"{name} is run without anything to vary: give {EXAMPLE} or a table [vary] in the file, or use "
            f"contactstudy solve {name}."
        )
    return study_of(Path(name), fields or None)


def with_reference(study: "Study", name: str, reference: str) -> "Study":
    """Return the study of a scene file with the value of a varied field against which errors are drawn.

    Raises :class:`~contactstudy.InvalidInput` for a value that the study does not vary.
    """
    from studies.advice.reference_error import against
    from studies.scene_study.study_of import study_of

    field, equals, value = (part.strip() for part in reference.partition("="))
    if not name.endswith(".toml") or not equals or not field or not value:
        raise InvalidInput(
            f"--reference is {reference!r}: give a varied field of a scene file and one of its values, such as "
            "padding=ExactPeriodicity."
        )
    (axis,) = study_of(Path(name), {field: value}).axes
    values = {varied.name: varied.values for varied in study.axes}.get(axis.name, ())
    if len(axis.values) != 1 or axis.values[0] not in values:
        raise InvalidInput(
            f"--reference is {reference!r}, which is not one of the values that are varied: add it to --vary."
        )
    return against(study, axis.name, axis.values[0])
