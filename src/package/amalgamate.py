#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The library as a few files to drop into another program's sources: its two headers, cellwalk.c, and one or two files for each instruction
set, as some of its kernels have vectors of two registers. Argument: the folder to write them to."""
import pathlib
import re
import sys

SOURCE = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = [SOURCE / name for name in ("src/base", "src/core", "src/core/dispatch", "src/core/bounds", "simd", "simd/vocabulary")]
HEADERS = "cellwalk.h", "cellwalk_expert.h"
VERSION = re.search(r'CW_VERSION +"(.*)"', (SOURCE / "include/cellwalk.h").read_text()).group(1)
# Rows of simd/isas.cmake, and the kernels' files for one lane and for more.
ISAS = re.findall(r"^ *cellwalk_isa\((\w+) (\d+) ?([^)]*)\)", (SOURCE / "simd/isas.cmake").read_text(), re.M)
KINDS = [kinds.split() for kinds in re.findall(r"set\(kinds\w* (.*?)\)", (SOURCE / "simd/CMakeLists.txt").read_text())]

TOP = """/* SPDX-License-Identifier: Apache-2.0 */
/* Cellwalk {version}, {name}: generated from the sources of the project, where changes belong. One command compiles all files, such as
 *
 *     cc -std=c17 -O3 -fno-math-errno -fno-trapping-math -c cellwalk*.c
 *
 * Without -ffast-math and -ffp-contract=fast. Programs are linked with -lm -pthread. */
"""
# No multiply and add is fused: else widths disagree in their bits.
EXACT = """#define _GNU_SOURCE
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#pragma clang diagnostic ignored "-Wunused-function"
#else
#pragma GCC optimize("fp-contract=off")
#endif
"""
TARGET = """#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("{0}"))), apply_to = function)
#else
#pragma GCC target("{0}")
#endif
"""
CLANG_POP = """#if defined(__clang__)
#pragma clang attribute pop
#endif
"""


def machine(name):
    return "__aarch64__" if name == "neon" else "__x86_64__"


def lines_of(file, done, vocabulary=None):
    """Those of a file, with the project's headers in the place where they are first included, but for the two that users have."""
    for line in file.read_text().splitlines():
        include = re.match(r'#include (?:"(.*)"|CELLWALK_VOCABULARY)', line)
        if not include or include.group(1) in HEADERS:
            if not line.startswith("/* SPDX"):
                yield line
            continue
        name = include.group(1) or vocabulary
        header = next(folder / name for folder in (file.parent, *FOLDERS) if (folder / name).is_file()).resolve()
        if header not in done:
            done.add(header)
            yield from lines_of(header, done, vocabulary)


def core():
    """All but the kernels of simd/, and the table of these for the machine that compiles."""
    for condition in "__x86_64__", "__aarch64__":
        rows = "".join(f" KERNEL({name.upper()},{lanes})" for name, lanes, _ in ISAS if lanes != "1" and machine(name) == condition)
        yield f"#if defined({condition})\n#define CELLWALK_KERNELS{rows}\n#endif"
    yield "#ifndef CELLWALK_KERNELS\n#define CELLWALK_KERNELS\n#endif"
    done = set()
    for file in *sorted((SOURCE / "src/core").rglob("*.c")), *sorted((SOURCE / "src/scalar").glob("*.c")):
        yield from lines_of(file, done)


def kernels(name, lanes, flags, pairs):
    """Those of an instruction set: with vectors of two registers, or the others."""
    kinds = [kind for kind in sum(KINDS[:1 if lanes == "1" else 2], []) if (kind == "lane_pairs") == pairs]
    done, text = set(), []
    for kind in sorted(kinds, reverse=True):  # pyramid before packet: vector_watertight.h takes its choice
        text += lines_of(SOURCE / f"simd/{kind}_kernel.c", done, f"vec_{name}.h")
    # Before the target: functions of the system's headers are not for it.
    includes = sorted({line for line in text if re.match(r'#include ', line)}, key=lambda line: ('"' in line, line))
    if lanes != "1":
        yield f"#if defined({machine(name)})"
    yield from includes
    target = ",".join(flag[2:] for flag in flags.split())
    if target:
        yield TARGET.format(target)
    yield from (line for line in text if line not in includes)
    if target:
        yield CLANG_POP
    if lanes != "1":
        yield "#endif"


def main():
    out = pathlib.Path(sys.argv[1])
    out.mkdir(parents=True, exist_ok=True)
    files = {"cellwalk.c": core()}
    for isa in ISAS:
        files[f"cellwalk_{isa[0]}.c"] = kernels(*isa, False)
        if isa[1] != "1":
            files[f"cellwalk_{isa[0]}_pairs.c"] = kernels(*isa, True)
    for name, lines in files.items():
        (out / name).write_text(TOP.format(version=VERSION, name=name) + EXACT + "\n".join(lines) + "\n")
    for name in HEADERS:
        (out / name).write_text((SOURCE / "include" / name).read_text())


main()
