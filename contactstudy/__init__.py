"""Rough line contacts, periodic along their length: how accurate the answer is, and what that costs."""

from contactstudy.domain.imports import VERSION as _VERSION
from contactstudy.domain.imports import names_on_first_use as _names_on_first_use

__version__ = _VERSION
# Names are listed in __init__.pyi. Each is imported on first use: an effect that no scene names costs nothing.
__getattr__, __dir__, __all__ = _names_on_first_use(__name__, __file__)
