/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk los`: whether two places see each other, or pairs of a table. */

#include "../json.h"
#include "command.h"
#include "inputs.h"
#include "line.h"
#include "output.h"
#include "printable.h"
#include "product.h"
#include "progress.h"
#include "table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char name[] = "los";

typedef struct los_command {
    product product;
    double curvature, megahertz; /* 0: no radio link */
    bool json;
    const char *pairs, *output, *profile;
    ground_place places[2];
} los_command;

/* c is NULL where nothing was asked about radio. */
static void print_json(const line *l, const clearance *c) {
    json_print(stdout, "{'visible': %b, 'distance': %g", !l->blocked, l->length);
    if (l->blocked)
        printf(", \"blocked_at\": [%.10g, %.10g], \"blocked_height\": %.10g, \"blocked_distance\": %.10g", l->block[0],
               l->block[1], l->block_height, l->block_distance);
    if (c)
        json_print(stdout, ", 'clearance': %g, 'clearance_distance': %g, 'fresnel_radius': %g", c->share, c->distance,
                   c->radius);
    puts("}");
}

static void print(const line *l, const clearance *c) {
    if (l->blocked)
        printf("blocked: %.3f m from the first place, of %.3f m, at a height of %.3f m\nat %.10g,%.10g\n",
               l->block_distance, l->length, line_no_minus(l->block_height), l->block[0], l->block[1]);
    else
        printf("visible: %.3f m\n", l->length);
    if (c && isnan(c->share))
        puts("no ground lies between the places");
    else if (c)
        printf("least clearance: %.0f %% of the first Fresnel zone's radius of %.3f m, %.3f m from the first place\n",
               100 * c->share, c->radius, c->distance);
}

static bool look(los_command *c, io_output *profiles, io_error *error) {
    const bool radio = c->megahertz > 0;
    line l;
    profile p = {0};
    clearance free;
    const bool along = profiles != NULL || radio;
    bool good = line_find_on(&l, &c->product.ground, c->places, c->curvature, along ? &p : NULL, error);
    good = good && (profiles == NULL || (line_head_profiles(c->megahertz, profiles, error) &&
                                         line_write_profile(&l, 1, c->megahertz, &p, profiles, error)));
    if (good && radio) line_clearance(&l, c->megahertz, &p, &free);
    cw_profile_free(&p);
    if (!good) return false;
    progress_end();
    (c->json ? print_json : print)(&l, radio ? &free : NULL);
    return true;
}

/* ---- pairs from a table ------------------------------------------------------------------------------------------- */

enum { X1, Y1, X2, Y2, HEIGHT1, HEIGHT2, NAME, NAMES };
static const char *const columns[NAMES] = {"x1", "y1", "x2", "y2", "height1", "height2", "name"};

typedef struct job {
    los_command *command;
    io_table table;
    size_t columns[NAMES];
    profile profile;
    io_output *results, *profiles;
    size_t visible; /* pairs so far */
} job;

static bool find_columns(job *j, io_error *error) {
    const io_table *t = &j->table;
    const ground_watch *w = &j->command->product.ground.watch;
    if (t->rows == 0) return io_fail(error, "%s: holds no pairs", t->path);
    return io_table_columns(t, columns, NAMES, HEIGHT1, j->columns, w->warn, w->context, error);
}

enum { TEXT = 300 };

static bool is_named(const job *j) { return j->columns[NAME] < j->table.columns; }

/* "" without such a column. */
static const char *name_of(const job *j, size_t row) {
    if (!is_named(j)) return "";
    char *text = j->table.cells[row * j->table.columns + j->columns[NAME]];
    make_printable(text);
    return text;
}

/* One end of a row's line. */
static bool take_place(const job *j, size_t row, int end, ground_place *p, char text[TEXT], io_error *error) {
    const io_table *t = &j->table;
    const size_t *c = j->columns, x = c[end ? X2 : X1], y = c[end ? Y2 : Y1], height = c[end ? HEIGHT2 : HEIGHT1];
    *p = (ground_place){.text = text};
    if (!io_table_number(t, row, x, &p->x, error) || !io_table_number(t, row, y, &p->y, error)) return false;
    if (height < t->columns && !io_table_height(t, row, height, &p->z, &p->absolute, error)) return false;
    const char *called = name_of(j, row);
    snprintf(text, TEXT, "%.150s:%zu%s%.47s%s: %.10g,%.10g,%s%.10g", t->path, t->lines[row], called[0] ? " (" : "",
             called, called[0] ? ")" : "", p->x, p->y, p->absolute ? "=" : "", p->z);
    return true;
}

static bool write_row(job *j, size_t row, const line *l, io_error *error) {
    if (!io_output_print(j->results, error, "%zu,%.12g,%.12g,%.12g,%.12g,%d,%.3f,", row + 1, l->ends[0][0],
                         l->ends[0][1], l->ends[1][0], l->ends[1][1], !l->blocked, l->length))
        return false;
    if (!(l->blocked ? io_output_print(j->results, error, "%.3f,%.12g,%.12g,%.3f", l->block_distance, l->block[0],
                                       l->block[1], line_no_minus(l->block_height))
                     : io_output_print(j->results, error, ",,,")))
        return false;
    clearance c;
    if (j->command->megahertz > 0) {
        line_clearance(l, j->command->megahertz, &j->profile, &c);
        if (!(isnan(c.share) ? io_output_print(j->results, error, ",,,")
                             : io_output_print(j->results, error, ",%.4f,%.3f,%.3f", c.share, c.distance, c.radius)))
            return false;
    }
    return (!is_named(j) || io_table_write_cell(j->results, name_of(j, row), error)) &&
           io_output_write(j->results, "\n", 1, error);
}

static bool look_at_pair(job *j, size_t row, io_error *error) {
    char texts[2][TEXT];
    ground_place places[2];
    line l;
    for (int end = 0; end < 2; end++)
        if (!take_place(j, row, end, &places[end], texts[end], error)) return false;
    profile *p = j->profiles || j->command->megahertz > 0 ? &j->profile : NULL;
    if (!line_find_on(&l, &j->command->product.ground, places, j->command->curvature, p, error) ||
        !write_row(j, row, &l, error))
        return false;
    j->visible += !l.blocked;
    return j->profiles == NULL ||
           line_write_profile(&l, row + 1, j->command->megahertz, &j->profile, j->profiles, error);
}

static bool look_at_all(job *j, io_error *error) {
    static const char head[] = "pair,x1,y1,x2,y2,visible,distance,blocked_distance,blocked_x,blocked_y,blocked_height";
    static const char *const more = ",clearance,clearance_distance,fresnel_radius";
    const size_t rows = j->table.rows;
    if (!find_columns(j, error) || !io_output_write(j->results, head, sizeof head - 1, error)) return false;
    if (!io_output_print(j->results, error, "%s%s\n", j->command->megahertz > 0 ? more : "",
                         is_named(j) ? ",name" : ""))
        return false;
    if (j->profiles && !line_head_profiles(j->command->megahertz, j->profiles, error)) return false;
    for (size_t row = 0; row < rows; row++) {
        if (!look_at_pair(j, row, error)) return false;
        product_tell(&j->command->product, (double)(row + 1) / (double)rows);
    }
    return true;
}

static bool look_at_pairs(los_command *c, io_output *results, io_output *profiles, size_t *visible, size_t *pairs,
                          io_error *error) {
    job j = {.command = c, .results = results, .profiles = profiles};
    ground *g = &c->product.ground;
    if (ground_is_small(g) && !ground_read(g, ground_all(g), false, error)) return false;
    if (!io_table_read(c->pairs, &j.table, error)) return false;
    const bool good = look_at_all(&j, error);
    *visible = j.visible;
    *pairs = j.table.rows;
    io_table_free(&j.table);
    cw_profile_free(&j.profile);
    return good;
}

/* ---- all together ------------------------------------------------------------------------------------------------- */

static bool answer(los_command *c, io_error *error) {
    size_t visible = 0, pairs = 0;
    io_output results = {0}, profiles = {0}, *to = c->profile ? &profiles : NULL;
    c->curvature = ground_curvature(&c->product.ground, c->curvature);
    if (c->pairs && !io_inputs_note_path(c->pairs)) return io_fail(error, "out of memory");
    bool good = !c->profile || io_output_open(&profiles, c->profile, error);
    if (c->pairs) {
        good = good && io_output_open(&results, c->output ? c->output : "-", error) &&
               look_at_pairs(c, &results, to, &visible, &pairs, error);
        progress_end();
        good = good && (!to || io_output_settle(to, error)) && io_output_commit(&results, error);
    } else {
        good = good && look(c, to, error);
    }
    good = good && (!to || io_output_commit(to, error));
    io_output_discard(&results);
    io_output_discard(&profiles);
    if (good && c->pairs)
        command_wrote(name, c->product.quiet, c->output, c->product.start, "%zu of %zu pairs see each other", visible,
                      pairs);
    if (good && c->pairs)
        command_wrote(name, c->product.quiet, c->profile, c->product.start, "profiles of %zu pairs", pairs);
    else if (good)
        command_wrote(name, c->product.quiet, c->profile, c->product.start, "profile between two places");
    return good;
}

static bool check(los_command *c, const char *const given[3]) {
    const bool places = given[1] != NULL;
    if (c->pairs && places) return command_refuse(name, "--pairs FILE and places do not go together");
    if (!c->pairs && given[2] == NULL)
        return command_refuse(name, "%s is missing, or --pairs FILE", places ? "TO" : "FROM");
    if (c->output && !c->pairs) return command_refuse(name, "-o goes with --pairs FILE");
    if (c->json && c->pairs) return command_refuse(name, "--json goes with two places; the answers of --pairs are CSV");
    if (c->profile && strcmp(c->profile, c->output ? c->output : "-") == 0)
        return command_refuse(name, "--profile needs a file that nothing else is written to");
    return !places || (product_parse_place(name, given[1], 0, &c->places[0]) &&
                       product_parse_place(name, given[2], 0, &c->places[1]));
}

static int run(int argc, char **argv) {
    static los_command c; /* large */
    const option_spec options[] = {
        option_text("pairs", "FILE.csv", &c.pairs,
                    "pairs of places in place of FROM and TO: a table whose first line names the columns x1, y1, x2, "
                    "y2 and, if there, height1, height2 and name"),
        option_output("FILE.csv", &c.output, "with --pairs: the table of answers (default: standard output)"),
        option_text("profile", "FILE.csv", &c.profile,
                    "write the terrain along each line as a table: distance, heights of ground and line, and whether "
                    "the ground is seen from the first place, wherever the line crosses an edge of a triangle"),
        product_round_earth_row(&c.curvature),
        option_range(
            "frequency", "MHZ", &c.megahertz, 0.1, 1e6, "megahertz from 0.1 to 1000000",
            "of a radio link: also print the least clearance of the line over the ground, as a share of the first "
            "Fresnel zone's radius there; 60 % is the usual demand, and --curvature 0.75 the 4/3 earth of radio"),
        option_flag("json", &c.json, "print one JSON object"),
        option_flag("quiet", &c.product.quiet, "leave out the lines at the end of --pairs and --profile"),
    };
    c.product.name = name;
    static const char *const operands[] = {"DEM", "FROM", "TO"};
    const options_usage usage = {
        .name = name,
        .synopsis = "DEM (X,Y[,H] X,Y[,H] | --pairs FILE.csv) [OPTIONS]",
        .what = "Computes whether the straight line between two places is free of terrain and prints the answer, or "
                "the place where the line from the first is first blocked. A line that touches the terrain is blocked; "
                "the ends themselves block nothing. Distances and heights are metres, for any unit of the map. A table "
                "of pairs is answered by a table: visible is 1 or 0, and blocked_... are empty where nothing "
                "blocks.\n\n" PRODUCT_PLACE_HELP "\nWithout H a place is on the ground.\n",
        .examples = "  cellwalk los dem.tif 600250,5199800,2 601500,5200100,=1250\n"
                    "  cellwalk los dem.tif 600250,5199800,2 601500,5200100 --profile profile.csv\n"
                    "  cellwalk los dem.tif --pairs links.csv -o answers.csv\n"
                    "  cellwalk los dem.tif 600250,5199800,20 601500,5200100,15 --frequency 5800 \\\n"
                    "      --curvature 0.75\n",
        .options = options,
        .option_count = sizeof options / sizeof *options,
        .operands = operands,
        .operand_least = 1,
        .operand_most = 3,
    };
    const char *given[3];
    const int status = field_options_parse(&c.product.fields, &usage, FIELD_NO_QUERIES, argc, argv, given);
    if (status != OPTIONS_GO) return status;
    if (!check(&c, given)) return EXIT_USAGE;
    c.product.fields.threads = 1;
    io_error error = {""};
    const int opened = product_open(&c.product, given[0], 0);
    return opened == EXIT_SUCCESS ? product_close(&c.product, answer(&c, &error), &error) : opened;
}

const command command_los = {"los", "compute whether lines between places are free", run};
