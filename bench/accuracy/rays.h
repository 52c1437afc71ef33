/* SPDX-License-Identifier: Apache-2.0 */
/* The rays on which the trade is measured: the benchmark's classes, and two that are made to find leaks. */
#ifndef CELLWALK_BENCH_ACCURACY_RAYS_H
#define CELLWALK_BENCH_ACCURACY_RAYS_H

#include "workload/fields.h"
#include "workload/ray_classes.h"

/* The aimed classes (workload/aimed.h): through a vertex of the surface, or a point of an edge along x, along y or diagonal,
 * from above every sample to below every sample or the reverse, so that who finds no hit has a leak. They count errors and are
 * not timed. */
enum { TRADEOFF_VERTICES = WORKLOAD_CLASS_COUNT, TRADEOFF_EDGES, TRADEOFF_CLASS_COUNT };

/* Of any class, be it the benchmark's or not; NULL from the count on. */
const char *tradeoff_class_name(int c);
bool tradeoff_class_is_any(int c);
bool tradeoff_class_is_timed(int c);
bool tradeoff_class_is_coherent(int c);

/* As workload_rays_make; the field has these samples, of which aimed rays need 4 a side. */
size_t tradeoff_rays_make(const cw_field *field, const workload_field *samples, int c, uint32_t seed, size_t n,
                          cw_ray *rays);

#endif
