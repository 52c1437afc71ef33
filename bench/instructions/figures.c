/* SPDX-License-Identifier: Apache-2.0 */
#include "instructions/figures.h"

#include <inttypes.h>
#include <string.h>

static const char heading[] = "kernel,leaf,field,rays,count,instructions";

static bool take_comment(const char *line, const char *key, char text[GUARD_BUILD]) {
    const size_t length = strlen(key);
    if (strncmp(line, key, length) != 0) return false;
    snprintf(text, GUARD_BUILD, "%s", line + length);
    return true;
}

static bool take_figure(void *context, char *line) {
    guard_figures *figures = context;
    if (take_comment(line, "# compiler: ", figures->compiler) || take_comment(line, "# flags: ", figures->flags) ||
        line[0] == '#' || strcmp(line, heading) == 0)
        return true;
    if (figures->all.count == COUNTED_MAX) return false;
    counted_run *f = &figures->all.runs[figures->all.count++];
    return callgrind_take_name(&line, f->kernel) && callgrind_take_name(&line, f->leaf) &&
           callgrind_take_name(&line, f->field) && callgrind_take_name(&line, f->rays) &&
           callgrind_take_number(&line, &f->count) && callgrind_take_number(&line, &f->events[IR]) && line == NULL &&
           f->events[IR] > 0;
}

bool guard_read(guard_figures *figures, const char *path, io_error *error) {
    *figures = (guard_figures){.all = {.count = 0}};
    return callgrind_read_lines(path, take_figure, figures, error);
}

bool guard_write(const guard_figures *figures, io_output *out, io_error *error) {
    char text[4 * GUARD_BUILD];
    int length = snprintf(text, sizeof text,
                          "# Instructions of the guard's workload; written by the build target guard-update.\n"
                          "# compiler: %s\n# flags: %s\n%s\n",
                          figures->compiler, figures->flags, heading);
    bool good = io_output_write(out, text, (size_t)length, error);
    for (size_t k = 0; good && k < figures->all.count; k++) {
        const counted_run *f = &figures->all.runs[k];
        if (f->count == 0) continue;
        length = snprintf(text, sizeof text, "%s,%s,%s,%s,%" PRIu64 ",%" PRIu64 "\n", f->kernel, f->leaf, f->field,
                          f->rays, f->count, f->events[IR]);
        good = io_output_write(out, text, (size_t)length, error);
    }
    return good;
}

/* ---- compared ---- */

static const counted_run *find(const counted *in, const counted_run *like) {
    for (size_t k = 0; k < in->count; k++) {
        const counted_run *f = &in->runs[k];
        if (strcmp(f->kernel, like->kernel) == 0 && strcmp(f->leaf, like->leaf) == 0 &&
            strcmp(f->field, like->field) == 0 && strcmp(f->rays, like->rays) == 0)
            return f;
    }
    return NULL;
}

static void compare_one(const counted_run *is, const counted_run *was, guard_verdict *v, FILE *report) {
    const uint64_t now = is->events[IR], before = was->events[IR];
    const bool above = now * 100 > before * (100 + GUARD_TOLERANCE),
               below = now * 100 < before * (100 - GUARD_TOLERANCE);
    v->compared++;
    v->above += above;
    v->below += below;
    if (above || below)
        fprintf(report,
                "%s, %s, field %s, %s rays: %" PRIu64 " instructions (%.1f a ray), %.1f %% %s the figure %" PRIu64
                "; the limit is %" PRIu64 "\n",
                is->kernel, is->leaf, is->field, is->rays, now, (double)now / (double)is->count,
                (above ? 100 : -100) * ((double)now / (double)before - 1), above ? "above" : "below", before,
                before * (100 + GUARD_TOLERANCE) / 100);
}

guard_verdict guard_compare(const counted *committed, const counted *now, FILE *report) {
    guard_verdict v = {0};
    for (size_t k = 0; k < now->count; k++) {
        const counted_run *is = &now->runs[k], *was = find(committed, is);
        if (is->count == 0) continue;
        if (was && was->count == is->count) {
            compare_one(is, was, &v, report);
            continue;
        }
        v.missing++;
        fprintf(report, "%s, %s, field %s, %s rays: no figure for %" PRIu64 " rays\n", is->kernel, is->leaf, is->field,
                is->rays, is->count);
    }
    for (size_t k = 0; k < committed->count; k++) {
        const counted_run *was = &committed->runs[k];
        counted_run absent = {.count = 0};
        memcpy(absent.kernel, was->kernel, sizeof absent.kernel);
        const bool known = find(now, was) != NULL, here = find(now, &absent) == NULL;
        v.absent += !known && !here;
        v.stale += !known && here;
        if (!known && here)
            fprintf(report, "%s, %s, field %s, %s rays: there is a figure, but this program does not trace them\n",
                    was->kernel, was->leaf, was->field, was->rays);
    }
    return v;
}
