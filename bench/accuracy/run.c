/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/tradeoff.h"

#include "accuracy/normals.h"
#include "accuracy/scenes.h"
#include "accuracy/summary.h"
#include "clock.h"
#include "harness/results.h"

#include <stdio.h>
#include <stdlib.h>

static size_t classes_of(const tradeoff_options *o, bool timed) {
    size_t count = 0;
    for (int c = 0; c < TRADEOFF_CLASS_COUNT; c++)
        count += option_wanted(&o->rays, (size_t)c) && (!timed || tradeoff_class_is_timed(c));
    return count;
}

static bool run_fields(const tradeoff_options *o, json_t *lines, io_error *error) {
    double end = clock_seconds() + o->seconds;
    size_t groups = o->fields.count * classes_of(o, true);
    tradeoff_field *on = calloc(1, sizeof *on);
    bool good = on || io_fail(error, "out of memory");
    for (size_t f = 0; good && f < o->fields.count; f++) {
        const double start = clock_seconds();
        fprintf(stderr, "field %s: making it and building Embree\n", o->fields.item[f]);
        good = tradeoff_field_open(on, o->fields.item[f], o, error);
        end += clock_seconds() - start; /* building does not count */
        for (int c = 0; good && c < TRADEOFF_CLASS_COUNT; c++) {
            if (!option_wanted(&o->rays, (size_t)c)) continue;
            fprintf(stderr, "field %s: %s\n", o->fields.item[f], tradeoff_class_name(c));
            const bool timed = tradeoff_class_is_timed(c);
            const double left = end - clock_seconds();
            good = tradeoff_group_run(on, c, o, timed && left > 0 ? left / (double)groups : 0, lines, error);
            groups -= timed;
        }
        tradeoff_field_close(on);
    }
    free(on);
    return good;
}

static json_t *modes_line(void) {
    json_t *line = json_object(), *modes = json_object();
    results_set_text(line, "kind", "modes");
    for (size_t m = 0; m < tradeoff_mode_count(); m++)
        results_set_text(modes, tradeoff_mode_at(m)->name, tradeoff_mode_at(m)->what);
    json_object_set_new(line, "modes", modes);
    return line;
}

bool tradeoff_run(const tradeoff_options *o, json_t *lines, io_error *error) {
    bool good = json_array_append_new(lines, modes_line()) == 0 || io_fail(error, "out of memory");
    good = good && run_fields(o, lines, error);
    for (size_t s = 0; good && s < o->scenes.count; s++) {
        fprintf(stderr, "scene %s\n", o->scenes.item[s]);
        good = tradeoff_scene_run(o->scenes.item[s], o, lines, error);
    }
    return good && tradeoff_normals_run(o->run.seed, lines, error) && tradeoff_summarise(lines, error);
}
