"""Finds in built pages: images without a text, dead links and anchors, skipped levels of headings."""

from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """The images, links, anchors and headings of one page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.alternatives: list[tuple[str, str | None]] = []
        self.headings: list[int] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Keep what the checks need of a tag."""
        found = dict(attrs)
        self.anchors |= {value for key in ("id", "name") if (value := found.get(key))}
        self.links += [value for key in ("href", "src") if (value := found.get(key))]
        if tag == "img":
            self.alternatives.append((found.get("src") or "", found.get("alt")))
        if len(tag) == 2 and tag[0] == "h" and tag[1].isdigit():
            self.headings.append(int(tag[1]))


def problems(folder: Path) -> list[str]:
    """What is wrong in the pages of a folder: missing texts, dead links, skipped headings, addresses of other hosts."""
    paths = [path for path in folder.rglob("*.html") if "_static" not in path.parts]
    pages = {path.resolve(): Page(path.read_text(encoding="utf-8")) for path in paths}
    found = []
    for path, page in pages.items():
        name = path.relative_to(folder.resolve())
        for source, text in page.alternatives:
            thumbnail = source.endswith("_thumb.png")  # its title stands below it, in the same link
            if text is None or (not text.strip() and not thumbnail) or text == Path(source).name:
                found.append(f"{name}: image without a text alternative: {source[:80]}")
        for above, below in zip(page.headings, page.headings[1:], strict=False):
            if below > above + 1:
                found.append(f"{name}: a heading of level {below} follows one of level {above}")
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.exists():
                found.append(f"{name}: link to a file that does not exist: {link}")
                continue
            anchor = unquote(parts.fragment)
            if anchor and target in pages and anchor not in pages[target].anchors:
                found.append(f"{name}: link to an anchor that does not exist: {link}")
    return found
