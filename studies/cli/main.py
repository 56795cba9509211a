"""Where the command starts: light, so that Ctrl-C is answered from the first moment on."""

import sys


def main() -> None:
    """Import the rest and run it."""
    try:
        from studies.cli.commands import main as run

        run()
    except KeyboardInterrupt:
        sys.exit("contactstudy: stopped before it began.")
