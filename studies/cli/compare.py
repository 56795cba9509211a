"""``contactstudy compare A.nc B.nc``."""

from pathlib import Path

import click

from contactstudy import InvalidInput

FILE = click.Path(path_type=Path)


@click.command()
@click.argument("first", metavar="A", type=FILE)
@click.argument("second", metavar="B", type=FILE)
@click.option(
    "--out", type=FILE, help="Folder for a picture of the difference.  [default: none is drawn]"
)
def compare(first: Path, second: Path, out: Path | None) -> None:
    """Say how B differs from A: two solutions on any grids of one period, or two runs of one study."""
    import contactstudy as cs
    from contactstudy.domain.files import replacing
    from studies.report.changes import changes
    from studies.store.netcdf import open_folder, read_any

    a, b = read_any(first), read_any(second)
    if "pressure" in a and "pressure" in b:
        found = cs.compare(a, b)
        for line in str(found).splitlines():
            click.echo(line)
        if out is not None:
            name = f"{first.stem}-{second.stem}.png"
            with replacing(open_folder(out) / name) as partial:
                found.plot().savefig(partial)
            click.echo(f"wrote {out / name}")
    elif "case_status" in a and "case_status" in b:
        for line in changes(a, b):
            click.echo(line)
    else:
        raise InvalidInput(
            f"{str(first)!r} and {str(second)!r} are not of one kind: give two solutions or two runs of a study."
        )
