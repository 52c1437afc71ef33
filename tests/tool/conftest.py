# SPDX-License-Identifier: Apache-2.0
from program import takes


def pytest_collection_modifyitems(items):
    """Where all have run elsewhere, one test in five is taken, and one case in five of a test's own: it is the program's start that takes time.
    Those of one file are numbered through, so that the turn brings each about."""
    items[:] = [item for k, item in enumerate(items) if takes(k, min(5, len(items)))]
