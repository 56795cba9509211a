"""What a study says: findings and tables, in words and numbers read from its Dataset."""

from dataclasses import dataclass

Row = tuple[str, ...]


@dataclass(frozen=True)
class Finding:
    """A claim in a few words, what was measured, and the reader's question that this answers, if one does."""

    claim: str
    measured: str
    question: str = ""


@dataclass(frozen=True)
class Table:
    """A head, rows of text, and a caption; a column whose every cell starts with a number is one of numbers."""

    caption: str
    head: Row
    rows: tuple[Row, ...]

    @property
    def kinds(self) -> Row:
        """``number`` or ``text`` for each column."""
        columns = zip(*self.rows, strict=True) if self.rows else [()] * len(self.head)
        return tuple(
            "number" if all(cell.lstrip("-−<> ")[:1].isdigit() for cell in column) else "text"
            for column in columns
        )
