/* SPDX-License-Identifier: Apache-2.0 */
/* Other programs that answer the same rays on the same field: a row each, behind one file. All are optional: one that
 * was not installed has no version, and nothing of it can be made.
 *
 * Embree (Wald et al. 2014) has the field as a triangle mesh or as its grid geometry. Its time includes reading cw_ray,
 * filling packets, tracing and writing cw_hit. It runs with denormals flushed to zero, as its manual recommends.
 *
 * Bullet, a physics engine of games and robots, has a height field and takes one ray a call, as its users ask. */
#ifndef CELLWALK_BENCH_PEERS_PEER_H
#define CELLWALK_BENCH_PEERS_PEER_H

#include "cellwalk_expert.h"

/* ---- one way to answer ray queries, a kernel's or another program's; contenders are timed against each other ----- */

enum { CONTENDER_NAME = 64 };

typedef struct contender contender;
struct contender {
    char name[CONTENDER_NAME]; /* "packet8/watertight", "embree:w8" */
    unsigned width, threads;
    void (*closest)(const contender *self, const cw_ray *rays, size_t n, cw_hit *hits);
    void (*any)(const contender *self, const cw_ray *rays, size_t n, uint8_t *occluded);
    /* A kernel of the library on a field; or another program's structures. */
    const cw_field *field;
    cw_run query;
    size_t call; /* rays a call of the kernel; 0: all in one */
    const void *peer;
    bool coherent; /* rays are announced as that */
};

/* CW_OK only if the kernel has this leaf test and may run here; its structures are built. */
cw_status contender_from_kernel(contender *c, cw_field *field, const cw_kernel *kernel, cw_leaf leaf);

/* Where answers go: hits for the closest ones, occluded for any. */
typedef struct contender_answers {
    cw_hit *hits;
    uint8_t *occluded;
} contender_answers;

/* All rays once: any: find any hits instead of closest ones. */
typedef struct contender_pass {
    const contender *of;
    const cw_ray *rays;
    size_t n;
    bool any;
    contender_answers out;
} contender_pass;

/* pass is a contender_pass, untyped so that this can be a job. */
void contender_run(void *pass);

/* ---- peers ---- */

struct io_error;

/* Of a structure: Embree's grid, its default quality instead of its highest, its flag ROBUST. */
enum { PEER_GRID = 1, PEER_MEDIUM = 2, PEER_ROBUST = 4, PEER_OPTIONS = 8 };
enum { EMBREE_OPTIONS = PEER_GRID | PEER_MEDIUM | PEER_ROBUST };
enum { PEER_KINDS = 2, PEER_WIDTHS = 4 };

typedef struct peer_kind {
    const char *name, *package, *version; /* "embree", "libembree-dev", "3.13.5"; version is NULL if it is not built */
    unsigned options;                     /* those above that it has */
    unsigned widths[PEER_WIDTHS];         /* rays a call; 0: no more */
    /* Bytes a cell that it takes at most while it builds, without and with PEER_GRID. */
    double needs[2];
    /* The field must stay until destroy. isa: the widest set that it may use. NULL: reason in error, or no memory. */
    void *(*create)(const cw_field *field, cw_isa isa, unsigned options, struct io_error *error);
    void (*destroy)(void *peer);
    /* All it holds, with samples. seconds: CPU time to build, but not to make vertex and index arrays; may be left. */
    size_t (*bytes)(const void *peer, double *seconds);
    /* Called "wWIDTH", or "wWIDTH-split" if packets of this width are split. coherent: rays are announced as that. */
    void (*enter)(contender *c, const void *peer, unsigned width, bool coherent);
} peer_kind;

#ifdef __cplusplus
extern "C" {
#endif
extern const peer_kind peer_embree, peer_bullet;
extern const peer_kind *const peer_kinds[PEER_KINDS];
#ifdef __cplusplus
}
#endif

#endif
