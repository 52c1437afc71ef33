/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/pareto.h"

size_t tradeoff_pareto(tradeoff_point *points, size_t count, double margin, size_t *order) {
    for (size_t k = 0; k < count; k++) points[k].frontier = false;
    double slowest = 0;
    for (size_t found = 0;; found++) {
        size_t best = count;
        for (size_t k = 0; k < count; k++) {
            const tradeoff_point *p = &points[k];
            if (!(p->speed > slowest && p->error >= 0)) continue;
            if (best == count || p->error < points[best].error ||
                (p->error == points[best].error && p->speed > points[best].speed))
                best = k;
        }
        if (best == count) return found;
        points[best].frontier = true;
        order[found] = best;
        slowest = points[best].speed * (1 + margin);
    }
}
