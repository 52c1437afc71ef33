#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks what pages point at: links to files and to headings, paths of the project in `code`, such as `src/scalar/strict.h`,
and names of the interface, such as cw_closest. Names file, line and target of each that is not there."""

import glob
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PATH = re.compile(r"`((?:src|simd|bench|tests|include|papers)/[\w./*-]+)`")


NAME = re.compile(r"\b(?:cw|CW)_\w+")


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def headings(path):
    """Their names in links, as GitHub makes them."""
    text = re.sub(r"^```.*?^```", "", read(path), flags=re.MULTILINE | re.DOTALL)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
            for heading in re.findall(r"^#+ +(.*?) *$", text, re.MULTILINE)}


def known_names(root):
    """All names of the interface's form in the sources."""
    files = [file for folder in ("include", "src", "simd")
             for file in glob.glob(os.path.join(root, folder, "**/*.[ch]"), recursive=True)]
    return {name for file in files for name in NAME.findall(read(file))}


def missing(path, root, known):
    """(line, target) of each link, path and name that leads nowhere."""
    text = read(path)
    prose = re.sub(r"^```.*?^```", lambda match: re.sub(r"[^\n]", " ", match[0]), text, flags=re.MULTILINE | re.DOTALL)
    for match in re.finditer(r"\]\(\s*([^()\s]+)\)", prose):
        file, _, heading = match[1].partition("#")
        target = os.path.normpath(os.path.join(os.path.dirname(path), file)) if file else path
        if "://" in match[1]:
            continue
        if not os.path.exists(target) or (heading and heading not in headings(target)):
            yield text.count("\n", 0, match.start()) + 1, match[1]
    for match in PATH.finditer(prose):
        if "NAME" not in match[1] and not glob.glob(os.path.join(root, match[1])):
            yield text.count("\n", 0, match.start()) + 1, match[1]
    for match in NAME.finditer(text):
        if match[0] not in known and not match[0].endswith("_") and os.path.basename(path) != "CHANGELOG.md":
            yield text.count("\n", 0, match.start()) + 1, match[0]


def main(root):
    known, folders = known_names(root), ("bench/**", "papers/**", "simd", "src/**", "tests/**", "")
    pages = sorted({page for folder in folders for page in glob.glob(os.path.join(root, folder, "*.md"), recursive=True)})
    wrong = [f"{os.path.relpath(page, root)}:{line}: {target} is not there" for page in pages for line, target in missing(page, root, known)]
    for line in wrong:
        print(line)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1] if len(sys.argv) > 1 else ROOT))
