# SPDX-License-Identifier: Apache-2.0
"""Results of cellwalk-bench: files of JSON lines, the first of kind "run". Every mistake names file, line and key."""

import json
import math
import os


class Problem(Exception):
    """What is wrong, for the user. Programs print it and exit with status 1."""


class Line(dict):
    """One JSON object of a file. number() and text() insist on their type; with a default the key may be missing."""

    def __init__(self, members, where):
        super().__init__((key, Line(value, where) if isinstance(value, dict) else value)
                         for key, value in members.items())
        self.where = where

    def __missing__(self, key):
        raise Problem(f'{self.where}: has no key "{key}"')

    def number(self, key, default=None):
        if key not in self and default is not None:
            return default
        value = self[key]
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise Problem(f'{self.where}: "{key}" is {json.dumps(value)}; want a number')
        return value

    def text(self, key, default=None):
        if self.get(key) is None and default is not None:
            return default
        value = self[key]
        if not isinstance(value, str):
            raise Problem(f'{self.where}: "{key}" is {json.dumps(value)}; want a text')
        return value

    def inner(self, key):
        value = self[key]
        if not isinstance(value, Line):
            raise Problem(f'{self.where}: "{key}" is {json.dumps(value)}; want an object')
        return value

    def lines(self, key):
        value = self[key]
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            raise Problem(f'{self.where}: "{key}" is {json.dumps(value)}; want an array of objects')
        return [Line(item, self.where) for item in value]


class Results:
    """The lines of one file."""

    def __init__(self, path):
        self.path, self.lines = path, []
        try:
            with open(path, encoding="utf-8") as file:
                texts = file.read().splitlines()
        except (OSError, UnicodeDecodeError) as error:
            raise Problem(f"{path}: {getattr(error, 'strerror', None) or 'is not UTF-8'}") from None
        for number, text in enumerate(texts, 1):
            where = f"{path}:{number}"
            try:
                members = json.loads(text)
            except json.JSONDecodeError as error:
                raise Problem(f"{where}: is not JSON: {error.msg}, column {error.colno}") from None
            if not isinstance(members, dict):
                raise Problem(f"{where}: is not a JSON object")
            self.lines.append(Line(members, where))
        if not self.lines or self.lines[0].get("kind") != "run":
            raise Problem(f'{path}:1: not results of cellwalk-bench: they begin with an object of kind "run"')

    @property
    def run(self):
        return self.lines[0]

    def of(self, kind, **texts):
        """All lines of that kind with these texts, in order."""
        return [line for line in self.lines
                if line.get("kind") == kind and all(line.get(key) == value for key, value in texts.items())]

    def some(self, kind):
        """The same, of which there has to be one."""
        found = self.of(kind)
        if not found:
            raise Problem(f'{self.path}: has no line of kind "{kind}"')
        return found

    def first(self, kind, **texts):
        found = self.of(kind, **texts)
        return found[0] if found else None

    def distinct(self, key, kind="result", **texts):
        """The values of a key in lines of that kind, in order of first appearance."""
        return list(dict.fromkeys(line.text(key) for line in self.of(kind, **texts) if key in line))


class Data:
    """A folder of results; each file is read when it is first asked for."""

    def __init__(self, folder):
        self.folder, self.files = folder, {}

    def get(self, name):
        """None if there is no such file."""
        path = os.path.join(self.folder, name)
        if name not in self.files:
            self.files[name] = Results(path) if os.path.exists(path) else None
        return self.files[name]

    def files_there(self):
        return {os.path.relpath(os.path.join(folder, file), self.folder)
                for folder, _, files in os.walk(self.folder) for file in files if file.endswith(".json")}

    def __getitem__(self, name):
        if self.get(name) is None:
            raise Problem(f"{os.path.join(self.folder, name)}: is missing; papers/scripts/README.md says what makes it")
        return self.files[name]


def run_text(run):
    """On what machine and with what program a run was made, in one line."""
    if "commit" not in run:
        return "The file records neither commit nor machine"
    if "cpu" not in run:
        return f"Commit {run.text('commit')}, {run.text('date')}"
    threads = run.text("threads", "")
    embree = run.text("embree", "none") + (" (compiled with assertions)" if run.get("embree_assertions") else "")
    return (f"{run.text('cpu')}, {run.text('isa')}, {run.text('compiler')}, {run.text('build_type')}, "
            f"commit {run.text('commit')}, Embree {embree}, {threads + ' threads' if threads else 'one thread'}, "
            f"seed {run.number('seed')}, load {run.number('load'):.2f}, {run.text('date')}")


def geometric_mean(values):
    return math.exp(math.fsum(map(math.log, values)) / len(values)) if values else 0
