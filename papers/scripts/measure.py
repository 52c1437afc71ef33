#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes every file of results that the papers quote and cellwalk-bench measures, one after the other. A file that is there
already is kept, so a run that was broken off goes on where it was. For figures to publish nothing else should run on the
machine; making fields and building Embree takes a quarter of an hour more than the time given.

speed-ISA.json          each instruction set: all classes of rays on all fields, the library's kernel and Embree
peers.json              Embree's triangles and grids, normal and robust
widths.json             every width of every walk
beside*.json            rays parallel to a plane, grooves and walls, in one call and one a call
threads.json            one thread, two, and one a CPU
pages-*.json            large fields on huge and on ordinary pages
building.json           memory and building time, Embree at its default quality
scenes/table.json       the six scenes
rays/tradeoff.json      speed and error of rays on coarser fields; the largest takes 9 GB
tradeoff/tradeoff.json  speed and error of horizons, the sky-view factor and pictures
accuracy/accuracy.json  wrong answers; how exact t, u, v, normals and points are
afar.json               rays from far away"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time

from results import Problem, Results

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
ISAS = ["scalar", "sse4.2", "avx2", "avx512"]


def output_of(command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise Problem(f"{' '.join(command)}: ended with status {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def record_of(bench):
    """The record that the program writes into its results: the commit that it is of, and whether it has Embree."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "none.json")
        output_of([bench, "micro", "--rays", "none", "--peer", "none", "--kernel", "cell", "--field", "65", "--json", path])
        return Results(path).run


def widest(kernels, isa, walk="pyramid"):
    """The widest kernel of a walk that an instruction set runs."""
    able = [k["name"] for k in kernels if k["name"].startswith(walk) and ISAS.index(k["isa"]) <= ISAS.index(isa)]
    return able[-1] if able else "cell"


def plan(info, embree, quick):
    """(file, share of the time or 0 where no clock is looked at, command) for each file; no word has a space."""
    kernels, best, cpus = info["kernels"], info["isa"], info["cpus"]
    chosen, packets = widest(kernels, best), widest(kernels, best, "packet")
    rays = "--count 2048" if quick else "--count 131072 --pass 5"
    some = "65" if quick else "257,1025"
    triangles = "triangles" if embree else "none"
    able = [k["name"] for k in kernels if k["available"] and k["name"] != "brute"]
    for isa in reversed(ISAS[1:ISAS.index(best) + 1]):
        fields = "65,257" if quick else "65,257,1025,4097,8193,sea-calm,sea-rough"
        yield (f"speed-{isa.replace('.', '')}.json", 8 if isa == best else 5,
               f"micro --isa {isa} --kernel {widest(kernels, isa)} --peer {triangles} --field {fields} {rays}")
    peers = "triangles,grid,triangles-robust,grid-robust" if embree else "none"
    yield "peers.json", 3, f"micro --kernel {chosen} --peer {peers} --field {some} {rays}"
    walks = ",".join(name for name in able if not name.startswith("grid"))
    yield "widths.json", 3, f"micro --peer {triangles} --field {some} {rays} --kernel {walks}"
    surfaces = "--field " + ("comb" if quick else "plane,grooves,comb,checkerboard") + f" --count {1024 if quick else 16384}"
    for name, option in (("beside", ""), ("beside-single", " --call 1")):
        yield f"{name}.json", 2, f"micro --rays beside --kernel {chosen} --peer {triangles} {surfaces} --pass 3{option}"
    # One CPU has nothing to be faster than, which is a result like another.
    threads = ",".join(str(n) for n in sorted({1, min(2, cpus), cpus}))
    yield ("threads.json", 3, f"micro --threads {threads} --kernel {chosen} --peer none --field {some} "
           + ("--count 16384" if quick else "--count 262144 --pass 5"))
    for pages, option in (("huge", ""), ("small", " --small-pages")):
        yield (f"pages-{pages}.json", 1,
               f"micro --kernel {chosen} --peer none --field {'65' if quick else '1025,4097,8193'} {rays}{option}")
    yield ("building.json", 0, f"micro --rays none --quality medium --kernel {chosen},grid3d "
           f"--peer {'triangles,grid' if embree else 'none'} --field {'65,257' if quick else '65,257,1025,4097,8193'}")
    yield "scenes/table.json", 2, "table" + (" --quick --scene hftest" if quick else "")
    # Most of the time of these goes into making land and answers, so they get a separate time.
    yield ("rays/tradeoff.json", 0, "tradeoff --part rays " +
           ("--quick --seconds 1" if quick else "--land 1025,8193,32769 --seconds 40"))
    yield ("tradeoff/tradeoff.json", 0, "tradeoff --part horizons,sky,pictures " + ("--quick --seconds 1" if quick else "--seconds 30"))
    yield ("accuracy/accuracy.json", 0, f"accuracy --mode strict,moller-trumbore{',embree,embree-robust' if embree else ''},samples-16 "
           f"--kernel {chosen},{packets} --seconds 1 --pass 1000 " +
           ("--count 512 --field 65" if quick else "--field 1025,8193x1025 --count 131072"))
    yield ("afar.json", 2, f"micro --rays random --back 0,1,2,5,20,100,1e6 --kernel {chosen} --peer none "
           # Fewer rays, and so more passes: on large fields, checking the answers takes most of the time.
           f"--field {'65' if quick else '257,1025,4097,8193'} --count {2048 if quick else '32768 --pass 2'}")


def kept(path, commit):
    """What to say of a file that is there: figures of another commit are not to be mixed in unnoticed."""
    try:
        of = Results(path).run.text("commit", "")
    except Problem as problem:
        return f"{path} is there already, but cannot be read: {problem}"
    return f"{path} is there already" + ("" if of == commit else f", of another commit: {of}")


def make(bench, path, words, seconds, seed):
    """True if the file is there."""
    command = [bench, *words.split(), "--seed", str(seed)]
    if seconds > 0:
        command += ["--seconds", f"{seconds:.3g}"]
    # micro takes the file, the others its folder.
    command += ["--json", path] if words.startswith("micro") else ["--out", os.path.dirname(path)]
    os.makedirs(os.path.dirname(path), exist_ok=True)
    status = subprocess.run(command).returncode
    if status < 0:
        raise Problem(f"{path}: stopped by signal {-status}; the same command goes on from here")
    if status == 0 and os.path.exists(path):
        return True
    print(f"measure.py: {path}: ended with status {status}", file=sys.stderr)
    return False


def measure(options):
    info, record = json.loads(output_of([options.tool, "info", "--json"])), record_of(options.bench)
    steps = list(plan(info, record.text("embree", ""), options.quick))
    shares, start, failed = sum(share for _, share, _ in steps), time.monotonic(), 0
    load = os.getloadavg()[0]
    if load > 0.5:
        print(f"The load of this machine is {load:.1f}: other programs disturb the measurement.", file=sys.stderr)
    for number, (file, share, words) in enumerate(steps, 1):
        path = os.path.join(options.out, file)
        at = f"[{number} of {len(steps)}"
        if os.path.exists(path) and not options.again:
            print(f"{at}] {kept(path, record.text('commit', ''))}", file=sys.stderr)
            continue
        print(f"{at}, {time.monotonic() - start:.0f} s] {path}: cellwalk-bench {words}", file=sys.stderr, flush=True)
        failed += not make(options.bench, path, words, options.seconds * share / shares, options.seed)
    print(f"{time.monotonic() - start:.0f} s, {len(steps) - failed} of {len(steps)} files are in {options.out}", file=sys.stderr)
    if failed:
        raise Problem(f"{failed} files could not be made")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    release = os.path.join(ROOT, "build", "release")
    parser.add_argument("--out", default="papers/data", help="folder for the files (papers/data)")
    parser.add_argument("--seconds", type=float, help="time for what is timed (1500; 10 with --quick)")
    parser.add_argument("--seed", type=int, default=1, help="of rays and order (1)")
    parser.add_argument("--again", action="store_true", help="make the files that are there, too")
    parser.add_argument("--quick", action="store_true", help="small fields and few rays: to see whether all runs")
    parser.add_argument("--bench", default=os.path.join(release, "bench", "cellwalk-bench"))
    parser.add_argument("--tool", default=os.path.join(release, "src", "tool", "cellwalk"))
    options = parser.parse_args()
    if options.seconds is None:
        options.seconds = 10 if options.quick else 1500
    try:
        measure(options)
    except (Problem, OSError) as problem:
        print(f"measure.py: {problem}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
