/* SPDX-License-Identifier: Apache-2.0 */
/* A summary on the terminal. papers/scripts makes tables from the saved lines. */
#include "accuracy/accuracy.h"

#include "harness/results.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

accuracy_sums accuracy_sums_of(const json_t *lines, const char *name) {
    static const char *const keys[] = {"leaks_per_million", "wrong_per_million", "phantoms_per_million"};
    accuracy_sums s = {.name = name};
    size_t index, timed = 0, aimed = 0;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "result") || strcmp(results_text(line, "contender"), name) != 0 ||
            json_object_get(line, "left_out_seconds"))
            continue;
        const char *rays = results_text(line, "rays");
        if (strncmp(rays, "within-", 7) == 0) continue; /* for precision alone */
        const bool is_aimed = strcmp(rays, "vertices") == 0 || strcmp(rays, "edges") == 0;
        const double speed = results_number(line, "mrays_per_s");
        for (int k = 0; k < 3; k++) *(is_aimed ? &s.aimed : &s.rates[k]) += results_number(line, keys[k]);
        s.beyond += results_number(line, "broken_per_million");
        if (strcmp(rays, "afar") != 0) s.off = fmax(s.off, results_number(line, "off_cells_worst"));
        s.speed += speed > 0 ? log(speed) : 0;
        timed += speed > 0;
        aimed += is_aimed;
        s.groups++;
    }
    for (int k = 0; k < 3; k++) s.rates[k] /= fmax(1, (double)(s.groups - aimed));
    s.aimed /= fmax(1, (double)aimed);
    s.beyond /= fmax(1, (double)s.groups);
    s.speed = timed ? exp(s.speed / (double)timed) : 0;
    return s;
}

static int by_speed(const void *a, const void *b) {
    const accuracy_sums *x = a, *y = b;
    return x->speed != y->speed ? (x->speed < y->speed ? 1 : -1) : strcmp(x->name, y->name);
}

void accuracy_print(const json_t *lines) {
    const char *names[ACCURACY_ROWS_MAX];
    accuracy_sums all[ACCURACY_ROWS_MAX];
    const size_t count = results_distinct(lines, "contender", names, ACCURACY_ROWS_MAX);
    size_t most = 0;
    for (size_t k = 0; k < count; k++) {
        all[k] = accuracy_sums_of(lines, names[k]);
        most = all[k].groups > most ? all[k].groups : most;
    }
    qsort(all, count, sizeof *all, by_speed);
    printf(
        "\nWrong answers in a million rays; aimed: of rays aimed at vertices and edges; beyond: what the mode's claim "
        "does\nnot explain; *: did not run everywhere.\n%-27s %8s %8s %8s %8s %8s %8s %9s\n",
        "mode / kernel", "Mrays/s", "leaks", "wrong", "phantoms", "beyond", "aimed", "cells off");
    for (const accuracy_sums *s = all; s < all + count; s++)
        if (s->groups > 0)
            printf("%-27s %8.3g %8.3g %8.3g %8.3g %8.3g %8.3g %9.3g%s\n", s->name, s->speed, s->rates[0], s->rates[1],
                   s->rates[2], s->beyond, s->aimed, s->off, s->groups < most ? " *" : "");
}
