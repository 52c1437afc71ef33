/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench papers: every table and picture of README and papers, from the files that measure made. */
#ifndef CELLWALK_BENCH_PAPERS_H
#define CELLWALK_BENCH_PAPERS_H

#include "error.h"

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

enum { PAPERS_FILES = 24 };

/* The files of a folder, read when they are first asked for. */
typedef struct papers_data {
    const char *folder;
    const char *names[PAPERS_FILES];
    json_t *lines[PAPERS_FILES];
    size_t count;
} papers_data;

/* The results of FOLDER/name; NULL with the reason in error. The data keep them. name lives as long as they do. */
const json_t *papers_lines(papers_data *data, const char *name, io_error *error);
/* The same for a file that may be missing: *lines is NULL then. */
bool papers_lines_if_there(papers_data *data, const char *name, const json_t **lines, io_error *error);
/* The speeds with the widest instruction set that there are, and its name. */
const json_t *papers_speeds(papers_data *data, const char **isa, io_error *error);

/* The head of a table: a first column and one of numbers for each name. */
void papers_put_head(FILE *to, const char *first, const char *const *names, size_t count);
/* A field of a table: above / below, or nothing unless both are above 0. */
void papers_put_ratio(FILE *to, double above, double below);

/* Writes what stands between a pair of markers. */
typedef bool papers_block(FILE *to, papers_data *data, io_error *error);

/* ---- papers_speed.c: times ---- */
papers_block papers_sources, papers_summary, papers_threads, papers_widths, papers_peers, papers_coursework,
    papers_frontier;
/* ---- papers_work.c: counts ---- */
papers_block papers_walks, papers_limits, papers_pieces, papers_ablation;
/* ---- papers_memory.c: caches and pages ---- */
papers_block papers_caches, papers_pages;

int papers_main(char **arguments, int count);

#endif
