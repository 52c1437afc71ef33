# SPDX-License-Identifier: Apache-2.0
"""setuptools' build backend, with an extension that CMake builds. Everything else stands in pyproject.toml."""
import os
import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Extension, build_meta, setup
from setuptools.command.build_ext import build_ext

top = pathlib.Path(__file__).resolve().parents[3]


class CMakeBuild(build_ext):
    def build_extension(self, extension):
        build = pathlib.Path(self.build_temp).resolve()
        options = ["TOOL=OFF", "BENCH=OFF", "TESTS=OFF", "INSTALL=OFF", "PYTHON=ON"]
        generator = ["-G", "Ninja"] if shutil.which("ninja") else []
        subprocess.run(["cmake", "-S", top, "-B", build, *generator, "-DCMAKE_BUILD_TYPE=Release", "-DBUILD_SHARED_LIBS=OFF",
                        f"-DPython3_EXECUTABLE={sys.executable}", *(f"-DCELLWALK_{option}" for option in options)], check=True)
        subprocess.run(["cmake", "--build", build, "--target", "cellwalk_python", "--parallel", str(os.cpu_count() or 1)], check=True)
        target = pathlib.Path(self.get_ext_fullpath(extension.name)).resolve().parent
        target.mkdir(parents=True, exist_ok=True)
        for library in (build / "src/python/cellwalk").glob("*.so"):
            shutil.copy2(library, target)


class _Backend(build_meta._BuildMetaBackend):
    def run_setup(self, setup_script=None):
        version = re.search(r"project\(cellwalk VERSION (\S+)", (top / "CMakeLists.txt").read_text())[1]
        setup(version=version, ext_modules=[Extension("cellwalk._cellwalk", [], py_limited_api=True)], cmdclass={"build_ext": CMakeBuild},
              options={"bdist_wheel": {"py_limited_api": "cp311"}})


_backend = _Backend()
get_requires_for_build_wheel = _backend.get_requires_for_build_wheel
get_requires_for_build_sdist = _backend.get_requires_for_build_sdist
prepare_metadata_for_build_wheel = _backend.prepare_metadata_for_build_wheel
build_wheel = _backend.build_wheel
build_sdist = _backend.build_sdist
