#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Counts what makes pages hard to read: sentences of more than 35 words, a high average, and habits of style that readers
stumble over. Prints warnings with file and line; the status is always 0."""

import argparse
import os
import re

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PAGES = ("README.md", "papers/using.md", "papers/report.md")
LONGEST, AVERAGE = 35, 20  # words a sentence
SAYING = "(?:say|explain|show|describe|state|list|define|decide|count|see|measure|know)(?:s|n|d|ed)?"
THINGS = "(?:it|rays?|fields?|kernels?|tables?|files?|tests?|librar(?:y|ies)|programs?|walks?|nodes?|cells?|columns?)"
TICS = {
    '"what" as a noun': r"\bwhat\b",
    '"whoever"': r"\b(?:whoever|whatever|whichever)\b",
    '"taken for"': r"\btaken for\b|\btakes? (?:it|the \w+) for\b",
    '"tells of"': r"\btells? of\b",
    '"as well" at the end': r"\bas well(?=[.,;:)])",
    '"of its own"': r"\bof (?:its|their) own\b",
    '"by itself"': r"\bby (?:itself|themselves)\b",
    "a negated relative clause": r"\b(?:that|which|who) (?:is|are|was|were|has|have) no\b",
    "a thing that acts like a person": rf"\b{THINGS} (?:asks?|wants?|hears?|knows?|looks? (?:at|for))\b",
}


def paragraphs(text):
    """(line, text) of prose: no code, tables, headings, comments, pictures; each item of a list is a paragraph."""
    text = re.sub(r"^```.*?^```|<!--.*?-->", lambda match: re.sub(r"[^\n]", "", match[0]), text, flags=re.MULTILINE | re.DOTALL)
    lines, first = [], 0
    for number, line in enumerate([*text.split("\n"), ""], 1):
        skipped = re.match(r"\s*(?:\||#|!\[|$)", line)
        item = re.match(r"\s*(?:[-*]|\d+\.) +", line)
        if lines and (skipped or item):
            yield first, " ".join(lines)
            lines = []
        if not skipped:
            first = first if lines else number
            lines.append(line[item.end():].strip() if item else line.strip())


def plain(text):
    """Links and code as one would read them aloud; code is one word."""
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"^(\*\*[^*]+\*\*):", r"\1", text)  # the word that begins an item
    return re.sub(r"\*+", "", re.sub(r"`[^`]*`", "`code`", text))


def sentences(paragraph):
    return [part for part in re.split(r"(?<=[.!?])(?:[)\"”]*)\s+(?=[\"“(]?[A-Z0-9`])", plain(paragraph)) if part.strip()]


def words(sentence):
    return len([word for word in sentence.split() if re.search(r"\w", word)])


def warnings(text):
    """(line, warning) of each fault, and the numbers of words of all sentences."""
    found, counts = [], []
    for line, paragraph in paragraphs(text):
        for sentence in sentences(paragraph):
            counts.append(words(sentence))
            start = " ".join(sentence.split()[:6])
            if counts[-1] > LONGEST:
                found.append((line, f'a sentence of {counts[-1]} words: "{start} ..."'))
            if len(re.findall(r"[:;](?=\s)", sentence)) > 1:
                found.append((line, f'a chain of ":" and ";": "{start} ..."'))
            for name, pattern in TICS.items():
                for match in re.finditer(pattern, sentence, re.IGNORECASE):
                    before = sentence[:match.start()]
                    asked = name.startswith('"what"') and (sentence.endswith("?") or re.search(rf"\b{SAYING}:? (?:\w+ )?$", before))
                    if not asked:
                        found.append((line, f'{name}: "...{before[-24:]}{match[0]}{sentence[match.end():match.end() + 16]}..."'))
    return found, counts


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pages", nargs="*", help=f"default: {', '.join(PAGES)}")
    for page in parser.parse_args().pages or [os.path.join(ROOT, page) for page in PAGES]:
        with open(page, encoding="utf-8") as file:
            found, counts = warnings(file.read())
        name, average = os.path.relpath(page), sum(counts) / max(len(counts), 1)
        for line, text in found:
            print(f"{name}:{line}: {text}")
        above = f", above {AVERAGE}" if average > AVERAGE else ""
        print(f"{name}: {len(counts)} sentences, {average:.1f} words on average{above}, {max(counts, default=0)} at most; "
              f"{len(found)} warnings")


if __name__ == "__main__":
    main()
