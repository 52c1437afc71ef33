/* SPDX-License-Identifier: Apache-2.0 */
/* Embree (Wald et al. 2014) as a peer: the same field as a triangle mesh or as its grid geometry, the same rays, the same
 * hits. Optional: without the library every function is there, peer_embree_version is NULL and nothing can be made.
 *
 * The time includes: reading rays from an array of cw_ray, filling packets, tracing, writing cw_hit. Denormals are
 * flushed to zero while Embree runs, as its manual recommends. Building is timed separately. */
#ifndef CELLWALK_BENCH_PEERS_EMBREE_H
#define CELLWALK_BENCH_PEERS_EMBREE_H

#include "cellwalk_expert.h"
#include "io_error.h"
#include "peers/contender.h"

typedef enum peer_geometry { PEER_TRIANGLES = 0, PEER_GRID } peer_geometry;
typedef enum peer_quality { PEER_MEDIUM = 0, PEER_HIGH } peer_quality; /* medium is Embree's default */

typedef struct peer_options {
    cw_isa isa; /* the widest that Embree may use */
    peer_geometry geometry;
    peer_quality quality;
    bool robust; /* RTC_SCENE_FLAG_ROBUST */
} peer_options;

typedef struct peer_embree peer_embree;

/* About how much memory Embree takes while it builds, in bytes: measured at 1025 and 4097 samples a side, 245 bytes a cell
 * for triangles at high quality, 38 for a grid, of which it holds less in the end. A field of 8193 would take 17 GB, and a
 * system that runs out of memory kills somebody. */
static inline double peer_embree_needs(const cw_field *field, peer_geometry geometry) {
    const cw_field_info info = cw_field_describe(field);
    return (double)(info.nx - 1) * (double)(info.ny - 1) * (geometry == PEER_GRID ? 50 : 260);
}

/* "3.13.5"; NULL if the program was built without Embree. */
const char *peer_embree_version(void);

/* True if the library that this program runs with was compiled with its assertions, which cost speed. Debian's is. */
bool peer_embree_has_assertions(void);

/* The field must stay until peer_embree_destroy. NULL on failure, with the reason in error. */
peer_embree *peer_embree_create(const cw_field *field, const peer_options *options, io_error *error);
void peer_embree_destroy(peer_embree *peer);

typedef struct peer_info {
    double build_seconds; /* one thread, vertex and index arrays not counted */
    double build_cpu_seconds;
    size_t bytes; /* all that Embree allocated and holds, vertices and indices included */
} peer_info;
peer_info peer_embree_describe(const peer_embree *peer);

/* The widths that Embree has. */
enum { PEER_WIDTH_COUNT = 4 };
extern const unsigned peer_embree_widths[PEER_WIDTH_COUNT];

/* width is one of these. The contender is called PREFIX/wWIDTH, or PREFIX/wWIDTH-split if Embree takes packets of this width to
 * pieces instead of running them as they are. coherent: rays are announced as that. */
void contender_from_peer(contender *c, const peer_embree *peer, unsigned width, bool coherent, const char *prefix);

#endif
