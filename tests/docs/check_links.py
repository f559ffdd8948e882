"""Whether every local link and picture of a built book, or of Markdown, leads somewhere. Loads nothing from a network.

    check_links.py BOOK
    check_links.py FILE.md... FOLDER...     the Markdown files of folders

In Markdown, anchors are those that GitHub gives headings.
"""

import re
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


FENCED = re.compile(r"^(```|~~~).*?^\1", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"(?<!\\)\]\(<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\)")


def anchors(text):
    """Those of a Markdown file: letters, digits and hyphens of its headings; one that stands again is numbered."""
    found = []
    for heading in re.findall(r"^#+ +(.*?)[ #]*$", FENCED.sub("", text), re.MULTILINE):
        heading = LINK.sub("", heading).replace("[", "")
        anchor = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        found.append(anchor if anchor not in found else f"{anchor}-{found.count(anchor)}")
    return found


def markdown_faults(files):
    """As `faults`, of Markdown files, whose links may lead to any file of the project."""
    found, looked_at = [], 0
    for path in files:
        # Lines keep their numbers.
        text = FENCED.sub(lambda fenced: "\n" * fenced[0].count("\n"), path.read_text(encoding="utf-8"))
        text = re.sub(r"`[^`\n]*`", "", text)
        for match in LINK.finditer(text):
            parts = urlsplit(match[1])
            if parts.scheme or parts.netloc:
                continue
            looked_at += 1
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path.resolve()
            where = f"{path}:{text.count(chr(10), 0, match.start()) + 1}: {match[1]}"
            if not target.exists():
                found.append(f"{where}: no such file")
            elif parts.fragment and target.suffix == ".md" and unquote(parts.fragment) not in anchors(target.read_text(encoding="utf-8")):
                found.append(f"{where}: no such anchor")
    return found, looked_at, len(files)


if __name__ == "__main__":
    given = [Path(argument) for argument in sys.argv[1:]]
    if len(given) == 1 and given[0].is_dir():
        found, looked_at, pages = faults(given[0].resolve())
    else:
        folders = [sorted(path.rglob("*.md")) if path.is_dir() else [path] for path in given]
        found, looked_at, pages = markdown_faults([path for paths in folders for path in paths])
    print(*found, f"{looked_at} local links and pictures in {pages} pages, {len(found)} lead nowhere", sep="\n")
    # A book without pages or links is one that was not found.
    sys.exit(bool(found) or not looked_at)
