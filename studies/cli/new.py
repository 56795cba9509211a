"""``contactstudy new KIND``: a commented scene to begin with."""

from importlib.resources import files
from pathlib import Path

import click

from contactstudy import InvalidInput
from contactstudy.domain.checks import suggestion


@click.command()
@click.argument("kind", required=False)
@click.option("--out", type=click.Path(path_type=Path), help="File to write.  [default: KIND.toml]")
@click.option("--list", "listed", is_flag=True, help="List the kinds of scenes, one a line.")
def new(kind: str | None, out: Path | None, listed: bool) -> None:  # noqa: FBT001 (click's own way)
    """Write a commented scene of a KIND, such as roller, or coating, which is a sweep.

    plan, solve and run take it. No file is replaced.
    """
    scenes = templates() | templates("chapters")
    if listed:
        width = max(map(len, scenes))
        for name, text in scenes.items():
            click.echo(f"{name:<{width}}  {text.splitlines()[0].removeprefix('# ')}")
        return
    if kind is None:
        raise InvalidInput(
            f"KIND is missing: choose from {', '.join(scenes)}, which contactstudy new --list describes."
        )
    if kind not in scenes:
        raise InvalidInput(f"KIND is {kind!r}: {suggestion(kind, scenes)}.")
    path = out or Path(f"{kind}.toml")
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(scenes[kind].replace(f"{kind}.toml", path.name))
    except FileExistsError:
        raise InvalidInput(f"{path} exists already: give another file with --out.") from None
    except OSError as error:
        raise InvalidInput(
            f"{path} cannot be written ({error.strerror}): give another file with --out."
        ) from None
    verb = "run {0} runs its sweep" if "[vary]" in scenes[kind] else "solve {0} solves it"
    click.echo(f"wrote {path}: contactstudy {verb.format(path)}")


def templates(name: str = "templates") -> dict[str, str]:
    """Return the texts of the scenes in a folder of the package by their kinds, in the order of the alphabet."""
    folder = files("studies") / name
    names = sorted(entry.name for entry in folder.iterdir() if entry.name.endswith(".toml"))
    return {
        name.removesuffix(".toml"): (folder / name).read_text(encoding="utf-8") for name in names
    }
