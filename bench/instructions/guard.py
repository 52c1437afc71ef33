#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The guard against slow-downs: counts the instructions of the plan "guard" under callgrind and compares them with committed figures, so
that a slow-down is found without timing.

Instructions repeat to the last digit, on a loaded machine and on another one, because callgrind simulates a CPU with a fixed set
of features (up to AVX2, without AVX-512). They do not show cache and TLB misses, mispredicted branches, slow instructions in place
of fast ones, and waiting. Another compiler makes other code, so the figures hold for one compiler and one set of flags, and every
other build is skipped.

Exit status: 0 within the tolerance, 1 beyond it or failed, 77 if there is nothing to compare."""

import argparse
import json
import os
import shutil
import subprocess
import sys

TOLERANCE = 2  # per cent: for changes of the source that mean nothing, such as a constant in another register
SKIPPED = 77
HEADING = "workload,contender,count,instructions"


def counts(profile, program):
    """The instructions of each part of a callgrind profile, in order. Only code of the program itself counts: libc and libm choose
    their functions by the CPU. "part:" begins a run; "ob=" names the file whose code the next lines count; after "calls=" one line
    has the counts of a whole call, which other lines count too."""
    parts, own, of_call = [], False, False
    for line in profile:
        if line.startswith("part:"):
            parts.append(0)
            own = of_call = False
        elif line.startswith("ob="):
            own = os.path.basename(line[3:].strip()) == program
        elif line.startswith("calls="):
            of_call = True
        elif line[:1].isdigit():
            if own and not of_call and parts:
                parts[-1] += int(line.split()[1])
            of_call = False
    return parts


def join(results, parts):
    """Results of measure with their counts: {workload,contender: (rays, instructions)}; and those that cannot run here."""
    found, absent, parts = {}, set(), iter(parts)
    for line in map(json.loads, results):
        name = f"{line.get('workload')},{line.get('contender')}"
        if "counted" in line:
            found[name] = (line["counted"], next(parts))
        elif "left_out" in line:
            absent.add(name)
    if not found or any(count == 0 for _, count in found.values()):
        raise SystemExit("guard.py: callgrind counted nothing of the work")
    return found, absent


def read(path):
    """Compiler, flags and figures of the committed file."""
    about, figures = {}, {}
    with open(path, encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            line = line.rstrip("\n")
            if line.startswith("# ") and ": " in line:
                about.update([line[2:].split(": ", 1)])
            elif not line.startswith("#") and line != HEADING:
                name, *words = line.rsplit(",", 2)
                if len(words) != 2 or not "".join(words).isdigit():
                    raise SystemExit(f"{path}:{number}: not a line of figures")
                figures[name] = (int(words[0]), int(words[1]))
    return about.get("compiler"), about.get("flags"), figures


def compare(committed, now, absent):
    """Sentences on what is not as it should be, and whether any of it is bad."""
    sentences, bad = [], False
    for name, (count, instructions) in now.items():
        if committed.get(name, (0,))[0] != count:
            sentences.append(f"{name}: no figure for {count} rays")
            bad = True
            continue
        before = committed[name][1]
        if abs(instructions - before) * 100 > before * TOLERANCE:
            change = 100 * (instructions / before - 1)
            sentences.append(f"{name}: {instructions} instructions ({instructions / count:.1f} a ray), {change:+.1f} % from {before}")
            bad = bad or instructions > before
    for name in committed.keys() - now.keys():
        if name not in absent:
            sentences.append(f"{name}: there is a figure, but this program does not trace them")
            bad = True
    return sentences, bad


def run(work, folder):
    name = os.path.join(folder, "guard")
    command = ["valgrind", "-q", "--tool=callgrind", "--collect-atstart=no", "--toggle-collect=measure_counted",
               "--dump-after=measure_counted", "--combine-dumps=yes", "--compress-strings=no", "--compress-pos=no",
               f"--callgrind-out-file={name}.callgrind", work, "measure", "guard", "--count", "256", "--no-pin", "-o", f"{name}.jsonl"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"guard.py: valgrind on {work}: {done.stderr.strip()}")
    with open(f"{name}.callgrind", encoding="utf-8", errors="replace") as profile, open(f"{name}.jsonl", encoding="utf-8") as results:
        return join(results, counts(profile, os.path.basename(work)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["check", "update"])
    parser.add_argument("work", help="the program cellwalk-bench")
    parser.add_argument("figures", help="guard.csv")
    parser.add_argument("--compiler", required=True)
    parser.add_argument("--flags", required=True)
    parser.add_argument("--folder", default=".", help="for guard.callgrind, which callgrind_annotate reads (.)")
    options = parser.parse_args()
    if shutil.which("valgrind") is None:
        print("skipped: valgrind is not installed (Debian: valgrind)")
        return SKIPPED
    compiler, flags, committed = read(options.figures) if os.path.exists(options.figures) else (None, None, {})
    other = committed and (compiler, flags) != (options.compiler, options.flags)
    if other and options.what == "check":
        print(f"skipped: the figures hold for {compiler} with {flags},\nthis build is by {options.compiler} with {options.flags}")
        return SKIPPED
    now, absent = run(options.work, options.folder)
    if options.what == "check":
        sentences, bad = compare(committed, now, absent)
        print("\n".join([*sentences, f"{len(now)} counts, tolerance {TOLERANCE} %, {len(absent)} of kernels that cannot run here"]))
        if sentences:
            print("If this is meant, rewrite the figures and commit them with the change that explains them:\n"
                  "  cmake --build --preset ci --target guard-update")
        return 1 if bad else 0
    kept = {name: figure for name, figure in committed.items() if name in absent and not other}
    with open(options.figures + ".new", "w", encoding="utf-8") as file:
        file.write("# Instructions of the plan guard; written by the build target guard-update.\n"
                   f"# compiler: {options.compiler}\n# flags: {options.flags}\n{HEADING}\n")
        for name, (count, instructions) in {**now, **kept}.items():
            file.write(f"{name},{count},{instructions}\n")
    os.replace(options.figures + ".new", options.figures)
    print(f"{options.figures} is rewritten")
    return 0


if __name__ == "__main__":
    sys.exit(main())
