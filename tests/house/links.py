#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Whether every relative link of every page (.md) leads to a file, every anchor to a heading, and
every path of the repository that a page names in `code` to a file.

usage: links.py SOURCE_FOLDER

A heading's anchor is made as GitHub makes it: lower case, without punctuation, blanks as hyphens,
-1, -2 for repeated headings. Links inside code are no links. A path begins with one of FOLDERS;
capitals alone (NAME, CASE) stand for any.
"""
import pathlib
import re
import sys

FOLDERS = ["bench", "cmake", "docs", "host", "kernels", "scenes", "tests"]
LINK = re.compile(r"\[[^\]]*\]\(([^()\s]+(?:\([^()]*\))?)\)|^\[[^\]]+\]:\s*(\S+)", re.MULTILINE)
FENCE = re.compile(r"^(```|~~~).*?^\1", re.MULTILINE | re.DOTALL)
CODE = re.compile(r"`[^`\n]*`")
PATH = re.compile(r"`((?:%s)/[\w./-]+)`" % "|".join(FOLDERS))
SKIPPED = {".git", "build"}  # folders of other people's files


def pages_of(root):
    return sorted(page for page in root.rglob("*.md")
                  if not SKIPPED & set(page.relative_to(root).parts))


def anchors_of(text):
    anchors = []
    for heading in re.findall(r"^#{1,6}\s+(.*?)\s*#*$", FENCE.sub("", text), re.MULTILINE):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
        slug = re.sub(r"[^\w\- ]", "", words.lower()).replace(" ", "-")
        count = sum(1 for each in anchors if re.fullmatch(re.escape(slug) + r"(-\d+)?", each))
        anchors.append(f"{slug}-{count}" if count else slug)
    return anchors


def faults_of(root, page, anchors):
    prose = FENCE.sub("", page.read_text())
    for path in PATH.findall(prose):
        if not re.search(r"(?<![A-Za-z])[A-Z]{3,}(?![A-Za-z])",
                         path) and not (root / path).exists():
            yield f"{page.relative_to(root)}: `{path}`: no such file"
    text = CODE.sub("", prose)
    for inline, reference in LINK.findall(text):
        link = inline or reference
        if re.match(r"\w+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        where = f"{page.relative_to(root)}: '{link}'"
        if not target.exists():
            yield f"{where}: no such file"
        elif root not in (target, *target.parents):
            yield f"{where}: leads out of the repository"
        elif anchor and target.suffix == ".md" and anchor not in anchors(target):
            yield f"{where}: no such heading; there are: {', '.join(anchors(target))}"


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    anchors_by_page = {}

    def anchors(page):
        if page not in anchors_by_page:
            anchors_by_page[page] = anchors_of(page.read_text())
        return anchors_by_page[page]

    pages = pages_of(root)
    if len(pages) < 3:
        raise SystemExit(f"{root}: {len(pages)} pages")
    faults = [fault for page in pages for fault in faults_of(root, page, anchors)]
    print("\n".join(faults) or f"{len(pages)} pages: every link leads somewhere")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
