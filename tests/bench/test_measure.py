# SPDX-License-Identifier: Apache-2.0
"""Runs of cellwalk-bench measure and table on small fields; how the guard reads callgrind's profiles and guard.csv, and its verdicts. No test
depends on how long anything took."""
import json
import os
import pathlib
import re
import subprocess
import sys

import numpy as np
import pytest

BENCH = os.environ["CELLWALK_BENCH"]
FOLDER = pathlib.Path(os.environ["CELLWALK_SOURCE"]) / "bench"
PLANS = FOLDER / "plans"
sys.path.insert(0, str(FOLDER / "instructions"))
import guard  # noqa: E402

WIDE = ["--width", "10", "--count", "4096", "--seconds", "100000"]  # the intervals of seven rounds are narrow, however long these take


def run(*words, status=0, **more):
    done = subprocess.run([BENCH, *map(str, words)], capture_output=True, text=True, **more)
    assert done.returncode == status, done.stdout + done.stderr
    return done


def measure(folder, plan, *words, status=0):
    (folder / "my.plan").write_text(plan)
    usual = [w for k in range(0, len(WIDE), 2) if WIDE[k] not in words for w in WIDE[k:k + 2]]
    done = run("measure", folder / "my.plan", "-o", folder / "out.jsonl", *usual, *words, status=status)
    lines = [json.loads(line) for line in (folder / "out.jsonl").read_text().splitlines()]
    assert lines[0]["kind"] == "run" and lines[0]["commit"] and "load" in lines[0]
    return done, [line for line in lines if line["kind"] == "result"]


def by_name(lines):
    return {line["contender"]: line for line in lines}


def test_strict_kernels_have_the_same_bits_and_intervals(tmp_path):
    done, lines = measure(tmp_path, "# a comment\n65/primary,random  default,cell,pyramid1,default:call=3,grid3d  time\n")
    assert [line["workload"] for line in lines] == ["65/primary"] * 5 + ["65/random"] * 5
    for line in lines:
        assert line["samples"] >= 7 and line["converged"] and line["time_to_first_low"] <= line["time_to_first"]
        assert line["agreement"]["why"]["other"] == 0
        if line["contender"] != "grid3d":
            assert line["agreement"]["same_bits"] == line["agreement"]["rays"] > 0
    assert by_name(lines)["default"]["time_to_first"] == 1
    assert "same bits" in done.stdout


def test_what_has_not_converged_is_marked(tmp_path):
    done, lines = measure(tmp_path, "65/primary default,cell time\n", "--width", "1e-6", "--seconds", "0.05", status=1)
    assert not by_name(lines)["cell"]["converged"]
    assert "not converged" in done.stdout and "have not converged" in done.stderr


def test_errors_of_leaf_tests_and_coarser_land(tmp_path):
    leaves = "default,cell:moller-trumbore,coarser:2"
    _, lines = measure(tmp_path, f"65/vertices {leaves} error\n65/primary {leaves} error\n")
    exact, loose, coarse = (by_name(lines[:3])[name] for name in leaves.split(","))
    assert exact["leaks_per_million"] == exact["wrong_per_million"] == exact["phantoms_per_million"] == 0
    assert loose["leaks_per_million"] > 10000
    assert "leaks_per_million" not in coarse and coarse["t_99"] > 1e3 * exact["t_99"]
    assert by_name(lines[3:])["default"]["ulp_worst"] <= 0.5001


def test_embree_agrees_and_its_fastest_width_is_marked(tmp_path):
    _, lines = measure(tmp_path, "257/ao,bounce default,embree,embree:grid:w8 time\n")
    if any("left_out" in line for line in lines):
        pytest.skip("built without Embree")
    for work in ("ao", "bounce"):
        peers = [line for line in lines if line["group"] == "embree" and line["item"] == work]
        assert len(peers) == 4 and sum(line["best_of_group"] for line in peers) == 1
        assert min(peers, key=lambda line: (-line["samples"], line["seconds_median"]))["best_of_group"]
        assert all(line["agreement"]["why"]["other"] == 0 for line in peers)


def test_bullet_agrees_without_its_accelerator(tmp_path):
    _, lines = measure(tmp_path, "65/random,shadow default,bullet agree,error\n")
    if any("left_out" in line for line in lines):
        pytest.skip("built without Bullet")
    assert all(line["agreement"]["why"]["other"] == 0 and line["wrong_per_million"] == 0 for line in lines)


def test_a_line_with_instruction_sets(tmp_path):
    _, lines = measure(tmp_path, "65/primary,random default,cell time scalar,avx2\n", "--isa", "scalar")
    assert [line["isa"] for line in lines] == ["scalar"] * 4


def test_a_run_that_ends_early_leaves_what_it_has(tmp_path):
    """And rays on land with holes, one of them under the camera, meet its surface."""
    land = np.random.default_rng(1).normal(size=(60, 60)).astype(np.float32)
    land[5::7, 3::7] = land[1, 29] = np.nan
    np.save(tmp_path / "holes.npy", land)
    holes = f"{tmp_path}/holes.npy"
    done, lines = measure(tmp_path, f"{holes}/primary,within-2,vertices,edges,beside default,embree:w8 agree\n{holes}/primary cell error\n", status=1)
    assert "holes.npy/primary: errors are judged" in done.stderr
    found = {line["item"]: line["agreement"] for line in lines if "left_out" not in line}
    assert all(of["hits_reference"] > 0 == of["why"]["other"] for of in found.values())
    assert found["primary"]["rays"] == found["beside"]["rays"] == 4096 > found["within-2"]["rays"] > 3000 < found["edges"]["rays"]
    if "left_out" not in lines[1]:  # Embree's grids do not know holes
        done, _ = measure(tmp_path, f"{holes}/random embree:grid:w8 agree\n", status=1)
        assert re.search("holes.npy/random: [0-9]+ answers of embree:grid:w8 are wrong", done.stderr)


def test_building_counts_bytes(tmp_path):
    _, lines = measure(tmp_path, "65/build default,default:threads=2 time\n")
    one, two = lines
    assert measure(tmp_path, "scenes/hftest default:threads=2 time\n")[1][0]["by_clock"] and two["by_clock"] > one["by_clock"]
    assert one["bytes"] == two["bytes"] and 4 < one["bytes_a_cell"] < 10 and one["items"] == 64 * 64


def test_terrain_choices_have_errors(tmp_path):
    _, lines = measure(tmp_path, "129/horizon default,coarser:2,distance:20 error\n129/sky directions:32,directions:4 error\n")
    of = by_name(lines)
    assert of["default"]["degrees_worst"] == 0 < of["distance:20"]["degrees_rms"] and of["coarser:2"]["degrees_rms"] > 0
    assert 0 < of["directions:32"]["share_rms"] < of["directions:4"]["share_rms"] < 0.2


def test_the_scenes_table(tmp_path):
    done = run("table", "--quick", "--width", "10", "--seconds", "100000", cwd=tmp_path)
    table = (tmp_path / "out/table/table.md").read_text()
    assert "| hftest |" in table and "grid3d" in table and "hftest" in done.stdout
    row = run("table", "--quick", "--width", "1e-6", "--seconds", "4", cwd=tmp_path).stdout.split("| hftest |")[1]
    assert "(not converged)" in row and re.search(r"\([\di]", row) is None  # no share of a time that has not converged
    lines = [json.loads(line) for line in (tmp_path / "out/table/table.jsonl").read_text().splitlines()]
    assert all(line["agreement"]["why"]["other"] == 0 for line in lines[1:] if "left_out" not in line)


def test_a_raster_of_ones_own(tmp_path):
    rng = np.random.default_rng(1)
    np.save(tmp_path / "land.npy", rng.normal(size=(50, 70)).cumsum(axis=1).astype(np.float32))
    done = run("measure", "--field", tmp_path / "land.npy", "--cellsize", 2, *WIDE)
    assert done.stdout.count("default") == 8 and "land.npy/shadow" in done.stdout


def test_a_raster_that_gdal_reads(tmp_path):
    if os.environ.get("CELLWALK_GDAL") != "1":
        pytest.skip("built without GDAL")
    (tmp_path / "land.pgm").write_bytes(b"P5 40 30 255\n" + np.random.default_rng(1).integers(0, 9, (30, 40), np.uint8).tobytes())
    assert "land.pgm/build" in run("measure", "--field", tmp_path / "land.pgm", *WIDE).stdout
    for name, words in (("none.tif", "none.tif: "), ("one.pgm", "nx: 1 samples; a field has 2")):
        (tmp_path / "one.pgm").write_bytes(b"P5 1 1 255\n\1")
        assert words in run("measure", "--field", tmp_path / name, *WIDE, status=1).stderr


def test_every_plan_that_ships_is_understood(tmp_path):
    names = {plan.stem for plan in PLANS.glob("*.plan")}
    help_text = " ".join(run("measure", "--help").stdout.split())
    listed = help_text.split("one that ships (")[1].split(")")[0].split(", ")
    assert set(listed) == names - {"field", "scenes-quick", "guard"}
    for name in names:
        for line in (PLANS / f"{name}.plan").read_text().splitlines():
            words = line.split("#")[0].split()
            if words:
                smallest = [words[0].rsplit("/", 1)[0].split(",")[-1], words[0].rsplit("/", 1)[1].split(",")[0]]
                where = "scenes/hftest" if smallest[0] == "scenes" else f"65/{smallest[1]}"
                contenders = ",".join(c for c in words[1].split(",") if not c.startswith("grid3d"))
                measure(tmp_path, f"{where} {contenders} {words[2].replace('time', 'agree')}\n", "--count", "64")


@pytest.mark.parametrize("plan, words", [
    ("65/primary default\n", "my.plan:1: a line is FIELD/WORK CONTENDERS METRICS"),
    ("\n65/primary default speed\n", "my.plan:2: speed: no metric; these are time, agree"), ("65/primary default time avx3\n", "my.plan:1: avx3: no instruction set"),
    ("65," * 99 + "65/primary default time\n", "my.plan:1: more than 255 characters of fields or of works"),
    ("65/primary default time\n65/nothing default time\n", "my.plan:2: 65/nothing: there is no such work"),
    ("65/primary default time\n\n65/primary nobody time\n", "my.plan:3: contender nobody: Contenders of rays: default"),
    ("65/primary embree:w3 time\n", "my.plan:1: contender embree:w3"),
    ("65/primary default time\nscenes/hftest coarser:2 time\n", "my.plan:2: coarser:2: scenes have no coarser fields"),
    ("65/primary coarser:1 error\n", "contender coarser:1"), ("65/primary default:call=0 time\n", "contender default:call=0"), ("65/build cell time\n", "contender cell: what builds is"),
    ("65/build default:call=3 time\n", "contender default:call=3: what builds is"), ("65/sky distance:-1 error\n", "contender distance:-1: horizons have"),
    ("65/sky directions:16abc error\n", "contender directions:16abc: horizons have"),
    ("65/primary default time\nnowhere.tif/primary default time\n", "my.plan:2: nowhere.tif"), ("# nothing\n", "has no line to measure"),
])
def test_wrong_plans(tmp_path, plan, words):
    (tmp_path / "my.plan").write_text(plan)
    done = run("measure", tmp_path / "my.plan", "-o", tmp_path / "out.jsonl", *WIDE, status=1)
    assert words in done.stderr and done.stdout == "" and not (tmp_path / "out.jsonl").exists()


@pytest.mark.parametrize("words, out", [
    ("--field d.npy", "d.npy"), ("--field d.npy", "link"), ("my.plan", "my.plan"), ("my.plan", "d.npy"), ("my.plan", "link"),
    ("my.plan --scenes .", "hf4x4.pbrt"), ("scenes-quick --scenes .", "hftest.pbrt"), ("my.plan", "log")])
def test_inputs_are_not_replaced(tmp_path, words, out):
    """Not even those that only later lines of the plan read."""
    np.save(tmp_path / "d.npy", np.zeros((9, 9), np.float32))
    for name in "hftest.pbrt", "hf4x4.pbrt":
        (tmp_path / name).write_text((FOLDER / "scenes" / name).read_text())
    (tmp_path / "my.plan").write_text("17/primary default agree\nd.npy/primary default agree\nscenes/hftest default agree\n")
    (tmp_path / "link").symlink_to("d.npy")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    with open(tmp_path / "log", "a") as log:
        done = subprocess.run([BENCH, "measure", *words.split(), "-o", out, *WIDE], cwd=tmp_path, stdout=log, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 1 and f"{out}: is also " in done.stderr and before == {path: path.read_bytes() for path in before}

def test_wrong_words(tmp_path):
    (tmp_path / "nothing").mkdir()
    assert "neither a file nor one that ships" in run("measure", "nothing", status=1, cwd=tmp_path).stderr
    assert "give a PLAN, or --field FILE" in run("measure", status=2).stderr
    limited = {**os.environ, "CELLWALK_ISA": "scalar"}
    assert "allows no more than scalar" in run("measure", "first", "--isa", "sse4.2", status=2, env=limited).stderr
    for name in ("sse", "AVX2", "avx2 "):
        assert "is unknown" in run("measure", "first", status=2, env={**os.environ, "CELLWALK_ISA": name}).stderr


def test_contenders_that_cannot_run_are_left_out(tmp_path):
    (tmp_path / "my.plan").write_text("65/primary default,packet8 time\n")
    done = run("measure", tmp_path / "my.plan", *WIDE, env={**os.environ, "CELLWALK_ISA": "scalar"})
    assert "left out: needs an instruction set" in done.stdout and "pyramid" not in done.stderr


# ---- the guard against slow-downs -----------------------------------------------------------------------------------------

PROFILE = ("version: 1,part: 1,ob=/some/where/work,fn=a,10 100,calls=1 20,11 5000,12 7,ob=/lib/libm.so,1 900,"
           "part: 2,ob=/some/where/work,10 55").split(",")


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
    ({"a": (8, 1000), "b": (8, 1000)}, set(), 0, False), ({"a": (8, 1020), "b": (8, 980)}, set(), 0, False),
    ({"a": (8, 1021), "b": (8, 1000)}, set(), 1, True), ({"a": (8, 1000), "b": (8, 979)}, set(), 1, False),
    ({"a": (9, 1000), "b": (8, 1000)}, set(), 1, True), ({"a": (8, 1000), "b": (8, 1000), "c": (8, 1)}, set(), 1, True),
    ({"a": (8, 1000)}, set(), 1, True), ({"a": (8, 1000)}, {"b"}, 0, False),
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
