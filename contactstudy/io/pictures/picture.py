"""The picture of any answer, by what its dataset holds."""

import xarray as xr
from matplotlib.figure import Figure

from contactstudy.io.pictures.contact import contact_picture, film_picture
from contactstudy.io.pictures.evolution import evolution_picture, film_evolution_picture, passes_picture

# Variables and dimensions that a dataset has, and what draws it; the first that fits.
PICTURES = (
    ({"film", "time"}, film_evolution_picture),
    ({"film"}, film_picture),
    ({"pass_number"}, passes_picture),
    ({"gap", "time"}, evolution_picture),
    ({"gap"}, contact_picture),
)


def picture_of(dataset: xr.Dataset) -> Figure | None:
    """Return the picture of a contact or a film, of either in time, or of passes; None of another dataset."""
    names = {*map(str, dataset.variables), *map(str, dataset.dims)}
    return next((draw(dataset) for needed, draw in PICTURES if needed <= names), None)
