/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk los`: whether two places see each other. */

#include "../json.h"
#include "command.h"
#include "ground.h"
#include "sight.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char name[] = "los";

typedef struct los_command {
    ground_options ground;
    double curvature;
    bool json;
    ground_place places[2];
} los_command;

static bool look(ground *g, const los_command *c, io_error *error) {
    const ground_place *places = c->places;
    const terrain *t = &g->terrain;
    double eye[3], target[3], metres[2], xy[2], ends[2][2];
    if (!ground_find_place(t, &places[0], eye, NULL, error) || !ground_find_place(t, &places[1], target, NULL, error))
        return false;
    sight s;
    const double k = isnan(c->curvature) ? g->file.raster.georef.placed ? 6.0 / 7 : 0 : c->curvature;
    sight_init(&s, t, NULL, eye, k);
    const double height = target[2] - s.eye[2] - sight_fall(&s, target[0], target[1]);
    const double block = sight_first_block(&s, target[0], target[1], target[2]);
    terrain_metres(t, eye[0], eye[1], metres);
    for (int e = 0; e < 2; e++) terrain_to_map(t, e ? target[0] : eye[0], e ? target[1] : eye[1], ends[e]);
    const double length = hypot((ends[1][0] - ends[0][0]) * metres[0], (ends[1][1] - ends[0][1]) * metres[1]);
    const bool blocked = block < INFINITY;
    for (int e = 0; e < 2; e++) xy[e] = ends[0][e] + block * (ends[1][e] - ends[0][e]);
    /* The line bends up against the lowered surface by as much as that is lowered. */
    const double bend = sight_fall(&s, eye[0] + block * (target[0] - eye[0]), eye[1] + block * (target[1] - eye[1]));
    const double z = (eye[2] + block * height + bend) * terrain_metres_of_height(t);
    if (c->json) {
        printf("{\"visible\": %s, \"distance\": ", blocked ? "false" : "true");
        json_number(stdout, length);
        if (blocked)
            printf(", \"blocked_at\": [%.10g, %.10g], \"blocked_height\": %.10g, \"blocked_distance\": %.10g", xy[0],
                   xy[1], z, block * length);
        puts("}");
    } else if (blocked) {
        printf("blocked: %.3f m from the first place, of %.3f m, at a height of %.3f m\nat %.10g,%.10g\n",
               block * length, length, z, xy[0], xy[1]);
    } else {
        printf("visible: %.3f m\n", length);
    }
    return true;
}

static int run(int argc, char **argv) {
    los_command c = {.curvature = NAN};
    enum { OWN = 2, ALL = OWN + RASTER_OPTION_COUNT };
    option_spec options[ALL] = {
        {.name = "curvature",
         .value = "K",
         .help = "the earth's curvature as a factor: 0 for a flat earth,\n1 without air, 0.857 = 6/7 with usual "
                 "refraction\n"
                 "(default: 6/7, or 0 if the file has no map)",
         .kind = OPTION_NUMBER,
         .to = &c.curvature},
        {.name = "json", .help = "print one JSON object", .to = &c.json},
    };
    c.ground.name = name;
    raster_options_rows(&c.ground.raster, options + OWN);
    static const char *const operands[] = {"DEM", "FROM", "TO"};
    const options_usage usage = {
        .name = name,
        .synopsis = "DEM X,Y[,H] X,Y[,H] [OPTIONS]",
        .what = "Computes whether the straight line between two places is free of terrain and\n"
                "prints the answer, or the place where the line from the first is first blocked.\n"
                "A line that touches the terrain is blocked; the ends themselves block nothing.\n"
                "Distances and heights are metres, for any unit of the map.\n"
                "\n" GROUND_PLACE_HELP "\nWithout H a place is on the ground.\n",
        .examples = "  cellwalk los dem.tif 600250,5199800,2 601500,5200100,=1250\n",
        .options = options,
        .option_count = ALL,
        .operands = operands,
        .operand_least = 3,
        .operand_most = 3,
    };
    const char *given[3];
    const int status = options_parse(&usage, argc, argv, given);
    if (status != OPTIONS_GO) return status;
    if (!ground_parse_place(name, given[1], 0, &c.places[0]) || !ground_parse_place(name, given[2], 0, &c.places[1]))
        return EXIT_USAGE;
    if (c.curvature < 0) {
        command_fail(name, "--curvature takes a number from 0 on, not %g", c.curvature);
        return EXIT_USAGE;
    }
    c.ground.query.threads = 1;
    ground g;
    io_error error = {""};
    const int opened = ground_open(&g, &c.ground, given[0], 0, GROUND_SAMPLES);
    return opened == EXIT_SUCCESS ? ground_close(&g, look(&g, &c, &error), &error) : opened;
}

const command command_los = {"los", "compute whether the line between two places is free", run};
