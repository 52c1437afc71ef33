/* SPDX-License-Identifier: Apache-2.0 */
/* What the pictures have in common. */
#ifndef CELLWALK_BENCH_PLOT_PARTS_H
#define CELLWALK_BENCH_PLOT_PARTS_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

enum { PLOT_NAMES_MAX = 96, PLOT_COLOURS = 6 };

/* Cool colours are the library's, warm ones others'. */
extern const char *const plot_cool[PLOT_COLOURS], *const plot_warm[PLOT_COLOURS];

bool plot_is_embree(const char *contender);

/* "pyramid8", or "pyramid8/watertight" where the results have another leaf test of it too; "Embree triangles, 8 wide",
 * with "(split)" where Embree takes such packets to pieces. all: whose names stand beside it. */
void plot_put_label(FILE *to, const char *name, const char *const *all, size_t count);

/* Mrays/s; 0 where the contender was left out. */
double plot_speed_of(const json_t *lines, const char *field, const char *rays, const char *name);

/* The title, and under it in small type what the figures depend on. */
void plot_put_titles(FILE *to, const json_t *lines, const char *what);

/* Smallest and largest value drawn; 0 while there is nothing. */
typedef struct plot_span {
    double low, high;
} plot_span;

/* A value of a row of data, or that there is none. */
void plot_put_point(FILE *to, double value, plot_span *range);

/* Below several panels one legend for all: a plot without axes, of nothing. */
void plot_begin_legend(FILE *to);

/* A row of panels, one a class of rays, begins: three in a row; then each panel with its title and axes' labels. */
void plot_begin_panels(FILE *to, size_t count, const plot_span *range);
void plot_begin_panel(FILE *to, size_t number, size_t count, const char *title, const char *x_label);

#endif
