#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Instructions a ray on aarch64 beside x86-64, counted in QEMU's emulators by one plugin (bench/instructions/qemu_counts.c), and
whether both give the same answers. Writes papers/data/neon.json."""

import argparse
import datetime
import json
import os
import subprocess
import sys
import tempfile

from results import Problem


def run(*command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        raise Problem(f"status {done.returncode}: {' '.join(command)}\n{done.stderr.strip()}")
    return done.stdout, done.stderr


def counted(emulator, plugin, program, kernel, field, rays):
    """For each class of rays its name, number of rays and instructions; and a hash of all answers."""
    out, err = run(*emulator, "-plugin", plugin, program, kernel, field, rays)
    runs = [line.split(",") for line in out.splitlines() if line.startswith("run,")]
    *counts, answers = err.split()
    if not runs or len(runs) != len(counts):
        raise Problem(f"{program}: {len(runs)} classes of rays, {len(counts)} counts")
    return [(words[4], int(words[5]), int(count)) for words, count in zip(runs, counts)], answers


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--x86", default="build/ci/bench/instructions/cellwalk-counted-work")
    parser.add_argument("--aarch64", default="build/aarch64/bench/instructions/cellwalk-counted-work")
    parser.add_argument("--libraries", default="/usr/aarch64-linux-gnu", help="root of aarch64's C library")
    parser.add_argument("--json", default="papers/data/neon.json")
    options = parser.parse_args()
    commit = run("git", "rev-parse", "--short=10", "HEAD")[0].strip()
    lines = [{"kind": "run", "command": "neon", "arguments": " ".join(sys.argv[1:]), "isa": "sse4.2, neon",
              "compiler": run("aarch64-linux-gnu-gcc", "--version")[0].splitlines()[0], "commit": commit,
              "emulator": run("qemu-aarch64", "--version")[0].splitlines()[0],
              "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")}]
    with tempfile.TemporaryDirectory() as folder:
        plugin = os.path.join(folder, "counts.so")
        run("cc", "-O2", "-shared", "-fPIC", "-o", plugin, "bench/instructions/qemu_counts.c")
        for kernel, field, rays in (("packet4", "65", "8192"), ("packet4", "1025", "1024"), ("pyramid4", "65", "8192"),
                                    ("pyramid4", "1025", "8192")):
            sse42, answers = counted(["qemu-x86_64"], plugin, options.x86, kernel, field, rays)
            neon, same = counted(["qemu-aarch64", "-L", options.libraries], plugin, options.aarch64, kernel, field, rays)
            if answers != same:
                raise Problem(f"{kernel}, {field}: the answers differ")
            for (name, count, x86), (_, _, arm) in zip(sse42, neon):
                lines.append({"kind": "neon", "kernel": kernel, "field": field, "rays": name, "ray_count": count,
                              "sse42": x86, "neon": arm, "answers": answers})
                print(f"{kernel} {field} {name}: {x86 / count:.0f} {arm / count:.0f} {arm / x86:.2f}")
    with open(options.json, "w", encoding="utf-8") as file:
        file.writelines(json.dumps(line, separators=(",", ":")) + "\n" for line in lines)


if __name__ == "__main__":
    try:
        main()
    except (OSError, Problem) as error:
        sys.exit(f"count_neon.py: {error}")
