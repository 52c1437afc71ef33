#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Where the time of a ray goes, sampled: perf record on cellwalk-bench micro, each sample's address taken apart into the
functions inlined there, and these into phases. Writes papers/data/profile.json."""

import argparse
import collections
import json
import os
import re
import subprocess
import sys
import tempfile

from results import Problem, Results

# Which phase a function of simd/ belongs to. The innermost function of a sample that stands here decides, so helpers
# that serve several phases (crossing, cell_gate, the vector vocabulary) are left to their callers.
PHASES = {
    "rays made ready": "make_rays start_rays move_if_far move_rays make_axis make_slab fill_up",
    "climb": "climb climb_start climb_place climb_pair_of climb_level",
    "flat steps": "flat_start first_cell flat_step short_way",
    "shared walk: set-up": "coherent fat_init group_ray",
    "shared walk: nodes": "shared_walk walk_groups fat_open",
    "shared walk: blocks": "shared_block block_rays fat_cells load_samples",
    "shared walk: cells": "shared_cells shared_packets closest_down_down closest_up_down closest_down_up closest_up_up "
                          "any_down_down any_up_down any_down_up any_up_up",
    "lane walk: queue, refill": "fall_apart mirror_packet mirror_rays mirror_axis enqueue first_corner "
                                "refill_lane copy_ray lane_clear load_lanes store_lanes move_lane close_up",
    "lane walk: step": "lane_walk lane_step look_along",
    "lane walk: descend": "lane_descend above_plane child_at",
    "lane walk: advance": "lane_advance",
    "lane walk: cells": "lane_leaf turn_back",
    "leaf test": "wt_cell wt_cell_in wt_in_b wt_border wt_edge_samples wt_edge wt_within wt_inside wt_between mt_cell",
    "misses and hits written": "packet_hits keep_hits refine_hits scatter_hits lane_found write_found restart_rays",
}
PHASE_OF = {function: phase for phase, functions in PHASES.items() for function in functions.split()}
OTHER = "other"
# These hold what the above are inlined into; their own instructions are the rest.
FRAMES = re.compile(r"pyramid_(closest|any|tile)|walk_(apart|together)|packet_(closest|any)|cw_(closest|any)_\w+")


def run(command, what, **options):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)
    if done.returncode != 0:
        raise Problem(f"{what} failed with status {done.returncode}: {' '.join(command)}\n{done.stderr.strip()}")
    return done.stdout


def addresses(program, recording):
    """How often each address of the program was sampled, as it stands in the file."""
    code = [line.split() for line in run(["readelf", "-lW", program], "readelf").splitlines()
            if re.match(r"\s*LOAD\s.*\bR E\b", line)]
    if len(code) != 1:
        raise Problem(f"{program}: has {len(code)} segments of code; want one")
    to_address = int(code[0][2], 16) - int(code[0][1], 16)  # from where code stands in the file
    base, found = None, collections.Counter()
    for line in run(["perf", "script", "-i", recording, "--show-mmap-events", "-F", "ip"], "perf script").splitlines():
        mapped = re.search(r"\[0x([0-9a-f]+)\(0x([0-9a-f]+)\) @ (?:0x)?([0-9a-f]+) .*: r-xp (.*)", line)
        if mapped and os.path.realpath(mapped[4]) == os.path.realpath(program):
            start, size, offset = (int(mapped[k], 16) for k in (1, 2, 3))
            base = start, start + size, offset + to_address - start
        ip = re.fullmatch(r"\s*([0-9a-f]+)\s*", line)
        if ip and base and base[0] <= int(ip[1], 16) < base[1]:
            found[int(ip[1], 16) + base[2]] += 1
    if not found:
        raise Problem(f"{recording}: has no sample in {program}")
    return found


def frames(program, wanted):
    """The functions inlined at each address, innermost first, with their files."""
    text = run(["addr2line", "-a", "-i", "-f", "-e", program], "addr2line", input="".join(f"{a:#x}\n" for a in wanted))
    of, now = {}, None
    lines = iter(text.splitlines())
    for line in lines:
        if line.startswith("0x"):
            now = of[int(line, 16)] = []
        else:
            now.append((line, next(lines)))
    if all(file.startswith("??") for functions in of.values() for _, file in functions):
        raise Problem(f"{program}: has no debugging information; compile with -g")
    return of


def shares(program, recording):
    """Samples of the kernels by phase, and the functions that no phase has."""
    sampled, unknown, counts = addresses(program, recording), collections.Counter(), collections.Counter()
    for address, functions in frames(program, sampled).items():
        if not any("/simd/" in file for _, file in functions):
            continue  # the reference kernel, making of fields and rays, the harness
        phase = next((PHASE_OF[name] for name, _ in functions if name in PHASE_OF), OTHER)
        counts[phase] += sampled[address]
        if phase == OTHER:
            named = [name for name, file in functions if not re.search(r"/vec_\w+\.h", file)]
            if named and not FRAMES.fullmatch(named[0]):
                unknown[named[0]] += sampled[address]
    return counts, unknown


def profile(options, folder, field, rays, kernel):
    recording, found = os.path.join(folder, "perf.data"), os.path.join(folder, "micro.json")
    micro = [options.bench, "micro", "--kernel", kernel, "--peer", "none", "--field", field, "--rays", rays, "--count",
             "131072", "--pass", "5", "--width", "0.0001", "--seconds", str(options.seconds), "--json", found]
    run(["perf", "record", "-e", "cpu-clock", "-F", "3989", "-o", recording, "--", *micro], "perf record")
    counts, unknown = shares(options.bench, recording)
    total = sum(counts.values())
    for name, count in unknown.most_common():
        if count > 0.05 * total:
            print(f"warning: {field}, {rays}: {100 * count / total:.0f} % of the samples are in {name}, which is in no "
                  "phase", file=sys.stderr)
    print(f"{field}, {rays}: {total} samples")
    line = {"kind": "profile", "field": field, "rays": rays, "kernel": kernel, "samples": total,
            "shares": {phase: round(counts[phase] / total, 4) for phase in (*PHASES, OTHER) if counts[phase]}}
    return line, Results(found).run


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bench", default="build/profile/bench/cellwalk-bench", help="the program, compiled with -g")
    parser.add_argument("--kernel", help="by default the one that the library chooses")
    parser.add_argument("--field", default="65,1025")
    parser.add_argument("--rays", default="primary,shadow,ao,bounce,random,grazing")
    parser.add_argument("--seconds", type=float, default=8, help="for each field and class of rays (8)")
    parser.add_argument("--json", default="papers/data/profile.json")
    options = parser.parse_args()
    lines, record = [], None
    with tempfile.TemporaryDirectory() as folder:
        asked = os.path.join(folder, "fields.json")
        run([options.bench, "micro", "--rays", "none", "--peer", "none", "--field", options.field, "--json", asked], "micro")
        for about in Results(asked).of("field"):
            for rays in options.rays.split(","):
                line, record = profile(options, folder, about.text("field"), rays,
                                       options.kernel or about.text("default_kernel"))
                lines.append(line)
    record.update(command="profile", arguments=" ".join(sys.argv[1:]))
    with open(options.json, "w", encoding="utf-8") as file:
        file.writelines(json.dumps(line, ensure_ascii=False, separators=(",", ":")) + "\n" for line in (record, *lines))


if __name__ == "__main__":
    try:
        main()
    except (Problem, OSError) as error:
        sys.exit(f"profile_kernels.py: {error}")
