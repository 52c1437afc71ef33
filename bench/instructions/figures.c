/* SPDX-License-Identifier: Apache-2.0 */
#include "instructions/figures.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

static const char *const heading = "kernel,leaf,rays,count,instructions";

static FILE *open_text(const char *path, io_error *error) {
    FILE *file = fopen(path, "r");
    if (file == NULL) io_fail(error, "%s: %s", path, strerror(errno));
    return file;
}

/* Cuts the next field off a line of commas; false if it is missing, empty or longer than a name. */
static bool take_name(char **rest, char name[GUARD_NAME]) {
    const char *field = *rest ? strsep(rest, ",") : NULL;
    if (field == NULL || *field == '\0' || strlen(field) >= GUARD_NAME) return false;
    memcpy(name, field, strlen(field) + 1);
    return true;
}

static bool take_number(char **rest, uint64_t *number) {
    char *end;
    if (*rest == NULL || **rest < '0' || **rest > '9') return false;
    errno = 0;
    *number = strtoull(*rest, &end, 10);
    if (errno != 0 || (*end != ',' && *end != '\0')) return false;
    *rest = *end ? end + 1 : NULL;
    return true;
}

/* Calls take for each line, without its end. */
typedef bool take_line(guard_figures *figures, char *line);
static bool read_lines(guard_figures *figures, const char *path, take_line *take, io_error *error) {
    FILE *file = open_text(path, error);
    if (file == NULL) return false;
    char *line = NULL;
    size_t size = 0, number = 0;
    bool good = true;
    while (good && getline(&line, &size, file) >= 0) {
        number++;
        line[strcspn(line, "\n")] = '\0';
        good = take(figures, line) || io_fail(error, "%s:%zu: not a line of figures, or one too many", path, number);
    }
    if (good && ferror(file)) good = io_fail(error, "%s: %s", path, strerror(errno));
    free(line);
    fclose(file);
    return good;
}

/* ---- counted ---- */

static bool take_run(guard_figures *figures, char *line) {
    if (figures->count == GUARD_FIGURES_MAX) return false;
    guard_figure *f = &figures->items[figures->count++];
    *f = (guard_figure){0};
    char kind[GUARD_NAME];
    if (!take_name(&line, kind) || !take_name(&line, f->kernel)) return false;
    if (strcmp(kind, "absent") == 0) return true;
    return strcmp(kind, "run") == 0 && take_name(&line, f->leaf) && take_name(&line, f->rays) &&
           take_number(&line, &f->count) && line == NULL;
}

/* What callgrind's format says here (names and positions are not compressed): "part:" begins the counts of one run,
 * "ob=" names the file whose code the lines after it count, "calls=" makes the next line's number that of a whole call,
 * which is counted where it was spent as well. */
typedef struct profile {
    size_t part; /* from 1 on */
    bool own, of_call;
} profile;

static bool ends_with_file(const char *path, const char *name) {
    const char *slash = strrchr(path, '/');
    path = slash ? slash + 1 : path;
    return strncmp(path, name, strlen(name)) == 0 && strcspn(path, "\n") == strlen(name);
}

/* The count of a line of the program's own instructions, else 0. */
static uint64_t own_cost(profile *p, const char *line, const char *program) {
    if (strncmp(line, "part:", 5) == 0) {
        p->part++;
        p->own = p->of_call = false;
    } else if (strncmp(line, "ob=", 3) == 0) {
        p->own = ends_with_file(line + 3, program);
    } else if (strncmp(line, "calls=", 6) == 0) {
        p->of_call = true;
    } else if (line[0] >= '0' && line[0] <= '9') {
        const char *cost = strchr(line, ' ');
        const bool counts = p->own && !p->of_call && cost;
        p->of_call = false;
        return counts ? strtoull(cost + 1, NULL, 10) : 0;
    }
    return 0;
}

/* The next figure that was run, from number on. */
static guard_figure *next_run(guard_figures *figures, size_t *number) {
    while (*number < figures->count && figures->items[*number].count == 0) (*number)++;
    return *number < figures->count ? &figures->items[(*number)++] : NULL;
}

bool guard_read_counts(guard_figures *figures, const char *runs_path, const char *profile_path, const char *program,
                       io_error *error) {
    figures->count = 0;
    if (!read_lines(figures, runs_path, take_run, error)) return false;
    FILE *file = open_text(profile_path, error);
    if (file == NULL) return false;
    profile p = {0};
    size_t number = 0, part = 0;
    guard_figure *figure = NULL;
    char *line = NULL;
    size_t size = 0;
    while (getline(&line, &size, file) >= 0) {
        const uint64_t cost = own_cost(&p, line, program);
        if (p.part != part) {
            part = p.part;
            figure = next_run(figures, &number);
        }
        if (figure) figure->instructions += cost;
    }
    free(line);
    fclose(file);
    for (size_t k = 0; k < figures->count; k++)
        if (figures->items[k].count > 0 && figures->items[k].instructions == 0)
            return io_fail(error, "%s: has no counts of %s for %s rays with %s", profile_path, program,
                           figures->items[k].rays, figures->items[k].kernel);
    return true;
}

/* ---- committed ---- */

static bool take_comment(const char *line, const char *key, char text[GUARD_BUILD]) {
    const size_t length = strlen(key);
    if (strncmp(line, key, length) != 0) return false;
    snprintf(text, GUARD_BUILD, "%s", line + length);
    return true;
}

static bool take_figure(guard_figures *figures, char *line) {
    if (take_comment(line, "# compiler: ", figures->compiler) || take_comment(line, "# flags: ", figures->flags) ||
        line[0] == '#' || strcmp(line, heading) == 0)
        return true;
    if (figures->count == GUARD_FIGURES_MAX) return false;
    guard_figure *f = &figures->items[figures->count++];
    return take_name(&line, f->kernel) && take_name(&line, f->leaf) && take_name(&line, f->rays) &&
           take_number(&line, &f->count) && take_number(&line, &f->instructions) && line == NULL && f->instructions > 0;
}

bool guard_read(guard_figures *figures, const char *path, io_error *error) {
    *figures = (guard_figures){0};
    return read_lines(figures, path, take_figure, error);
}

bool guard_write(const guard_figures *figures, io_output *out, io_error *error) {
    char text[4 * GUARD_BUILD];
    int length = snprintf(text, sizeof text,
                          "# Instructions of the guard's workload; written by the build target guard-update.\n"
                          "# compiler: %s\n# flags: %s\n%s\n",
                          figures->compiler, figures->flags, heading);
    bool good = io_output_write(out, text, (size_t)length, error);
    for (size_t k = 0; good && k < figures->count; k++) {
        const guard_figure *f = &figures->items[k];
        if (f->count == 0) continue;
        length = snprintf(text, sizeof text, "%s,%s,%s,%" PRIu64 ",%" PRIu64 "\n", f->kernel, f->leaf, f->rays,
                          f->count, f->instructions);
        good = io_output_write(out, text, (size_t)length, error);
    }
    return good;
}

/* ---- compared ---- */

static const guard_figure *find(const guard_figures *in, const guard_figure *like) {
    for (size_t k = 0; k < in->count; k++) {
        const guard_figure *f = &in->items[k];
        if (strcmp(f->kernel, like->kernel) == 0 && strcmp(f->leaf, like->leaf) == 0 &&
            strcmp(f->rays, like->rays) == 0)
            return f;
    }
    return NULL;
}

static bool is_absent(const guard_figures *counted, const char *kernel) {
    for (size_t k = 0; k < counted->count; k++)
        if (counted->items[k].count == 0 && strcmp(counted->items[k].kernel, kernel) == 0) return true;
    return false;
}

static void compare_one(const guard_figure *is, const guard_figure *was, guard_verdict *v, FILE *report) {
    const double change = 100 * ((double)is->instructions / (double)was->instructions - 1);
    v->compared++;
    if (is->instructions * 100 > was->instructions * (100 + GUARD_TOLERANCE)) {
        v->above++;
        fprintf(report,
                "%s, %s, %s rays: %" PRIu64 " instructions (%.1f a ray) are %.1f %% above the figure %" PRIu64
                "; the limit is %" PRIu64 "\n",
                is->kernel, is->leaf, is->rays, is->instructions, (double)is->instructions / (double)is->count, change,
                was->instructions, was->instructions * (100 + GUARD_TOLERANCE) / 100);
    } else if (is->instructions * 100 < was->instructions * (100 - GUARD_TOLERANCE)) {
        v->below++;
        fprintf(report, "%s, %s, %s rays: %" PRIu64 " instructions are %.1f %% below the figure %" PRIu64 "\n",
                is->kernel, is->leaf, is->rays, is->instructions, -change, was->instructions);
    }
}

guard_verdict guard_compare(const guard_figures *committed, const guard_figures *counted, FILE *report) {
    guard_verdict v = {0};
    for (size_t k = 0; k < counted->count; k++) {
        const guard_figure *is = &counted->items[k], *was = find(committed, is);
        if (is->count == 0) continue;
        if (was && was->count == is->count) {
            compare_one(is, was, &v, report);
            continue;
        }
        v.missing++;
        fprintf(report, "%s, %s, %s rays: no figure for %" PRIu64 " rays\n", is->kernel, is->leaf, is->rays, is->count);
    }
    for (size_t k = 0; k < committed->count; k++) {
        const guard_figure *was = &committed->items[k];
        if (find(counted, was)) continue;
        if (is_absent(counted, was->kernel)) {
            v.absent++;
            continue;
        }
        v.stale++;
        fprintf(report, "%s, %s, %s rays: there is a figure, but this program does not trace them\n", was->kernel,
                was->leaf, was->rays);
    }
    return v;
}
