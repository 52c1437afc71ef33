/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench plot: results of micro as SVG pictures. gnuplot draws them; it is looked for when the program runs. */
#ifndef CELLWALK_BENCH_PLOT_H
#define CELLWALK_BENCH_PLOT_H

#include "error.h"

#include <jansson.h>
#include <stdio.h>

/* Each writes gnuplot's commands for one picture, all but terminal and output. False if the results do not have what it
 * takes: then nothing is written that matters. */

/* Speed of every contender on every class of rays over one field. */
bool plot_speed(FILE *to, const json_t *lines, const char *field);
/* Speed over the side of square fields, a panel a class of rays: every kernel, and Embree's fastest width. */
bool plot_scaling(FILE *to, const json_t *lines);
/* Bytes a cell and building time over the side of square fields, both sides. */
bool plot_building(FILE *to, const json_t *lines);
/* Results of tradeoff: speed against wrong answers and against the worst error of t, with both frontiers. */
bool plot_tradeoff(FILE *to, const json_t *lines);

/* Speed of several threads over one. */
bool plot_threads(FILE *to, const json_t *lines);
/* Speed over the width of packets on the largest field, a panel a class of rays. */
bool plot_widths(FILE *to, const json_t *lines);
/* The time of each path over that of a triangle mesh, beside what the coursework reports. lines: of table. */
bool plot_coursework(FILE *to, const json_t *lines);

/* All that the results allow, as DIR/speed-FIELD.svg, scaling.svg and so on; the directory is made. The same results
 * give the same files to the byte. */
bool plot_all(const json_t *lines, const char *directory, io_error *error);

/* The pictures of a folder of files that measure made. */
bool plot_folder(const char *folder, const char *directory, io_error *error);

/* The picture of tradeoff under this name. */
bool plot_tradeoff_file(const json_t *lines, const char *path, io_error *error);

int plot_main(char **arguments, int count);

#endif
