# SPDX-License-Identifier: Apache-2.0
"""Markdown: tables, and the blocks of a page that stand between <!-- begin:NAME --> and <!-- end:NAME -->."""

import os
import re

from results import Problem


def table(head, rows, align=None):
    """align: a letter a column, l or r; by default the first column left and the rest right."""
    align = align or "l" + "r" * (len(head) - 1)
    lines = [head, None, *rows]
    return "".join("|" + "".join("---|" if a == "l" else "--:|" for a in align) + "\n" if line is None else
                   "|" + "".join(f" {cell} |" if cell != "" else " |" for cell in line) + "\n" for line in lines)


def grouped(number):
    """1234567 as 1 234 567."""
    return f"{int(number):,}".replace(",", " ")


def three(number):
    """Three significant digits, and no exponent from 1000 on: 0.128, 12.8, 12 800."""
    return grouped(float(f"{number:.3g}")) if abs(number) >= 999.5 else f"{number:.3g}"


def listed(texts):
    """a, b and c."""
    *first, last = texts
    return f"{', '.join(first)} and {last}" if first else last


def duration(seconds):
    """35 µs, 8.89 ms, 105 s."""
    scale, unit = (1, "s") if seconds >= 1 else (1e3, "ms") if seconds >= 1e-3 else (1e6, "µs")
    return f"{seconds * scale:.3g} {unit}"


def ratio(above, below, form=".2f"):
    """An empty cell unless both are there."""
    return format(above / below, form) if above and below else ""


class Page:
    def __init__(self, path):
        self.path = path
        try:
            with open(path, encoding="utf-8", newline="") as file:
                self.text = file.read()
        except OSError as error:
            raise Problem(f"{path}: {error.strerror}") from None

    def names(self):
        return re.findall(r"^<!-- begin:([\w-]+) -->$", self.text, re.MULTILINE)

    def span(self, name):
        """Where the block's text begins and ends."""
        places = []
        for marker in (f"<!-- begin:{name} -->", f"<!-- end:{name} -->"):
            if self.text.count(marker) != 1:
                raise Problem(f"{self.path}: has {self.text.count(marker)} lines {marker}; want one")
            places.append(self.text.index(marker))
        begin, end = places[0] + len(f"<!-- begin:{name} -->\n"), places[1]
        if end < begin:
            raise Problem(f"{self.path}: <!-- end:{name} --> stands before <!-- begin:{name} -->")
        return begin, end

    def difference(self, name, text):
        """None, or the first line in which the block is not that text: its number, the page's line, the line wanted."""
        begin, end = self.span(name)
        first = self.text.count("\n", 0, begin) + 1
        have, want = self.text[begin:end].split("\n"), text.split("\n")
        for k in range(max(len(have), len(want))):
            pair = [lines[k] if k < len(lines) else None for lines in (have, want)]
            if pair[0] != pair[1]:
                return (first + k, *pair)
        return None

    def put(self, name, text):
        begin, end = self.span(name)
        self.text = self.text[:begin] + text + self.text[end:]

    def save(self):
        """All of it or nothing."""
        unfinished = self.path + ".unfinished"
        try:
            with open(unfinished, "w", encoding="utf-8", newline="") as file:
                file.write(self.text)
            os.replace(unfinished, self.path)
        except OSError as error:
            raise Problem(f"{self.path}: {error.strerror}") from None
        finally:
            if os.path.exists(unfinished):
                os.remove(unfinished)
