/* SPDX-License-Identifier: Apache-2.0 */
#include "stability_page.h"

#include "results.h"
#include "run_record.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

static const char *const verdict_keys[VERDICTS] = {"right", "tie", "leak", "phantom", "wrong_surface"};

/* What a contender is before the reference: "reference", "same-bits", "own-rules". */
static const char *const roles[] = {"reference", "same-bits", "own-rules"};

static json_t *result_line(const tested *t, aim kind, const counts *c) {
    json_t *line = json_object();
    results_set_text(line, "kind", "result");
    results_set_text(line, "contender", t->contender.name);
    results_set_text(line, "role", roles[t->role]);
    results_set_text(line, "rays", aim_name(kind));
    results_set_count(line, "traced", c->rays);
    results_set_count(line, "hits", c->hits);
    results_set_count(line, "other_bits", c->other);
    if (t->role == ROLE_SAME_BITS) return line;
    results_set_count(line, "pass", c->pass);
    results_set_count(line, "leaks", c->leaks);
    results_set_count(line, "phantoms", c->phantoms);
    results_set_count(line, "decided_exactly", c->doubts);
    results_set_number(line, "residual", c->residual);
    results_set_number(line, "apart", c->apart);
    results_set_count(line, "sampled", c->sampled);
    json_t *verdicts = json_object();
    for (int v = 0; v < VERDICTS; v++) results_set_count(verdicts, verdict_keys[v], c->verdict[v]);
    json_object_set_new(line, "verdicts", verdicts);
    results_set_number(line, "t_error", c->t_error);
    json_t *ulp = json_array();
    for (int k = 0; k < ULP_BINS; k++) json_array_append_new(ulp, json_integer((json_int_t)c->ulp[k]));
    json_object_set_new(line, "t_error_ulp", ulp);
    return line;
}

static bool write_lines(io_output *out, const stability *s, double seconds, io_error *error) {
    json_t *run = run_record("stability", 0, -1);
    results_set_count(run, "part", s->range.part);
    results_set_count(run, "parts", s->range.parts);
    results_set_count(run, "first", s->range.first);
    results_set_count(run, "end", s->range.end);
    results_set_count(run, "batches", s->batches);
    results_set_count(run, "sample", s->sample);
    results_set_number(run, "seconds", seconds);
    if (!results_write(out, run, error)) return false;
    for (size_t f = 0; f < AIMED_FIELDS; f++) {
        json_t *line = json_object();
        results_set_text(line, "kind", "field");
        results_set_text(line, "field", s->field[f].name);
        results_set_text(line, "text", s->field[f].text);
        if (!results_write(out, line, error)) return false;
    }
    for (unsigned n = 0; n < s->contenders; n++)
        for (int kind = 0; kind < AIM_COUNT; kind++) {
            const counts *c = &s->count[n][kind];
            if (c->rays && !results_write(out, result_line(&s->tested[0][n], (aim)kind, c), error)) return false;
        }
    return true;
}

bool stability_write(const stability *s, const char *path, double seconds, io_error *error) {
    io_output out = {0};
    const bool good =
        io_output_open(&out, path, error) && write_lines(&out, s, seconds, error) && io_output_commit(&out, error);
    io_output_discard(&out);
    return good;
}

/* ---- reading it back --------------------------------------------------------------------------------------------- */

typedef struct row {
    char name[CONTENDER_NAME];
    contender_role role;
    counts count[AIM_COUNT];
} row;

enum { FILES_MAX = 64 };

typedef struct page {
    row rows[CONTENDERS_MAX];
    batch_range range[FILES_MAX];
    size_t files;
    size_t count;
    unsigned sample;
    double seconds;
    char machine[512];
} page;

static uint64_t number(const json_t *line, const char *key) { return (uint64_t)results_number(line, key); }

static row *row_of(page *p, const char *name, const char *role) {
    for (size_t k = 0; k < p->count; k++)
        if (strcmp(p->rows[k].name, name) == 0) return &p->rows[k];
    if (p->count == CONTENDERS_MAX) return NULL;
    row *r = &p->rows[p->count++];
    snprintf(r->name, sizeof r->name, "%s", name);
    for (int k = 0; k < 3; k++)
        if (strcmp(role, roles[k]) == 0) r->role = (contender_role)k;
    return r;
}

static bool add_line(page *p, const json_t *line) {
    if (strcmp(results_text(line, "kind"), "result") != 0) return true;
    int kind = 0;
    while (kind < AIM_COUNT && strcmp(results_text(line, "rays"), aim_name((aim)kind)) != 0) kind++;
    row *r = row_of(p, results_text(line, "contender"), results_text(line, "role"));
    if (r == NULL || kind == AIM_COUNT) return false;
    counts c = {.rays = number(line, "traced"),
                .hits = number(line, "hits"),
                .pass = number(line, "pass"),
                .leaks = number(line, "leaks"),
                .phantoms = number(line, "phantoms"),
                .doubts = number(line, "decided_exactly"),
                .other = number(line, "other_bits"),
                .residual = results_number(line, "residual"),
                .apart = results_number(line, "apart"),
                .sampled = number(line, "sampled"),
                .t_error = results_number(line, "t_error")};
    for (int v = 0; v < VERDICTS; v++) c.verdict[v] = number(json_object_get(line, "verdicts"), verdict_keys[v]);
    for (int k = 0; k < ULP_BINS; k++)
        c.ulp[k] = (uint64_t)json_integer_value(json_array_get(json_object_get(line, "t_error_ulp"), (size_t)k));
    counts_add(&r->count[kind], &c);
    return true;
}

/* Rays that two files have traced must not count twice. */
static bool add_range(page *p, const json_t *run, const char *path, io_error *error) {
    const batch_range now = {.part = (unsigned)number(run, "part"),
                             .parts = (unsigned)number(run, "parts"),
                             .first = number(run, "first"),
                             .end = number(run, "end")};
    for (size_t k = 0; k < p->files; k++) {
        const batch_range *r = &p->range[k];
        const bool other_part = r->parts == now.parts && r->part != now.part;
        if (!other_part && r->first < now.end && now.first < r->end)
            return io_fail(error, "%s:1: batches %llu to %llu are in another file as well", path,
                           (unsigned long long)now.first, (unsigned long long)now.end);
    }
    if (p->files == FILES_MAX) return io_fail(error, "%s: more than %d files", path, FILES_MAX);
    p->range[p->files++] = now;
    return true;
}

static bool read_file(page *p, const char *path, io_error *error) {
    json_t *lines = results_read(path, error);
    if (lines == NULL) return false;
    const json_t *run = json_array_get(lines, 0);
    const char *command = results_text(run, "command");
    bool good = strcmp(command, "stability") == 0 ||
                io_fail(error, "%s:1: results of '%s', not of cellwalk-stability run", path, command);
    good = good && add_range(p, run, path, error);
    if (p->machine[0] == 0) run_record_text(run, p->machine, sizeof p->machine);
    p->sample = (unsigned)number(run, "sample");
    p->seconds += results_number(run, "seconds");
    const json_t *line;
    size_t index;
    json_array_foreach(lines, index, line) {
        if (good && !add_line(p, line)) good = io_fail(error, "%s:%zu: unknown class of rays", path, index + 1);
    }
    json_decref(lines);
    return good;
}

/* ---- Markdown ---------------------------------------------------------------------------------------------------- */

static counts total(const row *r) {
    counts sum = {0};
    for (int kind = 0; kind < AIM_COUNT; kind++) counts_add(&sum, &r->count[kind]);
    return sum;
}

static void print_cell(FILE *to, uint64_t n) {
    fputs(" ", to);
    stability_print_count(to, n);
    fputs(" |", to);
}

/* The error of t that half of the right hits do not exceed, in ulp. */
static double median_ulp(const counts *c) {
    uint64_t all = 0, sum = 0;
    for (int k = 0; k < ULP_BINS; k++) all += c->ulp[k];
    for (int k = 0; k < ULP_BINS; k++) {
        sum += c->ulp[k];
        if (2 * sum >= all) return ldexp(1, k - 1);
    }
    return 0;
}

static void reference_line(FILE *to, const char *what, const counts *c) {
    fprintf(to, "| %s |", what);
    print_cell(to, c->rays);
    print_cell(to, c->pass);
    fprintf(to, " **%llu** | **%llu** |", (unsigned long long)c->leaks, (unsigned long long)c->phantoms);
    fprintf(to, " %.2f | %.2f |", c->residual, c->apart);
    print_cell(to, c->sampled);
    print_cell(to, c->verdict[VERDICT_TIE]);
    fprintf(to, " **%llu** | %.2f | %g |\n", (unsigned long long)c->verdict[VERDICT_WRONG_SURFACE], c->t_error,
            median_ulp(c));
}

static void reference_table(FILE *to, const row *r) {
    fprintf(to, "`%s`, a line a class of rays:\n\n", r->name);
    fputs("| rays | traced | known to pass | leaks | phantoms | worst \\|d\\| / E | worst distance / delta | judged in "
          "full | ties | wrong surface | worst error of t / bound | its median, ulp |\n"
          "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
          to);
    for (int kind = 0; kind < AIM_COUNT; kind++) reference_line(to, aim_text((aim)kind), &r->count[kind]);
    const counts sum = total(r);
    reference_line(to, "all", &sum);
}

/* A line a contender, all classes together. */
static void summary_table(FILE *to, const page *p) {
    fputs("| contender | rays | known to pass | leaks | phantoms | judged in full | wrong surfaces | other answers "
          "than the "
          "reference's |\n|---|--:|--:|--:|--:|--:|--:|--:|\n",
          to);
    for (size_t k = 0; k < p->count; k++) {
        const counts c = total(&p->rows[k]);
        fprintf(to, "| `%s` |", p->rows[k].name);
        print_cell(to, c.rays);
        if (p->rows[k].role == ROLE_SAME_BITS) {
            fputs(" | | | | |", to);
        } else {
            print_cell(to, c.pass);
            print_cell(to, c.leaks);
            print_cell(to, c.phantoms);
            print_cell(to, c.sampled);
            print_cell(to, c.verdict[VERDICT_WRONG_SURFACE]);
        }
        if (p->rows[k].role == ROLE_OTHER_RULES)
            fputs(" |", to);
        else
            print_cell(to, c.other);
        fputc('\n', to);
    }
}

static void rate(FILE *to, uint64_t n, uint64_t of) {
    if (of == 0)
        fputs(" |", to);
    else if (n == 0)
        fputs(" 0 |", to);
    else
        fprintf(to, " %.3g |", 1e6 * (double)n / (double)of);
}

static void rates_table(FILE *to, const page *p, bool leaks) {
    fprintf(to, "\n%s per million %s:\n\n| rays |", leaks ? "Leaks" : "Phantoms",
            leaks ? "rays that are known to pass" : "hits");
    for (size_t k = 0; k < p->count; k++)
        if (p->rows[k].role != ROLE_SAME_BITS) fprintf(to, " %s |", p->rows[k].name);
    fputs("\n|---|", to);
    for (size_t k = 0; k < p->count; k++)
        if (p->rows[k].role != ROLE_SAME_BITS) fputs("---:|", to);
    for (int kind = 0; kind < AIM_COUNT; kind++) {
        fprintf(to, "\n| %s |", aim_text((aim)kind));
        for (size_t k = 0; k < p->count; k++) {
            const counts *c = &p->rows[k].count[kind];
            if (p->rows[k].role == ROLE_SAME_BITS) continue;
            if (leaks)
                rate(to, c->leaks, c->pass);
            else
                rate(to, c->phantoms, c->hits);
        }
    }
    if (!leaks) {
        fputs("\n| *wrong surfaces*, of rays judged in full |", to);
        for (size_t k = 0; k < p->count; k++) {
            if (p->rows[k].role == ROLE_SAME_BITS) continue;
            const counts sum = total(&p->rows[k]);
            rate(to, sum.verdict[VERDICT_WRONG_SURFACE], sum.sampled);
        }
    }
    fputs("\n| *rays traced* |", to);
    for (size_t k = 0; k < p->count; k++) {
        if (p->rows[k].role == ROLE_SAME_BITS) continue;
        const counts sum = total(&p->rows[k]);
        print_cell(to, sum.rays);
    }
    fputs("\n", to);
}

static void aimed_tables(FILE *to, const page *p) {
    const counts sum = total(&p->rows[0]);
    fputs("\n", to);
    stability_print_count(to, sum.rays);
    fprintf(to, " rays, of which one in %u was judged in full; %.0f seconds of CPU time on one thread. %s.\n\n",
            p->sample, p->seconds, p->machine);
    summary_table(to, p);
    fputs("\n", to);
    reference_table(to, &p->rows[0]);
    rates_table(to, p, true);
    rates_table(to, p, false);
    fputs("\n", to);
}

static bool read_aimed(page *p, const char *const *paths, size_t count, io_error *error) {
    bool good = true;
    for (size_t k = 0; good && k < count; k++) good = read_file(p, paths[k], error);
    return good && (p->count > 0 || io_fail(error, "%s: no results in it", paths[0]));
}

typedef void put_lines(FILE *to, const json_t *lines);

/* What a file of results other than the long run's becomes, by its command. */
static const struct {
    const char *command, *mark;
    put_lines *put;
} tables[] = {
    {"extremes", "extremes", stability_extremes},
    {"exhaustive", "exhaustive", stability_exhaustive},
    {"stress", "stress", stability_stress},
    {"micro", "leaf", stability_leaf},
};
enum { TABLES = sizeof tables / sizeof tables[0] };

char *stability_page(const char *const *paths, size_t count, const char **mark, io_error *error) {
    json_t *lines = results_read(paths[0], error);
    if (lines == NULL) return NULL;
    size_t table = 0;
    while (table < TABLES && strcmp(results_text(json_array_get(lines, 0), "command"), tables[table].command) != 0)
        table++;
    *mark = table < TABLES ? tables[table].mark : "stability";
    page *p = calloc(1, sizeof *p);
    char *text = NULL;
    size_t size = 0;
    bool good = p != NULL || io_fail(error, "out of memory");
    if (table < TABLES)
        good = good && (count == 1 || io_fail(error, "%s: cannot be added to other files", paths[0]));
    else
        good = good && read_aimed(p, paths, count, error);
    FILE *to = good ? open_memstream(&text, &size) : NULL;
    if (to) {
        if (table < TABLES)
            tables[table].put(to, lines);
        else
            aimed_tables(to, p);
        if (fclose(to) != 0) good = io_fail(error, "out of memory");
    }
    json_decref(lines);
    free(p);
    if (good && text) return text;
    free(text);
    return NULL;
}
