"""Studies: many contacts, swept, stored, timed and drawn."""

from contactstudy.domain.imports import names_on_first_use as _names_on_first_use

# Names are listed in __init__.pyi, and imported on first use.
__getattr__, __dir__, __all__ = _names_on_first_use(__name__, __file__)
