/* SPDX-License-Identifier: Apache-2.0 */
/* The lane walk in pairs of vectors, for pyramid8 and pyramid16. Their other walks, in pyramid.c, use single
 * vectors. Paper, invariant and rejected variants are in lane_walk.inc.h and vocabulary/vec_twice.h. */

#include "vocabulary.h"

enum { INLINE_WATERTIGHT = 0 }; /* see watertight.inc.h */

#include "ray.inc.h"

#include "moller_trumbore.inc.h"
#include "watertight.inc.h"

#include "refine.inc.h"

#include "flat_walk.inc.h"

#include "pyramid.h"

#include "lane_queue.inc.h"

#include "lane_answers.inc.h"

#include "close_walk.inc.h"

#include "lane_walk.inc.h"

/* See lane_walk. Local copies of the lanes save the register for their address, of which AVX2 has too few. AVX-512 has
 * enough, so copying would only cost time (papers/walks.md). */
void CW_CODE(lane_pairs_)(const cw_field *f, const lane_queue *queue, lane_set *l, bool more, lane_answers *answers) {
    if ((int)QUEUE_W < 16) {
        lane_set here = *l;
        lane_walk(f, queue, &here, more, answers);
        *l = here;
    } else {
        lane_walk(f, queue, l, more, answers);
    }
}
