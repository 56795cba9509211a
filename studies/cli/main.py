"""Entry point of the command; it imports little, so that Ctrl-C works from the start."""

import sys


def main() -> None:
    """Import the rest and run it."""
    try:
        from studies.cli.commands import main as run

        run()
    except KeyboardInterrupt:
        sys.exit("contactstudy: stopped before the command started.")
