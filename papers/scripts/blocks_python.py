# SPDX-License-Identifier: Apache-2.0
"""Tables of the Python module: products by chunks, and the cost of a call."""

import re

from markdown import table

# Products of python_dask.json, as the page words their arguments.
CHUNKED = {"shadow": "`shadow`, sun at {altitude} degrees", "sky_view": "`sky_view`, {directions} directions, {max_distance} m"}


def python_chunks(results):
    run, rows = results.run, []
    for name, words in CHUNKED.items():
        product = run.inner("products").inner(name)
        for times in product["runs"]:
            rows.append([words.format(**product["arguments"]), times["workers"], f"{times['seconds']:.0f}",
                         f"{times['bytes_read'] / run.number('raster_bytes'):.2f}",
                         f"{times['worker_bytes_most'] / 1e6:.0f} ({times['worker_bytes_idle'] / 1e6:.0f})"])
    return table(["", "workers", "seconds", "read, of the raster", "most memory a worker, MB (idle)"], rows)


def python_calls(results):
    seconds, over = results.run.inner("seconds"), results.run.inner("least_over_C")
    return table(["", "seconds", "of the C query"],
                 [[re.sub(r"^\w+\(.*\)", r"`\g<0>`", call), f"{seconds.inner(call).number('least'):.4f}", f"{over.number(call):.2f}"] for call in seconds])
