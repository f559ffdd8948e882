"""Whether every local link and picture of a built book leads somewhere: `check_links.py BOOK`. Loads nothing from a network."""

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """Anchors of a page, and what it refers to."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.references = set(), []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.anchors.update(attributes[key] for key in ("id", "name") if attributes.get(key))
        self.references += [(self.getpos()[0], attributes[key]) for key in ("href", "src") if attributes.get(key)]


def faults(book):
    """A line for each reference that leads nowhere, and how many were looked at."""
    pages = {path.resolve(): Page(path.read_text(encoding="utf-8")) for path in sorted(book.rglob("*.html"))}
    found, looked_at = [], 0
    for path, page in pages.items():
        for line, reference in page.references:
            parts = urlsplit(reference)
            if parts.scheme or parts.netloc:
                continue
            looked_at += 1
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            where = f"{path.relative_to(book)}:{line}: {reference}"
            if not target.is_relative_to(book):
                found.append(f"{where}: outside the book")
            elif not target.is_file():
                found.append(f"{where}: no such file")
            elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].anchors:
                found.append(f"{where}: no such anchor")
    return found, looked_at, len(pages)


if __name__ == "__main__":
    found, looked_at, pages = faults(Path(sys.argv[1]).resolve())
    print(*found, f"{looked_at} local links and pictures in {pages} pages, {len(found)} lead nowhere", sep="\n")
    # A book without pages or links is one that was not found.
    sys.exit(bool(found) or not looked_at)
