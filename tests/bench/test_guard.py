# SPDX-License-Identifier: Apache-2.0
"""The guard's reading of callgrind's profiles and of its own figures, and its verdicts."""
import os
import pathlib
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(os.environ["CELLWALK_SOURCE"]) / "bench" / "instructions"))
import guard  # noqa: E402

PROFILE = """version: 1
part: 1
ob=/some/where/work
fn=a
10 100
calls=1 20
11 5000
12 7
ob=/lib/libm.so
1 900
part: 2
ob=/some/where/work
10 55
""".splitlines()


def test_only_the_programs_own_code_counts_once():
    assert guard.counts(PROFILE, "work") == [107, 55]


def test_parts_go_to_runs_in_order():
    lines = ['{"kind": "run"}', '{"workload": "65/primary", "contender": "cell", "counted": 16}',
             '{"workload": "65/ao", "contender": "packet16", "left_out": "why"}', '{"workload": "65/ao", "contender": "cell", "counted": 8}']
    found, absent = guard.join(lines, [107, 55])
    assert found == {"65/primary,cell": (16, 107), "65/ao,cell": (8, 55)} and absent == {"65/ao,packet16"}
    with pytest.raises(SystemExit, match="counted nothing"):
        guard.join(lines, [107, 0])


@pytest.mark.parametrize("now, absent, sentences, bad", [
    ({"a": (8, 1000), "b": (8, 1000)}, set(), 0, False),
    ({"a": (8, 1020), "b": (8, 980)}, set(), 0, False),
    ({"a": (8, 1021), "b": (8, 1000)}, set(), 1, True),
    ({"a": (8, 1000), "b": (8, 979)}, set(), 1, False),
    ({"a": (9, 1000), "b": (8, 1000)}, set(), 1, True),
    ({"a": (8, 1000), "b": (8, 1000), "c": (8, 1)}, set(), 1, True),
    ({"a": (8, 1000)}, set(), 1, True),
    ({"a": (8, 1000)}, {"b"}, 0, False),
])
def test_verdicts(now, absent, sentences, bad):
    committed = {"a": (8, 1000), "b": (8, 1000)}
    found, is_bad = guard.compare(committed, now, absent)
    assert len(found) == sentences and is_bad == bad


def test_figures_are_read_and_a_damaged_line_is_named(tmp_path):
    path = tmp_path / "guard.csv"
    path.write_text(f"# a note\n# compiler: GNU 12\n# flags: -O3 -x\n{guard.HEADING}\n65/ao,cell:watertight,8,55\n")
    assert guard.read(path) == ("GNU 12", "-O3 -x", {"65/ao,cell:watertight": (8, 55)})
    path.write_text(path.read_text() + "65/ao,cell:watertight,8,-\n")
    with pytest.raises(SystemExit, match="guard.csv:6: not a line of figures"):
        guard.read(path)
