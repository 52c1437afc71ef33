/* SPDX-License-Identifier: Apache-2.0 */
#include "ground_plan.h"

cw_status ground_plan_create(ground_plan *p, const ground_matters *by, const terrain *whole, cw_rectangle window) {
    *p = (ground_plan){.by = *by, .whole = whole, .window = window};
    if (by->sun_count == 1) p->toward = cw_reach_toward(whole, by->suns, window);
    return by->distance > 0 || (by->sun_count == 0 && !by->horizons) ? CW_OK
                                                                     : cw_reach_blocks_create(whole, &p->blocks);
}

void ground_plan_destroy(ground_plan *p) {
    cw_reach_horizons_destroy(&p->reach);
    cw_reach_blocks_destroy(&p->blocks);
}

bool ground_plan_wants(const ground_plan *p, cw_rectangle block) {
    return p->by.horizons || p->by.sun_count != 1 || cw_reach_passes(&p->toward, p->window, block);
}

cw_status ground_plan_around(ground_plan *p, cw_rectangle part, cw_rectangle *piece) {
    const ground_matters *by = &p->by;
    const cw_rectangle all = {0, 0, p->whole->nx, p->whole->ny};
    *piece = by->distance > 0 ? cw_reach_beside(p->whole, part, by->distance) : all;
    if (!ground_plan_has_blocks(p)) return CW_OK;
    if (by->horizons && !p->begun) {
        const cw_status status =
            cw_reach_horizons_create(&p->blocks, p->window, by->curvature, by->above_level, &p->reach);
        if (status != CW_OK) return status;
    }
    p->begun = true;
    *piece = by->horizons ? cw_reach_of_horizons(&p->reach, part) : cw_reach_grow(p->whole, part, 2);
    for (size_t k = 0; k < by->sun_count && (piece->nx < all.nx || piece->ny < all.ny); k++) {
        const reach_sunward sunward = cw_reach_toward(p->whole, &by->suns[k], part);
        *piece = cw_reach_both(*piece, cw_reach_of_shadows(&p->blocks, &sunward, part));
    }
    return CW_OK;
}
