"""Draws docs/explanation/architecture.svg: the folders of both packages and the imports between them."""

import ast
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

ROOT = Path(__file__).parents[2]
PACKAGES = ("contactstudy", "studies")


def folder_of(module: str) -> str | None:
    """The folder of a module below its package; None for other projects."""
    package, *rest = module.split(".")
    if package not in PACKAGES:
        return None
    named = rest[0] if rest and (ROOT / package / rest[0]).is_dir() else ""
    return f"{package}/{named}" if named else package


def imports() -> set[tuple[str, str]]:
    """Pairs of folders, of which the first imports the second."""
    found = set()
    for package in PACKAGES:
        for file in (ROOT / package).rglob("*.py"):
            module = ".".join(file.relative_to(ROOT).with_suffix("").parts)
            here = folder_of(module)
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                names = [node.module] if isinstance(node, ast.ImportFrom) and node.module else []
                names += (
                    [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
                )
                for name in names:
                    there = folder_of(name)
                    if here and there and here != there and "/" in here and "/" in there:
                        found.add((here, there))
    return found


def layers(pairs: set[tuple[str, str]]) -> dict[str, int]:
    """The height of each folder: one above the highest it imports."""
    folders = {one for pair in pairs for one in pair}
    height = dict.fromkeys(folders, 0)
    for _ in folders:
        for above, below in pairs:
            height[above] = max(height[above], height[below] + 1)
    return height


def reduced(pairs: set[tuple[str, str]]) -> set[tuple[str, str]]:
    """Pairs without those that follow from others: of two ways down, the longer says more."""

    def reaches(start: str, end: str) -> bool:
        return any(a == start and (b == end or reaches(b, end)) for a, b in pairs)

    return {
        (a, b) for a, b in pairs if not any(c == a and d != b and reaches(d, b) for c, d in pairs)
    }


def draw() -> None:
    """Write the picture."""
    pairs = reduced(imports())
    height = layers(pairs)
    figure = Figure(figsize=(9, 9), layout="constrained")
    ax = figure.subplots()
    rows: dict[int, list[str]] = {}
    for folder in sorted(height):
        rows.setdefault(height[folder], []).append(folder)
    place = {}
    for row, folders in rows.items():
        for number, folder in enumerate(folders):
            place[folder] = ((number + 0.5) / len(folders), row)
    for above, below in sorted(pairs):
        ax.add_patch(
            FancyArrowPatch(
                place[above], place[below], arrowstyle="-|>", mutation_scale=9, shrinkA=16, shrinkB=16,
                color="#999999", linewidth=0.6, connectionstyle="arc3,rad=0.05",
            )
        )  # fmt: skip
    for folder, (x, y) in place.items():
        color = "#CFE3F5" if folder.startswith("contactstudy") else "#F7E0C3"
        ax.add_patch(
            FancyBboxPatch(
                (x - 0.11, y - 0.16),
                0.22,
                0.32,
                boxstyle="round,pad=0.02",
                facecolor=color,
                linewidth=0.6,
            )
        )
        ax.text(x, y, folder.replace("/", "/\n"), ha="center", va="center", fontsize=8)
    ax.set(xlim=(-0.05, 1.05), ylim=(-0.5, max(rows) + 0.5))
    ax.axis("off")
    figure.savefig(ROOT / "docs" / "explanation" / "architecture.svg", metadata={"Date": None})


if __name__ == "__main__":
    draw()
