"""Draws docs/explanation/architecture.svg: the folders of both packages and the imports between them."""

import ast
from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

ROOT = Path(__file__).parents[2]
# Where each package stands in the picture: its left side and its width.
SIDES = {"contactstudy": (0.0, 0.4), "studies": (0.4, 0.6)}
PACKAGES = tuple(SIDES)


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
                names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
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

    return {(a, b) for a, b in pairs if not any(c == a and d != b and reaches(d, b) for c, d in pairs)}


def draw() -> None:
    """Write the picture."""
    pairs = reduced(imports())
    height = layers(pairs)
    figure = Figure(figsize=(10, 9), layout="constrained")
    ax = figure.subplots()
    rows: dict[tuple[str, int], list[str]] = {}
    for folder in sorted(height):
        rows.setdefault((folder.split("/")[0], height[folder]), []).append(folder)
    place = {}
    for (package, row), folders in rows.items():
        left, width = SIDES[package]
        for number, folder in enumerate(folders):
            place[folder] = (left + width * (number + 0.5) / len(folders), row)
    boxes = {}
    for folder, (x, y) in place.items():
        color = "#CFE3F5" if folder.startswith("contactstudy") else "#F7E0C3"
        boxes[folder] = FancyBboxPatch(
            (x - 0.055, y - 0.2), 0.11, 0.4, boxstyle="round,pad=0.01", facecolor=color, linewidth=0.6, zorder=2
        )
        ax.add_patch(boxes[folder])
        ax.text(x, y, folder.replace("/", "/\n"), ha="center", va="center", fontsize=9, zorder=3)
    for above, below in sorted(pairs):
        arrow = FancyArrowPatch(
            place[above],
            place[below],
            arrowstyle="-|>",
            mutation_scale=10,
            patchA=boxes[above],
            patchB=boxes[below],
            color="#777777",
            linewidth=0.8,
            connectionstyle="arc3,rad=0.05",
        )
        ax.add_patch(arrow)
    ax.set(xlim=(-0.02, 1.02), ylim=(-0.5, max(height.values()) + 0.5))
    ax.axis("off")
    with rc_context({"svg.hashsalt": "architecture"}):  # the same file each time
        figure.savefig(ROOT / "docs" / "explanation" / "architecture.svg", metadata={"Date": None})


if __name__ == "__main__":
    draw()
