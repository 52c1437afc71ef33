#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""pbrt-v2 and cellwalk on the six scenes, whole processes on one thread, interleaved: CPU time and memory of each, for the
picture and for one of a single pixel, the time of reading and building. Writes papers/data/scenes/pbrt.json. Needs GNU
time, and a pbrt-v2 of yours: any build will do, and --build says which it was."""

import argparse
import json
import os
import random
import re
import statistics
import subprocess
import sys
import tempfile
import time

from draw import Problem

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCENES = ("hftest", "landsea-0", "landsea-1", "landsea-2", "texture", "landsea-big")
FILM = re.compile(r'Film\s+"image"(\s*"[^"]*"\s*(\[[^\]]*\]|"[^"]*"|[0-9]+))*')
SIDE = re.compile(r'"integer ([xy])resolution"\s*\[?\s*([0-9]+)\s*\]?')


def with_film(text, one_pixel, output):
    """The scene's text with the picture in another file, and of one pixel if so wanted."""
    films = FILM.findall(text)
    if len(films) != 1:
        raise Problem(f"a scene has {len(films)} films; want one")
    sides = dict(SIDE.findall(FILM.search(text).group()))
    x, y = ("1", "1") if one_pixel else (sides["x"], sides["y"])
    film = f'Film "image" "string filename" ["{output}"] "integer xresolution" [{x}] "integer yresolution" [{y}]'
    return FILM.sub(lambda _: film, text)


def cpu_seconds(command):
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    said = child.stderr.read()
    _, status, used = os.wait4(child.pid, 0)
    if status != 0:
        raise Problem(f"{' '.join(command)} failed with status {os.waitstatus_to_exitcode(status)}: {said.strip()}")
    return used.ru_utime + used.ru_stime


def mib(command, folder):
    """The most memory that a program has. (wait4 would count Python's, which the child has before it becomes the program.)"""
    report = os.path.join(folder, "_memory")
    subprocess.run(["time", "-f", "%M", "-o", report, *command], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    with open(report, encoding="utf-8") as file:
        return int(file.read()) / 1024


def measure(scene, scenes, options, folder):
    """One line of results."""
    for other in os.listdir(scenes):
        os.symlink(os.path.join(os.path.abspath(scenes), other), os.path.join(folder, other))
    with open(os.path.join(scenes, f"{scene}.pbrt"), encoding="utf-8") as file:
        text = file.read()
    jobs = []
    for what in ("whole", "pixel"):
        path, picture = os.path.join(folder, f"_{what}.pbrt"), os.path.join(folder, "_picture.exr")
        with open(path, "w", encoding="utf-8") as file:
            file.write(with_film(text, what == "pixel", picture))
        jobs += [("pbrt", what, [options.pbrt, "--ncores", "1", "--quiet", path]),
                 ("cellwalk", what, [options.tool, "render", path, "-o", picture, "--threads", "1", "--quiet"])]
    seconds = {(program, what): [] for program, what, _ in jobs}
    memory = {program: mib(command, folder) for program, what, command in jobs if what == "whole"}
    for number in range(options.rounds):
        random.Random(number).shuffle(jobs)
        for program, what, command in jobs:
            seconds[program, what].append(cpu_seconds(command))
    line = {"kind": "scene", "scene": scene, "rounds": options.rounds}
    for program in ("pbrt", "cellwalk"):
        whole, pixel = (statistics.median(seconds[program, what]) for what in ("whole", "pixel"))
        line |= {f"{program}_seconds": whole, f"{program}_pixel_seconds": pixel, f"{program}_mib": memory[program]}
    ratios = sorted(p / c for p, c in zip(seconds["pbrt", "whole"], seconds["cellwalk", "whole"]))
    return line | {"ratio_least": ratios[0], "ratio_most": ratios[-1]}


def record(options):
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        cpu = re.search(r"^model name\s*: (.*)$", file.read(), re.MULTILINE).group(1)
    info = json.loads(subprocess.run([options.tool, "info", "--json"], check=True, capture_output=True, text=True).stdout)
    commit = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short=10", "HEAD"], capture_output=True, text=True).stdout
    return {"kind": "run", "command": "beside_pbrt", "pbrt": options.build, "cpu": cpu, "isa": info["isa"],
            "commit": commit.strip(), "load": os.getloadavg()[0],
            "date": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pbrt", required=True, help="the program pbrt")
    parser.add_argument("--build", required=True, help="its commit, compiler and flags")
    parser.add_argument("--tool", default=os.path.join(ROOT, "build/release/src/tool/cellwalk"), help="the program cellwalk")
    parser.add_argument("--scenes", default=os.path.join(ROOT, "build/release/bench/scenes"), help="the scenes' folder")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--output", default=os.path.join(ROOT, "papers/data/scenes/pbrt.json"))
    options = parser.parse_args()
    lines = [record(options)]
    for scene in SCENES:
        with tempfile.TemporaryDirectory() as folder:
            lines.append(measure(scene, options.scenes, options, folder))
        print(json.dumps(lines[-1]), file=sys.stderr)
    with open(options.output, "w", encoding="utf-8") as file:
        file.writelines(json.dumps(line) + "\n" for line in lines)


if __name__ == "__main__":
    try:
        main()
    except (OSError, Problem) as problem:
        sys.exit(f"beside_pbrt.py: {problem}")
