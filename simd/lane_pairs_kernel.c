/* SPDX-License-Identifier: Apache-2.0 */
/* The lane walk (lane_walk.h) in vectors of two registers, for the pyramid kernels, whose other walks have one. */
#define REGISTERS 2

#include "lane_walk.h"

/* See lane_walk. Local copies of the lanes save the register for their address, of which AVX2 has too few. AVX-512 has
 * enough, so copying would only cost time. */
void CW_CODE(lane_pairs)(const cw_field *f, const lane_queue *queue, lane_set *l, bool more, lane_answers *answers) {
    if (W < 16) {
        lane_set here = *l;
        lane_walk(f, queue, &here, more, answers);
        *l = here;
    } else {
        lane_walk(f, queue, l, more, answers);
    }
}
