"""Numbers that the command takes: their limits, and those that are taken if none is given."""

import click

from studies.cli.commands import cli


def test_numbers_of_the_command_have_these_limits_and_defaults() -> None:
    parameters = {
        (name, parameter.name): parameter
        for name, command in cli.commands.items()
        for parameter in command.params
    }
    limits = {
        place: (parameter.type.min, parameter.type.max)
        for place, parameter in parameters.items()
        if isinstance(parameter.type, click.IntRange)
    }
    runs, repeats, threads = (0, 1024), (1, None), (1, None)
    assert limits == {
        ("report", "workers"): runs,
        ("run", "workers"): runs,
        ("report", "repeats"): repeats,
        ("run", "repeats"): repeats,
        ("plan", "threads"): threads,
        ("solve", "threads"): threads,
    }
    for name in ("workers", "repeats"):
        assert [parameters[command, name].default for command in ("report", "run")] == [2, 2]
    for command in ("recommend", "report"):
        assert parameters[command, "error"].default == 1e-2
        assert parameters[command, "seconds"].default == 60
