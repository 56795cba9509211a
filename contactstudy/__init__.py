"""Rough line contacts, periodic along their length: how accurate the answer is, and what that cost."""

import lazy_loader as _lazy

from contactstudy.domain.version import VERSION as _VERSION

__version__ = _VERSION
# Names are listed in __init__.pyi. Each is imported on first use: an effect that no scene names costs nothing.
__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
