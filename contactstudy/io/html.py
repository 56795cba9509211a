"""A solution as a small table with a picture, for notebooks."""

from base64 import b64encode
from html import escape
from io import BytesIO

import numpy as np

from contactstudy.solvers.solution import Solution


def html(solution: Solution) -> str:
    """A table of the numbers that are looked at first, and :func:`~contactstudy.Solution.plot`."""
    nx, ny = solution.pressure.shape
    rows = {
        "status": str(solution.status),
        "grid": f"{nx} x {ny} cells",
        "peak pressure": f"{solution.pressure.max():.5g} Pa",
        "share in contact": f"{100 * np.mean(solution.pressure > 0):.3g} %",
        "approach": f"{solution.approach:.5g} m",
        "solver": f"{solution.iterations} iterations, residual {solution.residual:.1e}",
    }
    if solution.note:
        rows["note"] = solution.note
    cells = "".join(
        f"<tr><th style='text-align:left'>{name}</th><td style='text-align:left'>{escape(text)}</td></tr>"
        for name, text in rows.items()
    )
    return f"<table>{cells}</table>{_picture(solution)}"


def _picture(solution: Solution) -> str:
    """An image; nothing where there are no numbers to draw, or no library that draws."""
    if not np.isfinite(solution.pressure).all():
        return ""
    file = BytesIO()
    try:
        solution.plot().savefig(file, format="png", dpi=60)
    except ModuleNotFoundError:
        return ""
    data = b64encode(file.getvalue()).decode()
    return f"<img alt='pressure and gap of the contact' src='data:image/png;base64,{data}'>"
