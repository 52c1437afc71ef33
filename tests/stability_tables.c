/* SPDX-License-Identifier: Apache-2.0 */
/* What the tests extremes, exhaustive and stress counted (CELLWALK_TEST_COUNTS), as tables; and what the leaf tests
 * cost. */

#include "stability_page.h"

#include "results.h"
#include "run_record.h"

#include <string.h>

enum { NAMES_MAX = 64 };

static uint64_t number(const json_t *line, const char *key) { return (uint64_t)results_number(line, key); }

void stability_print_count(FILE *to, uint64_t n) {
    char digits[24];
    const int length = snprintf(digits, sizeof digits, "%llu", (unsigned long long)n);
    for (int k = 0; k < length; k++) {
        if (k > 0 && (length - k) % 3 == 0) fputc(' ', to);
        fputc(digits[k], to);
    }
}

/* ---- extremes ---------------------------------------------------------------------------------------------------- */

/* The texts of a member in lines of kind "extreme", in order of first appearance. leaf may be NULL. */
static size_t distinct(const json_t *lines, const char *key, const char *leaf, const char *texts[NAMES_MAX]) {
    size_t count = 0, index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "extreme", NULL) || (leaf && strcmp(results_text(line, "leaf"), leaf) != 0)) continue;
        const char *text = results_text(line, key);
        size_t k = 0;
        while (k < count && strcmp(texts[k], text) != 0) k++;
        if (k == count && count < NAMES_MAX) texts[count++] = text;
    }
    return count;
}

/* "13 200", or "13 200 (12)" where 12 of them are excused; and how many were neither. */
static uint64_t answers(FILE *to, const json_t *line) {
    if (line == NULL || number(line, "asked") == 0) {
        fputs(" - |", to);
        return 0;
    }
    const uint64_t excused = number(line, "slipped") + number(line, "parallel") + number(line, "early");
    const uint64_t expected = number(line, "as_expected") + excused, asked = number(line, "asked");
    fputc(' ', to);
    stability_print_count(to, expected);
    if (excused) fprintf(to, " (%llu)", (unsigned long long)excused);
    fputs(" |", to);
    return asked - expected;
}

static void leaf_table(FILE *to, const json_t *lines, const char *leaf) {
    const char *items[NAMES_MAX], *kernels[NAMES_MAX];
    const size_t item_count = distinct(lines, "item", leaf, items);
    const size_t kernel_count = distinct(lines, "kernel", leaf, kernels);
    uint64_t wrong = 0;
    fprintf(to, "\nAnswers as expected, leaf test `%s`:\n\n| extreme |", leaf);
    for (size_t k = 0; k < kernel_count; k++) fprintf(to, " %s |", kernels[k]);
    fputs("\n|---|", to);
    for (size_t k = 0; k < kernel_count; k++) fputs("--:|", to);
    for (size_t n = 0; n < item_count; n++) {
        fprintf(to, "\n| %s |", items[n]);
        for (size_t k = 0; k < kernel_count; k++)
            wrong +=
                answers(to, results_find(lines, "extreme", "item", items[n], "kernel", kernels[k], "leaf", leaf, NULL));
    }
    fprintf(to, "\n\nNot as expected: **%llu**.\n", (unsigned long long)wrong);
}

void stability_extremes(FILE *to, const json_t *lines) {
    const char *items[NAMES_MAX];
    const size_t count = distinct(lines, "item", NULL, items);
    fputs("\n| extreme | rays | what is expected, and why |\n|---|--:|---|\n", to);
    for (size_t n = 0; n < count; n++) {
        uint64_t rays = 0;
        const json_t *line;
        size_t index;
        json_array_foreach(lines, index, line) {
            if (results_is(line, "extreme", "item", items[n], NULL) && number(line, "asked") > rays)
                rays = number(line, "asked");
        }
        fprintf(to, "| %s | ", items[n]);
        stability_print_count(to, rays);
        fprintf(to, " | %s |\n", results_text(results_find(lines, "extreme", "item", items[n], NULL), "expected"));
    }
    leaf_table(to, lines, "watertight");
    leaf_table(to, lines, "moller-trumbore");
    if (json_is_true(json_object_get(json_array_get(lines, 0), "emulated")))
        fputs("\nThe kernels 16 lanes wide ran through an emulation of AVX-512.\n", to);
    fputc('\n', to);
}

/* ---- exhaustive -------------------------------------------------------------------------------------------------- */

static void put(FILE *to, const json_t *line, const char *key) {
    fputc(' ', to);
    stability_print_count(to, number(line, key));
    fputs(" |", to);
}

void stability_exhaustive(FILE *to, const json_t *lines) {
    fputs("\n| fields | heights | fields judged | rays | hits | exact | ties at a rim | ties at a third | other ties | "
          "leaks | phantoms | wrong surfaces | same bits from other kernels |\n"
          "|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
          to);
    const json_t *line;
    size_t index;
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "exhaustive", NULL)) continue;
        fprintf(to, "| %s | %s |", results_text(line, "field"), results_text(line, "heights"));
        const uint64_t fields = number(line, "fields"), all = number(line, "all_fields");
        fputc(' ', to);
        stability_print_count(to, fields);
        if (fields == all) {
            fputs(", all |", to);
        } else {
            fputs(" of ", to);
            stability_print_count(to, all);
            fputs(" |", to);
        }
        static const char *const keys[] = {"rays", "hits", "right", "rims", "thirds"};
        for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++) put(to, line, keys[k]);
        fprintf(to, " %llu |",
                (unsigned long long)(number(line, "tie") - number(line, "rims") - number(line, "thirds")));
        static const char *const faults[] = {"leak", "phantom", "wrong_surface"};
        for (size_t k = 0; k < 3; k++) fprintf(to, " **%llu** |", (unsigned long long)number(line, faults[k]));
        put(to, line, "same_bits");
        fputc('\n', to);
    }
    fputc('\n', to);
}

/* ---- stress ------------------------------------------------------------------------------------------------------ */

void stability_stress(FILE *to, const json_t *lines) {
    fputs("\n| rays | traced | hits | answers of other kernels | with other bits |\n|---|--:|--:|--:|--:|\n", to);
    const json_t *line;
    size_t index;
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "stress", NULL)) continue;
        fprintf(to, "| %s |", results_text(line, "rays"));
        static const char *const keys[] = {"traced", "hits", "answers"};
        for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++) put(to, line, keys[k]);
        fprintf(to, " **%llu** |\n", (unsigned long long)number(line, "other_bits"));
    }
    fputc('\n', to);
}

/* ---- leaf tests -------------------------------------------------------------------------------------------------- */

static const char *const reference_leaf = "moller-trumbore";

/* The line of a kernel with a leaf test; NULL if there is none. */
static const json_t *timed(const json_t *lines, const char *field, const char *rays, const char *kernel,
                           const char *leaf) {
    char name[64];
    snprintf(name, sizeof name, "%s/%s", kernel, leaf);
    return results_find(lines, "result", "field", field, "rays", rays, "contender", name, NULL);
}

/* Kernels that were timed with both; "pyramid8/moller-trumbore" begins with the name. */
static size_t leaf_kernels(const json_t *lines, char kernels[NAMES_MAX][32]) {
    const char *contenders[NAMES_MAX];
    const size_t all = results_distinct(lines, "contender", contenders, NAMES_MAX);
    size_t count = 0;
    for (size_t k = 0; k < all; k++) {
        const char *slash = strchr(contenders[k], '/');
        if (slash == NULL || strcmp(slash + 1, reference_leaf) != 0) continue;
        snprintf(kernels[count++], sizeof kernels[0], "%.*s", (int)(slash - contenders[k]), contenders[k]);
    }
    return count;
}

void stability_leaf(FILE *to, const json_t *lines) {
    static char kernels[NAMES_MAX][32];
    const char *fields[NAMES_MAX], *rays[NAMES_MAX];
    const size_t kernel_count = leaf_kernels(lines, kernels);
    const size_t field_count = results_distinct(lines, "field", fields, NAMES_MAX);
    const size_t ray_count = results_distinct(lines, "rays", rays, NAMES_MAX);
    char machine[512];
    run_record_text(json_array_get(lines, 0), machine, sizeof machine);
    fprintf(to, "\n%s. In brackets what the medians' intervals allow.\n\n| field | rays |", machine);
    for (size_t k = 0; k < kernel_count; k++) fprintf(to, " %s |", kernels[k]);
    fputs("\n|---|---|", to);
    for (size_t k = 0; k < kernel_count; k++) fputs("--:|", to);
    for (size_t f = 0; f < field_count; f++)
        for (size_t r = 0; r < ray_count; r++) {
            fprintf(to, "\n| %s | %s |", fields[f], rays[r]);
            for (size_t k = 0; k < kernel_count; k++) {
                const json_t *mt = timed(lines, fields[f], rays[r], kernels[k], reference_leaf);
                const json_t *wt = timed(lines, fields[f], rays[r], kernels[k], "watertight");
                if (mt && wt && results_number(mt, "seconds_low") > 0 && results_number(wt, "seconds_low") > 0)
                    fprintf(to, " %.2f (%.2f to %.2f) |",
                            results_number(mt, "seconds_median") / results_number(wt, "seconds_median"),
                            results_number(mt, "seconds_low") / results_number(wt, "seconds_high"),
                            results_number(mt, "seconds_high") / results_number(wt, "seconds_low"));
                else
                    fputs(" |", to);
            }
        }
    fputs("\n\n", to);
}
