"""Finds dead links in a built site: every relative address of a page must lead to a file, and every
anchor of a page of the documentation to an element.

Usage: check_links.py SITE
Pages below SITE/api are Doxygen's own: their anchors are not looked at, and lists of members that
Doxygen links without making them are left out.
"""
# SPDX-License-Identifier: BSD-3-Clause
import html.parser
import pathlib
import sys
import urllib.parse


class Page(html.parser.HTMLParser):
    """Addresses that a page refers to, and anchors that it offers."""

    def __init__(self, path):
        super().__init__()
        self.addresses = []
        self.anchors = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("href", "src") and value:
                self.addresses.append(value)
            elif name in ("id", "name") and value:
                self.anchors.add(value)


def main(site):
    root = pathlib.Path(site).resolve()
    pages = {path: Page(path) for path in sorted(root.rglob("*.html"))}
    dead = []
    count = 0
    for path, page in pages.items():
        if path.name == "404.html":  # Its addresses are those of the place that it is served at.
            continue
        is_api = root / "api" in path.parents
        for address in sorted(set(page.addresses)):
            parts = urllib.parse.urlsplit(address)
            if parts.scheme or parts.netloc:
                continue
            count += 1
            target = path
            if parts.path:
                target = (path.parent / urllib.parse.unquote(parts.path)).resolve()
                if target.is_dir():
                    target /= "index.html"
            if not target.is_file():
                if not (is_api and target.name.endswith("-members.html")):
                    dead.append(f"{path.relative_to(root)}: no {address}")
            elif parts.fragment and target in pages and not is_api and not parts.fragment.startswith("__"):
                if urllib.parse.unquote(parts.fragment) not in pages[target].anchors:
                    dead.append(f"{path.relative_to(root)}: no anchor {address}")
    for line in dead:
        print(line)
    print(f"{len(pages)} pages, {count} links, {len(dead)} dead")
    return 1 if dead else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
