# SPDX-License-Identifier: Apache-2.0
"""Tables of work: where the time goes, instructions on ARM, cache misses and pages."""

import names
from blocks_speed import matrix, own, speed
from markdown import ratio, table
from results import run_text


def profile(data):
    results = data["profile.json"]
    phases = list(dict.fromkeys(phase for line in results.of("profile") for phase in line.inner("shares")))
    phases.sort(key=lambda phase: phase == "other")
    text = f"{run_text(results.run)}. `{results.some('profile')[0].text('kernel')}`, per cent of the samples in it.\n"
    for field in results.distinct("field", "profile"):
        of = {line.text("rays"): line.inner("shares") for line in results.of("profile", field=field)}
        rows = [[phase, *(f"{100 * shares.number(phase, 0.0):.0f}".removeprefix("0")
                          for shares in of.values())] for phase in phases]
        text += f"\n**{names.field(field)}**\n\n" + table(["phase", *of], rows)
    return text


def neon(data):
    results = data["neon.json"]
    kernels = results.distinct("kernel", "neon")
    text = f"{results.run.text('emulator')}, {results.run.text('compiler')}, commit {results.run.text('commit')}.\n"
    for field in results.distinct("field", "neon"):
        lines = {(line.text("kernel"), line.text("rays")): line for line in results.of("neon", field=field)}
        rows = []
        for rays in dict.fromkeys(rays for _, rays in lines):
            row = [rays]
            for line in (lines[kernel, rays] for kernel in kernels):
                x86, arm = line.number("sse42"), line.number("neon")
                row += [f"{x86 / line.number('ray_count'):.0f}", f"{arm / line.number('ray_count'):.0f}", f"{arm / x86:.2f}"]
            rows.append(row)
        head = [f"{kernel}{what}" for kernel in kernels for what in (", SSE4.2", ", NEON", ": ratio")]
        text += f"\n**{names.field(field)}**\n\n" + table(["rays", *head], rows)
    return text


def caches(data):
    results = data["caches.json"]
    columns = [("L2", "reads"), ("L2", "first_misses"), ("L2", "misses"), ("L3", "misses")]
    rows = []
    for field in results.distinct("field", "caches"):
        for rays in results.distinct("rays", "caches"):
            lines = [(results.first("caches", field=field, rays=rays, level=level), key) for level, key in columns]
            rows.append([names.field(field), rays, *(f"{line.number(key) / line.number('ray_count'):.2f}" if line else ""
                                                     for line, key in lines)])
    first = results.some("caches")[0]
    return (f"Per ray, `{first.text('kernel')}`, {first.number('ray_count')} rays a class.\n\n" +
            table(["field", "rays", "reads", "misses of 32 KiB", "of 512 KiB", "of 32 MiB"], rows, "llrrrr"))


def pages(data):
    huge, small = data["pages-huge.json"], data["pages-small.json"]
    fields, classes = matrix(huge)
    rows = [[names.field(field), *(ratio(speed(own(huge, field, rays)), speed(own(small, field, rays)))
                                   for rays in classes)] for field in fields]
    return table(["field", *classes], rows)
