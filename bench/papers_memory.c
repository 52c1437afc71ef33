/* SPDX-License-Identifier: Apache-2.0 */
/* Tables of the papers that are about memory: cache misses of a ray, and what large pages are worth. */

#include "papers.h"
#include "results.h"
#include "targets.h"

enum { NAMES_MAX = 16 };

/* Misses of a ray beyond the first level, at the given one; -1 if they were not counted. */
static double misses_of(const json_t *lines, const char *field, const char *rays, const char *level, const char *key) {
    const json_t *line = results_find(lines, "caches", "field", field, "rays", rays, "level", level, NULL);
    return line ? results_number(line, key) / results_number(line, "ray_count") : -1;
}

bool papers_caches(FILE *to, papers_data *d, io_error *error) {
    static const struct {
        const char *level, *key;
    } columns[] = {{"L2", "reads"}, {"L2", "first_misses"}, {"L2", "misses"}, {"L3", "misses"}};
    const json_t *lines = papers_lines(d, "caches.json", error);
    if (lines == NULL) return false;
    const char *fields[NAMES_MAX], *rays[NAMES_MAX];
    const size_t field_count = results_distinct_of(lines, "caches", "field", fields, NAMES_MAX);
    const size_t ray_count = results_distinct_of(lines, "caches", "rays", rays, NAMES_MAX);
    const json_t *first = results_find(lines, "caches", NULL);
    if (first == NULL) return io_fail(error, "%s/caches.json: has no counts", d->folder);
    fprintf(to,
            "A ray on average, `%s`, %.0f rays a class: reads, and the reads and writes that miss caches of 32 KiB, "
            "512 KiB "
            "and\n32 MiB, by callgrind's model, which has no prefetches.\n\n"
            "| field | rays | reads | not in 32 KiB | not in 512 KiB | not in 32 MiB |\n|---|---|--:|--:|--:|--:|\n",
            results_text(first, "kernel"), results_number(first, "ray_count"));
    for (size_t f = 0; f < field_count; f++)
        for (size_t r = 0; r < ray_count; r++) {
            fprintf(to, "| %s | %s |", fields[f], rays[r]);
            for (size_t c = 0; c < sizeof columns / sizeof columns[0]; c++) {
                const double misses = misses_of(lines, fields[f], rays[r], columns[c].level, columns[c].key);
                fprintf(to, misses >= 0 ? " %.2f |" : " |", misses);
            }
            fputc('\n', to);
        }
    return true;
}

bool papers_pages(FILE *to, papers_data *d, io_error *error) {
    const json_t *huge = papers_lines(d, "pages-huge.json", error);
    const json_t *small = huge ? papers_lines(d, "pages-small.json", error) : NULL;
    if (small == NULL) return false;
    const char *fields[NAMES_MAX], *rays[NAMES_MAX];
    const size_t field_count = results_distinct(huge, "field", fields, NAMES_MAX);
    const size_t ray_count = results_distinct(huge, "rays", rays, NAMES_MAX);
    fputs("Speed on huge pages over that on ordinary ones.\n\n", to);
    papers_put_head(to, "field", rays, ray_count);
    for (size_t f = 0; f < field_count; f++) {
        fprintf(to, "| %s |", fields[f]);
        for (size_t r = 0; r < ray_count; r++) {
            const json_t *above = targets_own(huge, fields[f], rays[r]);
            const json_t *below = targets_own(small, fields[f], rays[r]);
            papers_put_ratio(to, above ? results_number(above, "mrays_per_s") : 0,
                             below ? results_number(below, "mrays_per_s") : 0);
        }
        fputc('\n', to);
    }
    return true;
}
