# SPDX-License-Identifier: Apache-2.0
"""setuptools' build backend, with its script where the Python module is instead of at the top."""
from setuptools import build_meta


class _Backend(build_meta._BuildMetaBackend):
    def run_setup(self, setup_script="src/python/packaging/setup.py"):
        super().run_setup(setup_script)


_backend = _Backend()
get_requires_for_build_wheel = _backend.get_requires_for_build_wheel
get_requires_for_build_sdist = _backend.get_requires_for_build_sdist
prepare_metadata_for_build_wheel = _backend.prepare_metadata_for_build_wheel
build_wheel = _backend.build_wheel
build_sdist = _backend.build_sdist
