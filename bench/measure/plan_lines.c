/* SPDX-License-Identifier: Apache-2.0 */
/* Plans: lines of text, and the table of the kinds of workloads. */

#include "build_info.h"
#include "harness/harness_memory.h"
#include "inputs.h"
#include "measure/measure.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const workload_kind *const kinds[] = {&measure_rays, &measure_scene, &measure_build, &measure_horizon,
                                             &measure_sky};

const workload_kind *measure_kind(size_t number) {
    return number < sizeof kinds / sizeof *kinds ? kinds[number] : NULL;
}

static bool metrics_of(char *text, unsigned *metrics, io_error *error) {
    static const struct {
        const char *name;
        unsigned metrics;
    } all[] = {{"time", METRIC_TIME | METRIC_AGREE},
               {"agree", METRIC_AGREE},
               {"error", METRIC_ERROR},
               {"instructions", METRIC_INSTRUCTIONS}};
    *metrics = 0;
    char *rest = text;
    for (char *word; (word = strsep(&rest, ",")) != NULL;) {
        size_t k = 0;
        while (k < sizeof all / sizeof *all && strcmp(word, all[k].name) != 0) k++;
        if (k == sizeof all / sizeof *all)
            return io_fail(error, "%s: no metric; these are time, agree, error and instructions", word);
        *metrics |= all[k].metrics;
    }
    return true;
}

/* Finds the kind of work and looks for all that the line names. */
static bool check_line(plan_line *line, const measure_options *o, io_error *error) {
    const char *slash = strrchr(line->workload, '/');
    snprintf(line->field, sizeof line->field, "%.*s", (int)(slash - line->workload), line->workload);
    snprintf(line->item, sizeof line->item, "%s", slash + 1);
    const bool of_field = strcmp(line->field, "scenes") != 0;
    for (size_t k = 0; measure_kind(k); k++) {
        const workload_kind *kind = measure_kind(k);
        if (kind->item ? of_field && strcmp(kind->item, line->item) == 0 : kind->has(line->field, line->item))
            line->kind = kind;
    }
    if (line->kind == NULL)
        return io_fail(error, "%s: there is no such work; cellwalk-bench measure --help lists all", line->workload);
    for (size_t k = 0; k < line->count; k++)
        if (!line->kind->knows(line->contenders[k], error)) return false;
    if (of_field) return land_check(line->field, o, error);
    scene *s = scene_of(line->item, o, error);
    if (s) scene_free(s);
    return s != NULL;
}

/* FIELDS/ITEMS stands for each field with each item. A path has slashes of its own, so the last one counts. */
static bool add_line(plan *p, const char *workloads, char *const *contenders, size_t count, unsigned metrics, int isa,
                     const measure_options *o, io_error *error) {
    const char *slash = strrchr(workloads, '/');
    if (slash == NULL || slash == workloads || slash[1] == '\0') return false;
    char fields[MEASURE_NAME], items[MEASURE_NAME], *next = fields;
    if (slash - workloads >= MEASURE_NAME || strlen(slash) > MEASURE_NAME)
        return io_fail(error, "more than %d characters of fields or of works", MEASURE_NAME - 1);
    snprintf(fields, sizeof fields, "%.*s", (int)(slash - workloads), workloads);
    for (char *name; (name = strsep(&next, ",")) != NULL;) {
        snprintf(items, sizeof items, "%s", slash + 1);
        char *next_item = items;
        for (char *item; (item = strsep(&next_item, ",")) != NULL;) {
            p->lines = realloc(p->lines, (p->count + 1) * sizeof *p->lines);
            if (p->lines == NULL) memory_end();
            plan_line *line = &p->lines[p->count++];
            *line = (plan_line){.count = count, .metrics = metrics, .number = p->number, .isa = isa};
            const char *of = o->field && strcmp(name, "FIELD") == 0 ? o->field : name;
            if (snprintf(line->workload, sizeof line->workload, "%s/%s", of, item) >= (int)sizeof line->workload)
                return false;
            memcpy(line->contenders, contenders, count * sizeof *contenders);
            if (!check_line(line, o, error)) return false;
        }
    }
    return true;
}

static bool take_line(plan *p, char *text, const measure_options *o, io_error *error) {
    char *words[5], *contenders[ENTRANTS_MAX], *rest = text;
    size_t count = 0, entered = 0;
    unsigned metrics;
    for (char *word; count < 5 && (word = strsep(&rest, " \t")) != NULL;)
        if (*word) words[count++] = word;
    if (count < 3 || count > 4 || !metrics_of(words[2], &metrics, error)) return false;
    for (char *name; (name = strsep(&words[1], ",")) != NULL;) {
        if (*name == '\0' || entered == ENTRANTS_MAX) return false;
        contenders[entered++] = name;
    }
    if (count == 3) return add_line(p, words[0], contenders, entered, metrics, -1, o, error);
    for (char *name; (name = strsep(&words[3], ",")) != NULL;) {
        int isa = CW_ISA_COUNT - 1;
        while (isa >= CW_ISA_SCALAR && strcmp(name, cw_isa_name((cw_isa)isa)) != 0) isa--;
        if (isa < CW_ISA_SCALAR) return io_fail(error, "%s: no instruction set", name);
        if (!add_line(p, words[0], contenders, entered, metrics, isa, o, error)) return false;
    }
    return true;
}

bool measure_plan_read(plan *p, const char *name, const measure_options *o, io_error *error) {
    io_error why = {"a line is FIELD/WORK CONTENDERS METRICS [ISAS], with commas in lists"};
    char shipped[4096];
    size_t size;
    *p = (plan){0};
    snprintf(shipped, sizeof shipped, "%s/%s.plan", BUILD_INFO_PLANS, name);
    struct stat about;
    const bool is_file = (stat(name, &about) == 0 && !S_ISDIR(about.st_mode)) || strchr(name, '/') != NULL;
    const char *path = is_file ? name : shipped;
    if (access(path, F_OK) != 0) return io_fail(error, "%s: no such plan, neither a file nor one that ships", name);
    p->text = io_file_read(path, &size, error);
    bool good = p->text != NULL && (o->field == NULL || land_check(o->field, o, error));
    char *rest = p->text;
    for (char *line; good && (line = strsep(&rest, "\n")) != NULL;) {
        p->number++;
        line[strcspn(line, "#")] = '\0';
        if (line[strspn(line, " \t")] == '\0') continue;
        good = take_line(p, line, o, &why) || io_fail(error, "%s:%zu: %s", path, p->number, why.text);
    }
    if (good && p->count == 0) good = io_fail(error, "%s: has no line to measure", path);
    if (!good) measure_plan_free(p);
    return good;
}

void measure_plan_free(plan *p) {
    free(p->text);
    free(p->lines);
    *p = (plan){0};
}
