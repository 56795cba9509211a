"""Entry point of the command, which imports little, so that Ctrl-C is handled from the start."""

import sys
from io import TextIOWrapper

from contactstudy.domain.imports import missing_package


def main() -> None:
    """Import the commands and run them."""
    for stream in (sys.stdout, sys.stderr):
        # a file on Windows may be in an encoding that lacks a letter
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")
    try:
        from studies.cli.commands import main as run

        run()
    except ModuleNotFoundError as missing:
        sys.exit(f"contactstudy: {missing_package('the command', missing)}")
    except KeyboardInterrupt:
        print("contactstudy: stopped before the command started.", file=sys.stderr)
        sys.exit(130)
