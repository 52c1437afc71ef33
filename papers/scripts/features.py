#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What each feature of a scene costs the renderer: instructions of landsea-0 with more and more features, counted by callgrind
(Debian: valgrind) up to AVX2, by the function of src/scene/render that they were compiled from. Writes
papers/data/scenes/features.json. Needs a build with -g."""

import argparse
import bisect
import collections
import glob
import json
import os
import re
import subprocess
import sys
import tempfile
import time

from results import Problem

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
RENDER = "src/scene/render/"
# Which part of the renderer a function belongs to; in this order, all functions of a file may stand as one.
PARTS = {
    "Phong normals": "fetch_window window_sample clamp at_border vertex_inside vertex_at_border vertex_central beside vertex_of "
                     "set_turn barycentric bilinear",
    "textures": "find_uv turn_of spread_on_surface lookup.inc.h",
    "mirrors": "send_mirrored spread_mirrored",
    "cylinders": "meet_cylinder closest_on_cylinder hide_by_cylinder cylinder_t",
    "light": "send_light move_shadows ask_any hide_by_field in_row trace_shadows",
    "rays": "camera.inc.h pattern.h origin_of move_rays pass_box all_pass none_behind ask line_up later_entry "
            "earlier_exit ask_closest closest_on_field trace_paths",
}
PART_OF = {name: part for part, names in PARTS.items() for name in names.split()}
# Features that a scene may lack, and the parts that it then should not run.
FEATURES = {"phong": "Phong normals", "texture": "textures", "mirror": "mirrors", "sky": "cylinders", "light": "light"}
# Pictures: what is new, features, further options of cellwalk render.
STEPS = (
    ("land and sea, no light", "", ()),
    ("a light", "light", ()),
    ("Phong normals", "light phong", ("--phong",)),
    ("a sky of one colour", "light phong sky", ("--phong",)),
    ("the sea a mirror", "light phong sky mirror", ("--phong",)),
    ("the sky an image", "light phong sky mirror texture", ("--phong",)),
    ("flat normals again", "light sky mirror texture", ()),
)


def scene(features):
    """landsea-0 with these features alone."""
    sky = ('Material "matte" "texture Kd" "sky"' if "texture" in features else 'Material "matte" "color Kd" [0.5 0.5 0.5]')
    return "\n".join((
        'LookAt 0 0 0 0 0 1 0 1 0', 'Camera "perspective" "float fov" 50',
        'Film "image" "integer xresolution" 400 "integer yresolution" 400',
        'Sampler "bestcandidate" "integer pixelsamples" 4', 'WorldBegin',
        'AttributeBegin CoordSysTransform "camera" LightSource "point" "color I" [15 15 15] AttributeEnd'
        if "light" in features else "",
        'Translate -2 -0.5 1 Rotate 85 1 0 0',
        'AttributeBegin Texture "sky" "color" "imagemap" "string filename" "sky.exr" ' + sky +
        ' Translate 2 1.5 0.25 Rotate 25 0 0 1 Scale 4 4 6 Shape "cylinder" AttributeEnd' if "sky" in features else "",
        'AttributeBegin Material "matte" "color Kd" [0.4 0.2 0.1] Scale 4 4 0.4 Include "land.pbrt" AttributeEnd',
        'AttributeBegin Material "' + ("mirror" if "mirror" in features else "matte") +
        '" Scale 4 4 0.1 Include "sea.pbrt" AttributeEnd', 'WorldEnd', ""))


class Functions:
    """Which function of a source file a line lies in: definitions begin at the left margin."""

    def __init__(self, path):
        with open(path, encoding="utf-8") as file:
            found = [(number, match[1]) for number, line in enumerate(file, 1)
                     if (match := re.match(r"(?:static |LANE_INLINE |bool )[^=;]*?\b(\w+)\(", line))]
        self.lines, self.names = [number for number, _ in found], [name for _, name in found]

    def at(self, line):
        place = bisect.bisect_right(self.lines, line)
        return self.names[place - 1] if place else ""


def counts(path, functions):
    """Instructions by part of the renderer, with those of the tracer and of all else, out of a file of callgrind."""
    parts, names, file, skip, line = collections.Counter(), {}, "", False, 0
    with open(path, encoding="utf-8") as text:
        for row in text:
            head = re.match(r"(fl|fi|fe|fn|ob|cfn|cfi|cfl|cob)=(?:\((\d+)\))?\s*(.*)", row)
            if head:
                key, number, name = head.groups()
                kind = {"fi": "fl", "fe": "fl", "cfi": "fl", "cfl": "fl", "cfn": "fn", "cob": "ob"}.get(key, key)
                name = names.setdefault((kind, number), name) if number and name else names.get((kind, number), name)
                file = name if key in ("fl", "fi", "fe") else file
            elif row.startswith("calls="):
                skip = True
            elif re.match(r"[+\-*0-9]", row):
                place, cost = row.split()[:2]
                line = line if place == "*" else line + int(place) if place[0] in "+-" else int(place)
                if not skip:
                    parts[part_of(file, line, functions)] += int(cost)
                skip = False
    return parts


def part_of(file, line, functions):
    base = os.path.basename(file)
    if RENDER in file and base in functions:
        return PART_OF.get(base) or PART_OF.get(functions[base].at(line), "rest of the renderer")
    return "tracing" if "/simd/" in file or file.startswith("simd/") or "intrin.h" in file else "other"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tool", default=os.path.join(ROOT, "build/profile/src/tool/cellwalk"), help="cellwalk, built with -g")
    parser.add_argument("--scenes", default=os.path.join(ROOT, "build/release/bench/scenes"), help="the scenes' folder")
    parser.add_argument("--output", default=os.path.join(ROOT, "papers/data/scenes/features.json"))
    options = parser.parse_args()
    functions = {os.path.basename(path): Functions(path) for path in glob.glob(os.path.join(ROOT, RENDER, "*.h"))}
    lines = []
    for what, features, more in STEPS:
        with tempfile.TemporaryDirectory() as folder:
            for name in ("land.pbrt", "sea.pbrt", "sky.exr"):
                os.symlink(os.path.join(os.path.abspath(options.scenes), name), os.path.join(folder, name))
            with open(os.path.join(folder, "scene.pbrt"), "w", encoding="utf-8") as file:
                file.write(scene(features.split()))
            found = os.path.join(folder, "counts")
            done = subprocess.run(["valgrind", "--tool=callgrind", "--dump-line=yes", f"--callgrind-out-file={found}", options.tool,
                                   "render", "scene.pbrt", "-o", "picture.exr", "--isa", "avx2", "--threads", "1", "--quiet",
                                   "--json", *more], cwd=folder, capture_output=True, text=True)
            if done.returncode != 0:
                raise Problem(f"{options.tool} failed: {done.stderr}")
            stats = json.loads(done.stdout)
            rays = stats["camera_rays"]
            parts = counts(found, functions)
        unused = {part for feature, part in FEATURES.items() if feature not in features.split()}
        lines.append({"kind": "features", "added": what, "features": features, "camera_rays": rays,
                      "shadow_rays": stats["shadow_rays"], "mirror_rays": stats["mirror_rays"],
                      "per_ray": {part: parts[part] / rays for part in
                                  (*PARTS, "rest of the renderer", "tracing")},
                      "unused_per_ray": sum(parts[part] for part in unused) / rays})
        print(json.dumps(lines[-1]), file=sys.stderr)
    commit = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short=10", "HEAD"], capture_output=True, text=True).stdout
    run = {"kind": "run", "command": "features", "isa": "avx2", "commit": commit.strip(),
           "date": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())}
    with open(options.output, "w", encoding="utf-8") as file:
        file.writelines(json.dumps(line) + "\n" for line in (run, *lines))


if __name__ == "__main__":
    try:
        main()
    except (OSError, Problem) as problem:
        sys.exit(f"features.py: {problem}")
