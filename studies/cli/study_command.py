"""A command that runs a study, each of whose axes is an option."""

from pathlib import Path

import click

from contactstudy import InvalidInput
from studies.model.axis import Axis
from studies.registry import outline

STUDY, AXES = "contactstudy.study", "contactstudy.axes"
MAX_VALUES = 10  # of an axis
OF_SCENES = ("vary", "vary_every", "reference", "plot")
KINDS = {int: "COUNTS", float: "NUMBERS", str: "NAMES"}
EXAMPLE = '--vary "load.per_length=50 N/mm,100 N/mm"'


class StudyCommand(click.Command):
    """A command with an argument ``study``, which has an option for every axis of the study given.

    The values that are given to axes stand by their names in :attr:`click.Context.meta` under :data:`AXES`.
    """

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the arguments, first for the study alone; an unknown option of a scene is answered with --vary."""
        parser = self.make_parser(ctx)
        parser.ignore_unknown_options = True
        study = parser.parse_args(list(args))[0].get("study")
        is_scene = isinstance(study, str) and study.endswith(".toml")
        ctx.meta[AXES] = {}
        if isinstance(study, str) and not is_scene:
            taken = {name for param in self.get_params(ctx) for name in param.opts}
            ctx.meta[STUDY] = [
                AxisOption(f"axis_{number}", axis, Path(study).stem)
                for number, axis in enumerate(outline(study)[1])
                if f"--{axis.name}" not in taken
            ]
        try:
            return super().parse_args(ctx, args)
        except click.NoSuchOption as error:
            if not is_scene:
                raise
            message = f"{error.message} Fields of a scene are varied by {EXAMPLE}."
            raise click.NoSuchOption(error.option_name, message, error.possibilities, ctx) from None

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        """Return the parameters of every study, and an option for each axis of the study given."""
        return [*super().get_params(ctx), *ctx.meta.get(STUDY, ())]

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options of every run, those of a scene, and those of the axes of the study given."""
        sections: dict[str, list[tuple[str, str]]] = {}
        for option in self.get_params(ctx):
            # an argument stands in the usage
            row = option.get_help_record(ctx) if isinstance(option, click.Option) else None
            if row is not None:
                title = (
                    "Options of a scene in a .toml file" if option.name in OF_SCENES else "Options"
                )
                sections.setdefault(getattr(option, "section", title), []).append(row)
        for title, rows in sections.items():
            with formatter.section(title):
                formatter.write_dl(rows)


class AxisOption(click.Option):
    """The option for the values of an axis of a study."""

    def __init__(self, name: str, axis: Axis, study: str) -> None:
        units = "" if axis.units == "1" else f" [{axis.units}]"
        values = ", ".join(str(value) for value in axis.values[:MAX_VALUES])
        if len(axis.values) > MAX_VALUES:
            values += f", ... ({len(axis.values)} values, the last {axis.values[-1]})"

        def take(context: click.Context, _: click.Parameter, texts: tuple[str, ...]) -> None:
            if len(texts) > 1:
                raise InvalidInput(
                    f"Axis {axis.name!r} is given twice: write all its values in one list."
                )
            if texts:
                context.meta[AXES][axis.name] = texts[0]

        super().__init__(
            [f"--{axis.name}", name], multiple=True, metavar=KINDS[axis.kind], callback=take,
            help=f"{axis.long_name}{units}.  [default: {values}]", expose_value=False,
        )  # fmt: skip
        self.section = f"Axes of {study}"
