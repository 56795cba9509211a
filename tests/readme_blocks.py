"""``python readme_blocks.py README.md``: its Python blocks run in order and print what their comments say.

It needs nothing but the program, so that a wheel can be tried in an environment without the tests.
"""

import contextlib
import io
import re
import sys
from pathlib import Path

BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", flags=re.DOTALL | re.MULTILINE)
SAID = re.compile(r"^print\(.*\)  # (.*)$", flags=re.MULTILINE)


def main(page: Path) -> None:
    known: dict[str, object] = {}
    for kind, block in BLOCK.findall(page.read_text(encoding="utf-8")):
        if kind == "python":
            said = io.StringIO()
            with contextlib.redirect_stdout(said):
                exec(compile(block, str(page), "exec"), known)
            if said.getvalue().splitlines() != SAID.findall(block):
                sys.exit(f"{block}\nprints:\n{said.getvalue()}")


if __name__ == "__main__":
    # beside this file lie tests of the same names as the program
    sys.path[:] = [path for path in sys.path if Path(path).resolve() != Path(__file__).parent]
    main(Path(sys.argv[1]))
