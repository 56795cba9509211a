"""Help text of a command, with the axes of its study."""

from pathlib import Path

import click

from studies.model.axis import Axis
from studies.registry import outline

STUDY = "contactstudy.study"
MAX_VALUES = 10  # of an axis
OF_SCENES = ("vary", "reference", "plot")
KINDS = {int: "COUNTS", float: "NUMBERS", str: "NAMES"}


class StudyCommand(click.Command):
    """A command with an argument ``study``, whose help lists the axes of the study given."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the arguments; the study is stored first, since help is printed before other arguments are parsed."""
        parsed, _, _ = self.make_parser(ctx).parse_args(list(args))
        ctx.meta[STUDY] = parsed.get("study")
        return super().parse_args(ctx, args)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options of every run, those of a scene, and an option for every axis of the study given."""
        rows: dict[bool, list[tuple[str, str]]] = {False: [], True: []}
        for option in self.get_params(ctx):
            # an argument stands in the usage
            row = option.get_help_record(ctx) if isinstance(option, click.Option) else None
            if row is not None:
                rows[option.name in OF_SCENES].append(row)
        for of_scenes, title in ((False, "Options"), (True, "Options of a scene in a .toml file")):
            if rows[of_scenes]:
                with formatter.section(title):
                    formatter.write_dl(rows[of_scenes])
        name = ctx.meta.get(STUDY)
        if not isinstance(name, str) or name.endswith(".toml"):
            return
        with formatter.section(f"Axes of {Path(name).stem}"):
            formatter.write_dl([_row(axis) for axis in outline(name)[1]])


def _row(axis: Axis) -> tuple[str, str]:
    """Return option and help text of an axis."""
    units = "" if axis.units == "1" else f" [{axis.units}]"
    values = ", ".join(str(value) for value in axis.values[:MAX_VALUES])
    if len(axis.values) > MAX_VALUES:
        values += f", ... ({len(axis.values)} values, the last {axis.values[-1]})"
    return f"--{axis.name} {KINDS[axis.kind]}", f"{axis.long_name}{units}.  [default: {values}]"
