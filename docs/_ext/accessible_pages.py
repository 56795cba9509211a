"""Pages that a keyboard and a screen reader can use; a build fails on problems of its pages or of its spelling."""

from pathlib import Path
from typing import Any

import codespell_lib
from page_problems import problems
from sphinx.application import Sphinx
from sphinx.util import logging

# The theme gives captions of the navigation the role of a heading without its level.
CAPTION = ('role="heading">', 'role="heading" aria-level="2">')
SPELLED = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs", "contactstudy", "studies", "examples")


def check(app: Sphinx, exception: Exception | None) -> None:
    """Warn of every problem, which ends a build with ``-W``."""
    if exception is None and app.builder.name == "html":
        for problem in problems(Path(app.outdir)):
            logging.getLogger(__name__).warning(problem)


def check_spelling(app: Sphinx) -> None:
    """Warn where codespell, configured in pyproject.toml, finds a misspelled word; it prints the words."""
    root = Path(app.srcdir).parent
    if codespell_lib.main("--toml", str(root / "pyproject.toml"), *(str(root / one) for one in SPELLED)):
        logging.getLogger(__name__).warning("codespell found misspelled words, listed above")


def give_levels(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: object) -> None:
    """Give the headings of the navigation and of contents their level."""
    for part in ("body", "furo_navigation_tree"):
        if part in context:
            context[part] = context[part].replace(*CAPTION)


def setup(app: Sphinx) -> dict[str, object]:
    """Register the checks, and the levels after the theme has made its navigation."""
    app.connect("builder-inited", check_spelling)
    app.connect("html-page-context", give_levels, priority=900)
    app.connect("build-finished", check)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
