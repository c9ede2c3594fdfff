#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""page.py [--check]: makes the PAGES in docs, each of its text here and of what the cases have left in docs/validation.

{{case.name}} in the text stands for the text `name` of docs/validation/case.json; {{all.minutes}} for what all take.
--check writes nothing: it ends with status 1 when a page is not what the text and the stored numbers give, or a
figure that it shows is not there.
"""
import json
import pathlib
import re
import sys

HERE = pathlib.Path(__file__).resolve().parent
DOCS = HERE.parents[1] / "docs"
PAGES = ("validation.md", "choices.md")
PLACE = re.compile(r"\{\{([\w-]+)\.([\w.-]+)\}\}")


def made(page):
    texts = {file.stem: json.loads(file.read_text()) for file in (DOCS / "validation").glob("*.json")}
    texts["all"] = {"minutes": f"{sum(float(case['seconds']) for case in texts.values()) / 60:.0f}"}

    def stored(place):
        case, name = place.groups()
        if name not in texts.get(case, {}):
            sys.exit(f"{page}.in asks for {place.group()}, which docs/validation/{case}.json has not: "
                     f"build the target validation-{case}, or correct the name")
        return texts[case][name]

    return PLACE.sub(stored, (HERE / f"{page}.in").read_text())


def main():
    for page in PAGES:
        text = made(page)
        if sys.argv[1:] != ["--check"]:
            (DOCS / page).write_text(text)
            continue
        if (DOCS / page).read_text() != text:
            sys.exit(f"docs/{page} is not what bench/validation/{page}.in and docs/validation/*.json give: "
                     "run bench/validation/page.py")
        missing = [name for name in re.findall(r"\]\((validation/[^)]+)\)", text) if not (DOCS / name).exists()]
        if missing:
            sys.exit(f"docs/{page} shows what is not there: {', '.join(missing)}")
        print(f"docs/{page} is what its text and numbers give")


if __name__ == "__main__":
    main()
