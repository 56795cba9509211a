"""What presses the bodies together."""

from dataclasses import dataclass

from contactstudy.domain.checks import in_range, set_fields
from contactstudy.domain.units import NewtonsPerMetre


@dataclass(frozen=True)
class LineLoad:
    """A normal load ``per_length`` [N/m] of contact length, above zero."""

    per_length: NewtonsPerMetre

    def __post_init__(self) -> None:
        load = in_range("LineLoad.per_length", self.per_length, "give a load above 0 N/m")
        set_fields(self, per_length=load)

    @property
    def largest(self) -> float:
        """The load [N/m], as of one that changes."""
        return self.per_length
