/* SPDX-License-Identifier: Apache-2.0 */
#include "instructions/callgrind.h"

#include "harness/child.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* ---- lines ---- */

bool callgrind_take_name(char **rest, char name[COUNTED_NAME]) {
    const char *field = *rest ? strsep(rest, ",") : NULL;
    if (field == NULL || *field == '\0' || strlen(field) >= COUNTED_NAME) return false;
    memcpy(name, field, strlen(field) + 1);
    return true;
}

bool callgrind_take_number(char **rest, uint64_t *number) {
    char *end;
    if (*rest == NULL || **rest < '0' || **rest > '9') return false;
    errno = 0;
    *number = strtoull(*rest, &end, 10);
    if (errno != 0 || (*end != ',' && *end != '\0')) return false;
    *rest = *end ? end + 1 : NULL;
    return true;
}

bool callgrind_read_lines(const char *path, callgrind_take_line *take, void *context, io_error *error) {
    FILE *file = fopen(path, "r");
    if (file == NULL) return io_fail(error, "%s: %s", path, strerror(errno));
    char *line = NULL;
    size_t size = 0, number = 0;
    bool good = true;
    while (good && getline(&line, &size, file) >= 0) {
        number++;
        line[strcspn(line, "\n")] = '\0';
        good = take(context, line) || io_fail(error, "%s:%zu: not a line of figures, or one too many", path, number);
    }
    if (good && ferror(file)) good = io_fail(error, "%s: %s", path, strerror(errno));
    free(line);
    fclose(file);
    return good;
}

static bool take_run(void *context, char *line) {
    counted *all = context;
    if (all->count == COUNTED_MAX) return false;
    counted_run *r = &all->runs[all->count++];
    *r = (counted_run){.count = 0};
    char kind[COUNTED_NAME];
    if (!callgrind_take_name(&line, kind) || !callgrind_take_name(&line, r->kernel)) return false;
    if (strcmp(kind, "absent") == 0) return true;
    return strcmp(kind, "run") == 0 && callgrind_take_name(&line, r->leaf) && callgrind_take_name(&line, r->field) &&
           callgrind_take_name(&line, r->rays) && callgrind_take_number(&line, &r->count) && line == NULL;
}

/* ---- profiles ---- */

/* The parts of callgrind's format that matter here (names and positions are not compressed): "part:" begins the
 * counts of one run. "ob=" names the file whose code the next lines count. After "calls=" the next line has the
 * numbers of a whole call, which other lines count too. Numbers that are 0 are missing at the end of a line. */
typedef struct profile {
    counted *all;
    const char *program;
    size_t next;      /* of the runs that were counted, the one whose part comes next */
    counted_run *run; /* whose part this is */
    bool own, of_call;
} profile;

static bool ends_with_file(const char *path, const char *name) {
    const char *slash = strrchr(path, '/');
    return strcmp(slash ? slash + 1 : path, name) == 0;
}

static bool take_profile(void *context, char *line) {
    profile *p = context;
    if (strncmp(line, "part:", 5) == 0) {
        while (p->next < p->all->count && p->all->runs[p->next].count == 0) p->next++;
        p->run = p->next < p->all->count ? &p->all->runs[p->next++] : NULL;
        p->own = p->of_call = false;
    } else if (strncmp(line, "ob=", 3) == 0) {
        p->own = ends_with_file(line + 3, p->program);
    } else if (strncmp(line, "calls=", 6) == 0) {
        p->of_call = true;
    } else if (line[0] >= '0' && line[0] <= '9') {
        char *rest = strchr(line, ' ');
        if (p->run && p->own && !p->of_call)
            for (int e = 0; e < EVENTS && rest && *rest; e++) p->run->events[e] += strtoull(rest, &rest, 10);
        p->of_call = false;
    }
    return true;
}

bool callgrind_read(counted *all, const char *runs_path, const char *profile_path, const char *program,
                    io_error *error) {
    profile p = {.all = all, .program = program};
    all->count = 0;
    if (!callgrind_read_lines(runs_path, take_run, all, error) ||
        !callgrind_read_lines(profile_path, take_profile, &p, error))
        return false;
    for (size_t k = 0; k < all->count; k++) {
        const counted_run *r = &all->runs[k];
        if (r->count > 0 && r->events[IR] == 0)
            return io_fail(error, "%s: has no counts of %s for %s rays with %s", profile_path, program, r->rays,
                           r->kernel);
    }
    return true;
}

/* ---- running ---- */

bool callgrind_run(counted *all, const char *name, const char *const *work, const char *const *options, bool *missing,
                   io_error *error) {
    enum { WORDS_MAX = 24 };
    char line[512], runs[64], errors[64], out[64];
    const char *words[WORDS_MAX], *slash = strrchr(work[0], '/');
    size_t count = 0;
    snprintf(runs, sizeof runs, "%s.runs", name);
    snprintf(errors, sizeof errors, "%s.errors", name);
    snprintf(out, sizeof out, "%s.callgrind", name);
    snprintf(line, sizeof line,
             "valgrind -q --tool=callgrind --collect-atstart=no --toggle-collect=guard_trace --dump-after=guard_trace "
             "--combine-dumps=yes --compress-strings=no --compress-pos=no --callgrind-out-file=%s",
             out);
    for (char *word = strtok(line, " "); word; word = strtok(NULL, " ")) words[count++] = word;
    for (; options && *options; options++) words[count++] = *options;
    for (const char *const *word = work; *word && count + 1 < WORDS_MAX; word++) words[count++] = *word;
    words[count] = NULL;
    const int status = child_run(words, runs, errors);
    *missing = status == 127;
    if (*missing) return io_fail(error, "valgrind is not installed (Debian: valgrind)");
    if (status != 0) return io_fail(error, "valgrind on %s: %s", work[0], status < 0 ? strerror(errno) : "failed");
    return callgrind_read(all, runs, out, slash ? slash + 1 : work[0], error);
}
