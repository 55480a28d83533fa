#!/usr/bin/env python3
"""What the book of docs/ needs beside mdbook.

    book.py supports RENDERER, book.py     as mdbook calls a preprocessor: links out of docs/ become names of files
    book.py check FOLDER                   every link of the made book leads to a file and an anchor of it, or out of
                                           this machine

Pages link to files of the repository that are no pages of the book: examples, robot models. A book lies anywhere,
without them.
"""

import json
import os
import posixpath
import re
import sys
from html.parser import HTMLParser
from urllib.parse import unquote, urlsplit

# A link with its text, no picture: `[text](where)`. Texts with brackets inside do not occur beside paths that lead out.
LINK = re.compile(r"(?<!!)\[([^\]\[]+)\]\(([^)\s]+)\)")


def is_outside(page, where):
    """Whether a link on the page PAGE, a path below docs/, leaves docs/."""
    parts = urlsplit(where)
    if parts.scheme or parts.netloc or not parts.path:
        return False
    return posixpath.normpath(posixpath.join(posixpath.dirname(page), parts.path)).startswith("..")


def without_outside(page, text):
    """The text with the path in the repository where a link leads out of docs/."""

    def named(link):
        label, where = link.groups()
        if not is_outside(page, where):
            return link.group(0)
        path = posixpath.normpath(posixpath.join("docs", posixpath.dirname(page), urlsplit(where).path))
        return f"`{path}`" if path.endswith(label.strip("`")) else f"{label} (`{path}`)"

    return LINK.sub(named, text)


def preprocess():
    """One message of mdbook in, the book out."""
    _context, book = json.load(sys.stdin)

    def walk(items):
        for item in items:
            chapter = item.get("Chapter") if isinstance(item, dict) else None
            if chapter:
                if chapter.get("path"):
                    chapter["content"] = without_outside(chapter["path"], chapter["content"])
                walk(chapter["sub_items"])

    walk(book["items"])
    json.dump(book, sys.stdout)


class Page(HTMLParser):
    """Anchors and links of a page."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.links = set(), set()
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name == "id" or (name == "name" and tag == "a"):
                self.anchors.add(value)
            elif name in ("href", "src") and value:
                self.links.add(value)


def check(folder):
    """Reports links that lead nowhere; whether there is none."""
    pages = {}
    for at, _, files in os.walk(folder):
        for name in files:
            # print.html is all pages in one; its links are theirs.
            if name.endswith(".html") and name != "print.html":
                path = os.path.normpath(os.path.join(at, name))
                with open(path, encoding="utf-8") as file:
                    pages[path] = Page(file.read())
    links, wrong = 0, 0
    for path, page in sorted(pages.items()):
        for link in sorted(page.links):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            links += 1
            target = os.path.normpath(os.path.join(os.path.dirname(path), unquote(parts.path))) if parts.path else path
            # The page for wrong addresses is served at any depth, so its links begin at the root of the site.
            if parts.path.startswith("/"):
                target = os.path.normpath(os.path.join(folder, unquote(parts.path).lstrip("/")))
            if not os.path.exists(target):
                problem = "there is no such file"
            elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].anchors:
                problem = "there is no such anchor"
            else:
                continue
            wrong += 1
            print(f"{os.path.relpath(path, folder)}: {link}: {problem}", file=sys.stderr)
    print(f"{len(pages)} pages, {links} links, {wrong} of them lead nowhere")
    return links > 0 and wrong == 0


if __name__ == "__main__":
    arguments = sys.argv[1:]
    if arguments[:1] == ["supports"]:
        sys.exit(0)
    if arguments[:1] == ["check"] and len(arguments) == 2:
        sys.exit(0 if check(arguments[1]) else 1)
    if arguments:
        sys.exit("book.py: supports RENDERER, check FOLDER, or nothing")
    preprocess()
