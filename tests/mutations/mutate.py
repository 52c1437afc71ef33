# SPDX-License-Identifier: Apache-2.0
"""Plants the faults of faults.toml one by one in a copy of the project, and runs the tests that should notice.

A fault is caught if one of its tests fails, crashes or does not end, with a sixteenth of its rays or else in full. A fault that no test
catches is a missing test, and the exit status is 1.

    mutate.py --work build/mutate/work [--check] [--only TEXT]
"""
import argparse
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import tomllib

HERE = pathlib.Path(__file__).parent
SOURCE = HERE.parent.parent
CPU_SECONDS = 300  # of a test: ten times what the longest takes
PROGRAMS = {"core": ["cellwalk_library"], "io": ["cellwalk_files", "cellwalk_tool", "cellwalk_gdal"], "scene": ["cellwalk_files", "cellwalk_scenes"], "terrain": ["cellwalk_library"]}
SETTINGS = ["-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_C_FLAGS_RELEASE=-O1 -DNDEBUG", "-DCELLWALK_PYTHON=OFF"]


def read_faults():
    """The faults; stops at one whose text does not stand exactly once in its file."""
    files = tomllib.loads((HERE / "faults.toml").read_text())
    tests = files.pop("tests")
    faults = [{"file": name, "tests": tests[max(filter(name.startswith, tests), key=len)], "search": search, "replace": replace, "breaks": breaks}
              for name, texts in files.items() for search, (replace, breaks) in texts.items()]
    for f in faults:
        count = (SOURCE / f["file"]).read_text().count(f["search"])
        if count != 1 or f["search"] == f["replace"]:
            sys.exit(f"{f['file']}: '{f['search']}' stands there {count} times; a fault needs a text that stands there once")
    return faults


def programs_of(test):
    """What a test in Python starts; nothing for one in C."""
    folder, _, name = test.partition("_")
    return PROGRAMS[folder] if (HERE.parent / folder / f"test_{name}.py").exists() else []


def run(command, **options):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)


def copy_project(work):
    tree = work / "tree"
    if tree.exists():
        shutil.rmtree(tree)
    for name in run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=SOURCE).stdout.split("\0"):
        if name and (SOURCE / name).is_file():
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(SOURCE / name, tree / name)  # as new: an interrupted run may have left objects with a fault
    return tree


class Build:
    def __init__(self, work, jobs):
        self.tree, self.folder, self.jobs = copy_project(work), work / "build", jobs
        done = run(["cmake", "-S", self.tree, "-B", self.folder, "-G", "Ninja", *SETTINGS])
        if done.returncode:
            sys.exit(done.stdout)

    def make(self, tests, what="without a fault"):
        """Programs of tests in C, or what those in Python start."""
        targets = {target for t in tests for target in programs_of(t) or [f"test_{t}"]}
        done = run(["cmake", "--build", self.folder, f"-j{self.jobs}", "--target", *targets])
        if done.returncode:
            sys.exit(f"{what} it cannot be built:\n{done.stdout[-2000:]}")

    def fails(self, test, divide):
        """Whether the test notices something."""
        def limit():
            resource.setrlimit(resource.RLIMIT_CPU, (CPU_SECONDS, CPU_SECONDS))
        command = ["ctest", "-R", f"^{test}$", "--no-tests=error"]
        return run(command, cwd=self.folder / "tests", env=dict(os.environ, CELLWALK_TEST_DIVIDE=str(divide)), preexec_fn=limit).returncode != 0

    def plant(self, fault):
        """The test that catches it, or None."""
        path = self.tree / fault["file"]
        text = path.read_text()
        path.write_text(text.replace(fault["search"], fault["replace"]))
        self.make(fault["tests"], f"{fault['file']}: with '{fault['replace']}'")
        by = next((t for divide in (16, 1) for t in fault["tests"] if self.fails(t, divide)), None)
        path.write_text(text)
        return by


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--work", type=pathlib.Path, required=True)
    parser.add_argument("--check", action="store_true", help="only find the texts")
    parser.add_argument("--only", default="", help="faults whose file or text has this in it")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    faults = [f for f in read_faults() if options.only in f["file"] + f["search"]]
    if not faults:
        sys.exit(f"--only {options.only}: no fault has that in it")
    if options.check:
        return
    options.work.mkdir(parents=True, exist_ok=True)
    build = Build(options.work.resolve(), options.jobs)
    tests = sorted({t for f in faults for t in f["tests"]})
    build.make(tests)
    for test in tests:
        if build.fails(test, 16):
            sys.exit(f"{test} fails without a fault")
    left = 0
    for fault in faults:
        by = build.plant(fault)
        left += by is None
        print(f"{by or 'SURVIVES':20} {fault['file']}: {fault['breaks']}", flush=True)
    print(f"{len(faults) - left} of {len(faults)} faults are caught")
    sys.exit(left > 0)


main()
