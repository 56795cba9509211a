"""What presses the bodies together."""

from dataclasses import dataclass

from contactstudy.checks import positive


@dataclass(frozen=True)
class LineLoad:
    """A normal load ``per_length`` [N/m] of contact length, above zero."""

    per_length: float

    def __post_init__(self) -> None:
        positive("LineLoad.per_length", self.per_length, "give a load above 0 N/m")
