"""Where in a study's own code an error was raised."""

import sysconfig
import traceback
from functools import cache
from pathlib import Path

from studies.model.plain_text import one_line


def place_of(error: BaseException, *others: str) -> str:
    """`` in function (file, line n)``: the innermost place that is no library's, nor in the files ``others``.

    Nothing where there is none.
    """
    frames = traceback.extract_tb(error.__traceback__, limit=-50)
    own = [frame for frame in frames if not frame.filename.startswith((*_libraries(), *others))]
    if not own:
        return ""
    place = own[-1]
    return one_line(f" in {place.name} ({Path(place.filename).name}, line {place.lineno})", 300)


@cache
def _libraries() -> tuple[str, ...]:
    paths = sysconfig.get_paths()
    return paths["stdlib"], paths["purelib"], paths["platlib"], "<"
