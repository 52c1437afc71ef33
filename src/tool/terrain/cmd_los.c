/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk los`: whether two places see each other, or pairs of a table. */

#include "../json.h"
#include "command.h"
#include "inputs.h"
#include "line.h"
#include "output.h"
#include "printable.h"
#include "product.h"
#include "table.h"

#include <math.h>
#include <stdlib.h>
#include <unistd.h>

static const char name[] = "los";

typedef struct los_command {
    product product;
    double curvature, megahertz; /* 0: no radio link */
    bool json;
    const char *pairs, *output, *profile;
    io_place places[2];
    /* The work. */
    io_output results, profiles;
    line line;         /* the one that is looked at */
    profile along;     /* it, if radio or a profile asks for it */
    clearance free;    /* for radio */
    size_t visible;    /* pairs so far */
    io_table table;    /* of pairs */
    size_t columns[7]; /* of names */
} los_command;

/* Without the sign of a number that is rounded to 0. */
static double no_minus(double x, double half) { return x > -half && x < half ? 0 : x; }

static bool write_profile(los_command *c, size_t number, io_error *error) {
    io_output *to = &c->profiles;
    for (size_t k = 0; k < c->along.count; k++) {
        const line_row r = line_row_of(&c->line, c->megahertz, &c->along.points[k]);
        const double over = no_minus(r.line, 0.0005);
        bool good = io_output_print(to, error, "%zu,%.3f,%.12g,%.12g,", number, r.distance, r.x, r.y);
        good = good && (isnan(r.ground)
                            ? io_output_print(to, error, ",%.3f,", over)
                            : io_output_print(to, error, "%.3f,%.3f,%.0f", no_minus(r.ground, 0.0005), over, r.seen));
        good = good && (isnan(r.radius) || io_output_print(to, error, ",%.3f", r.radius));
        if (!good || !io_output_write(to, "\n", 1, error)) return false;
    }
    return true;
}

static bool find_line(los_command *c, size_t number, const io_place places[2], io_error *error) {
    const bool radio = c->megahertz > 0;
    if (!line_find_on(&c->line, &c->product.ground, places, c->curvature, radio || c->profile ? &c->along : NULL,
                      error))
        return false;
    if (radio) line_clearance(&c->line, c->megahertz, &c->along, &c->free);
    c->visible += c->line.answer.state == CW_SIGHT_SEEN;
    return !c->profile || write_profile(c, number, error);
}

/* ---- two places -------------------------------------------------------------------------------------------------- */

static void print_json(const los_command *c) {
    const cw_sight_answer *a = &c->line.answer;
    json_print(stdout, "{'visible': %b, 'distance': %g", a->state == CW_SIGHT_SEEN, a->metres);
    if (a->state != CW_SIGHT_SEEN)
        printf(", \"blocked_at\": [%.10g, %.10g], \"blocked_height\": %.10g, \"blocked_distance\": %.10g",
               a->blocked[0], a->blocked[1], a->blocked[2], a->distance);
    if (c->megahertz > 0)
        json_print(stdout, ", 'clearance': %g, 'clearance_distance': %g, 'fresnel_radius': %g", c->free.share,
                   c->free.distance, c->free.radius);
    puts("}");
}

static void print(const los_command *c) {
    const cw_sight_answer *a = &c->line.answer;
    if (a->state == CW_SIGHT_SEEN)
        printf("visible: %.3f m\n", a->metres);
    else
        printf("blocked: %.3f m from the first place, of %.3f m, at a height of %.3f m\nat %.10g,%.10g\n", a->distance,
               a->metres, no_minus(a->blocked[2], 0.0005), a->blocked[0], a->blocked[1]);
    if (c->megahertz > 0 && isnan(c->free.share))
        puts("no ground lies between the places");
    else if (c->megahertz > 0)
        printf("least clearance: %.0f %% of the first Fresnel zone's radius of %.3f m, %.3f m from the first place\n",
               no_minus(100 * c->free.share, 0.5), c->free.radius, c->free.distance);
}

/* ---- pairs of a table -------------------------------------------------------------------------------------------- */

enum { X1, Y1, X2, Y2, HEIGHT1, HEIGHT2, NAME, NAMES };
static const char *const columns[NAMES] = {"x1", "y1", "x2", "y2", "height1", "height2", "name"};

static bool is_named(const los_command *c) { return c->columns[NAME] < c->table.columns; }

/* "" without such a column. */
static const char *name_of(const los_command *c, size_t row) {
    if (!is_named(c)) return "";
    char *text = c->table.cells[row * c->table.columns + c->columns[NAME]];
    make_printable(text);
    return text;
}

static bool write_row(los_command *c, size_t row, io_error *error) {
    const line *l = &c->line;
    const cw_sight_answer *a = &l->answer;
    const bool seen = a->state == CW_SIGHT_SEEN;
    io_output *to = &c->results;
    if (!io_output_print(to, error, "%zu,%.12g,%.12g,%.12g,%.12g,%d,%.3f,", row + 1, l->ends[0][0], l->ends[0][1],
                         l->ends[1][0], l->ends[1][1], seen, a->metres))
        return false;
    if (!(seen ? io_output_print(to, error, ",,,")
               : io_output_print(to, error, "%.3f,%.12g,%.12g,%.3f", a->distance, a->blocked[0], a->blocked[1],
                                 no_minus(a->blocked[2], 0.0005))))
        return false;
    if (c->megahertz > 0 &&
        !(isnan(c->free.share) ? io_output_print(to, error, ",,,")
                               : io_output_print(to, error, ",%.4f,%.3f,%.3f", no_minus(c->free.share, 0.00005),
                                                 c->free.distance, c->free.radius)))
        return false;
    return (!is_named(c) || io_table_write_cell(to, name_of(c, row), error)) && io_output_write(to, "\n", 1, error);
}

static bool look_at_pairs(los_command *c, io_error *error) {
    const io_table *t = &c->table;
    ground *g = &c->product.ground;
    if (ground_is_small(g) && !ground_read(g, ground_all(g), false, error)) return false;
    if (!io_table_read(c->pairs, &c->table, error)) return false;
    if (t->rows == 0) return io_fail(error, "%s: holds no pairs", t->path);
    if (!io_table_columns(t, columns, NAMES, HEIGHT1, c->columns, &g->watch.warn, error) ||
        !io_output_print(&c->results, error,
                         "pair,x1,y1,x2,y2,visible,distance,blocked_distance,blocked_x,blocked_y,blocked_height%s%s\n",
                         c->megahertz > 0 ? ",clearance,clearance_distance,fresnel_radius" : "",
                         is_named(c) ? ",name" : ""))
        return false;
    for (size_t row = 0; row < t->rows; row++) {
        const size_t *of = c->columns;
        io_place places[2] = {{.weight = 1}, {.weight = 1}};
        if (!io_place_take(t, row, of[X1], of[Y1], of[HEIGHT1], of[NAME], &places[0], error) ||
            !io_place_take(t, row, of[X2], of[Y2], of[HEIGHT2], of[NAME], &places[1], error) ||
            !find_line(c, row + 1, places, error) || !write_row(c, row, error))
            return false;
        product_tell(&c->product, (double)(row + 1) / (double)t->rows);
    }
    return true;
}

/* ---- all together ------------------------------------------------------------------------------------------------ */

static bool look(los_command *c, io_error *error) {
    c->curvature = ground_curvature(&c->product.ground, c->curvature);
    if (c->pairs && !io_inputs_note_path(c->pairs)) return io_fail(error, "out of memory");
    if (!product_check_table(c->output, "-o", error) || !product_check_table(c->profile, "--profile", error))
        return false;
    if (c->profile && (!io_output_open(&c->profiles, c->profile, error) ||
                       !io_output_print(&c->profiles, error, "pair,distance,x,y,ground,line,seen%s\n",
                                        c->megahertz > 0 ? ",fresnel_radius" : "")))
        return false;
    if (c->pairs && (!io_output_open(&c->results, c->output ? c->output : "-", error) || !look_at_pairs(c, error)))
        return false;
    if (!c->pairs && !find_line(c, 1, c->places, error)) return false;
    progress_end();
    if (!c->pairs) (c->json ? print_json : print)(c);
    return (!c->profile || io_output_settle(&c->profiles, error)) &&
           (!c->pairs || io_output_commit(&c->results, error)) &&
           (!c->profile || io_output_commit(&c->profiles, error));
}

static bool answer(los_command *c, io_error *error) {
    const product *p = &c->product;
    const bool good = look(c, error);
    io_output_discard(&c->results);
    io_output_discard(&c->profiles);
    cw_profile_free(&c->along);
    if (good && c->pairs)
        command_wrote(name, p->quiet, c->output, p->start, "%zu of %zu pairs see each other", c->visible,
                      c->table.rows);
    if (good && c->pairs)
        command_wrote(name, p->quiet, c->profile, p->start, "profiles of %zu pairs", c->table.rows);
    else if (good)
        command_wrote(name, p->quiet, c->profile, p->start, "profile between two places");
    io_table_free(&c->table);
    return good;
}

static bool check(los_command *c, const char *const given[3]) {
    const bool places = given[1] != NULL;
    if (c->pairs && places) return command_refuse(name, "--pairs FILE and places do not go together");
    if (!c->pairs && given[2] == NULL)
        return command_refuse(name, "%s is missing, or --pairs FILE", places ? "TO" : "FROM");
    if (c->output && !c->pairs) return command_refuse(name, "-o goes with --pairs FILE");
    if (c->json && c->pairs) return command_refuse(name, "--json goes with two places; the answers of --pairs are CSV");
    if (c->profile && io_output_descriptor(c->profile) == STDOUT_FILENO &&
        io_output_descriptor(c->output ? c->output : "-") == STDOUT_FILENO)
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
                "its ends block nothing, nor do holes. Distances and heights are metres, for any unit of the map. "
                "Where the map's scale changes from row to row, as in degrees, a line has that of its middle: its ends "
                "get the same answer. A table of pairs is answered by a table: visible is 1 or 0, and blocked_... are "
                "empty where nothing blocks.\n\n" PRODUCT_PLACE_HELP "\nWithout H a place is on the ground.\n",
        .examples = "  cellwalk los dem.tif 600250,5199800,2 601500,5200100,=1250\n"
                    "  cellwalk los dem.tif 600250,5199800,2 601500,5200100 --profile profile.csv\n"
                    "  cellwalk los dem.tif --pairs links.csv -o answers.csv\n"
                    "  cellwalk los dem.tif 600250,5199800,20 601500,5200100,15 --frequency 5800 \\\n"
                    "      --curvature 0.75\n",
        OPTIONS_OF(options),
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
