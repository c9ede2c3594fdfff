#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""page.py [--check]: makes the PAGES in docs, and the tables beside them, of what the cases have
left in docs/validation.

In a page's text ({{...}} is replaced, all numbers come from docs/validation/CASE.json):

    {{case.name}}                      the text `name` of a case
    {{case.name[row][column]}}         one cell of a table: the row with a cell `row`, the column
    with that head.
                                       [a & b][column]: the row with both cells; [row][head #2]: the
                                       second such head
    {{case.name[][a; b]}}              the table with the columns a and b alone, in this order
    {{case.name[x; y][]}}              the table with the rows x and y alone
    {{case.tables}}                    links to the case's tables, but that of its checks;
    {{all.minutes}}: what all cases take

Each table of a case is also written whole as docs/validation/tables/CASE-NAME.csv.

--check writes nothing: it ends with status 1 when a page or a table is not what the texts and the
stored numbers give, when the folder of tables holds a file that no case has made, or when a page
shows a file that is missing.
"""
import csv
import io
import json
import pathlib
import re
import sys

HERE = pathlib.Path(__file__).resolve().parent
DOCS = HERE.parents[1] / "docs"
TABLES = DOCS / "validation" / "tables"
PAGES = ("validation.md", "choices.md")
PLACE = re.compile(r"\{\{([\w-]+)\.([\w.-]+)(?:\[([^]]*)\]\[([^]]*)\])?\}\}")


class Table:
    """A table of a case, as common.markdown has written it."""

    def __init__(self, text):
        head, _, *rows = ([cell.strip() for cell in line.strip().strip("|").split("|")]
                          for line in text.split("\n"))
        if any(len(row) != len(head) for row in rows):
            sys.exit(f"a table has rows of another length than its head: {' | '.join(head)}. No "
                     "cell may hold '|'")
        self.head, self.rows = head, rows

    def picked(self, rows, columns):
        """The named rows and columns; no names: all of them. Raises KeyError with a name that is
        missing or ambiguous."""
        at = [column_of(self.head, name) for name in names_of(columns)] or range(len(self.head))
        chosen = [row_of(self.rows, name) for name in names_of(rows)] or self.rows
        return Table.of([self.head[i] for i in at], [[row[i] for i in at] for row in chosen])

    @classmethod
    def of(cls, head, rows):
        table = cls.__new__(cls)
        table.head, table.rows = head, rows
        return table

    def markdown(self):
        lines = ["| " + " | ".join(self.head) + " |", "|" + "---|" * len(self.head)]
        return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in self.rows])

    def csv(self):
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([[re.sub(r"[`*]", "", cell) for cell in row]
                                                         for row in (self.head, *self.rows)])
        return text.getvalue()


def names_of(names):
    return [name.strip() for name in names.split(";")] if names.strip() else []


def column_of(head, name):
    name, _, which = name.partition(" #")
    found = [i for i, cell in enumerate(head) if cell == name]
    if not which and len(found) != 1 or which and not 1 <= int(which) <= len(found):
        raise KeyError(f"{len(found)} columns are called '{name}'")
    return found[int(which or 1) - 1]


def row_of(rows, name):
    found = [row for row in rows if set(name.split(" & ")) <= set(row)]
    if len(found) != 1:
        raise KeyError(f"{len(found)} rows have the cells '{name}'")
    return found[0]


def is_table(text):
    return text.startswith("|")


def stored():
    return {file.stem: json.loads(file.read_text())
            for file in sorted((DOCS / "validation").glob("*.json"))}


def made_tables(texts):
    """All files of the folder of tables: {name: text}."""
    return {f"{case}-{name}.csv": Table(text).csv()
            for case, own in texts.items() for name, text in own.items() if is_table(text)}


def links(case, own):
    names = sorted(name for name, text in own.items() if is_table(text) and name != "checks")
    return ", ".join(f"[{name}](validation/tables/{case}-{name}.csv)" for name in names)


def made_page(page, texts):
    extra = {case: {"tables": links(case, own)} for case, own in texts.items()}
    extra["all"] = {"minutes": f"{sum(float(case['seconds']) for case in texts.values()) / 60:.0f}"}

    def value(place):
        case, name, rows, columns = place.groups()
        text = texts.get(case, {}).get(name) or extra.get(case, {}).get(name)
        if text is None:
            sys.exit(f"{page}.in asks for {place.group()}, which docs/validation/{case}.json has "
                     "not: "
                     f"build the target validation-{case}, or correct the name")
        if rows is None:
            return text
        try:
            table = Table(text).picked(rows, columns)
        except KeyError as error:
            sys.exit(f"{page}.in asks for {place.group()}: {error.args[0]}")
        one_cell = len(names_of(rows)) == 1 and len(names_of(columns)) == 1
        return table.rows[0][0] if one_cell else table.markdown()

    return PLACE.sub(value, (HERE / f"{page}.in").read_text())


def check(files, texts):
    for path, text in files.items():
        if not path.exists() or path.read_text() != text:
            sys.exit(f"{path.relative_to(DOCS.parent)} is not what bench/validation/*.md.in and "
                     "docs/validation/*.json "
                     "give: run bench/validation/page.py")
    strange = [file.name for file in TABLES.iterdir() if file not in files]
    if strange:
        sys.exit(f"docs/validation/tables holds what no case has made: {', '.join(strange)}")
    for page in PAGES:
        missing = [name for name in re.findall(r"\]\((validation/[^)]+)\)", files[DOCS / page])
                   if not (DOCS / name).exists()]
        if missing:
            sys.exit(f"docs/{page} shows files that are missing: {', '.join(missing)}")
    print(f"{len(PAGES)} pages and {len(files) - len(PAGES)} tables are what their texts and "
          f"{len(texts)} cases give")


def main():
    texts = stored()
    files = {DOCS / page: made_page(page, texts) for page in PAGES}
    files |= {TABLES / name: text for name, text in made_tables(texts).items()}
    if sys.argv[1:] == ["--check"]:
        check(files, texts)
        return
    TABLES.mkdir(exist_ok=True)
    for file in TABLES.iterdir():
        if file not in files:
            file.unlink()
    for path, text in files.items():
        path.write_text(text)


if __name__ == "__main__":
    main()
