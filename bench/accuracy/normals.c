/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/accuracy.h"
#include "clock.h"
#include "harness/memory.h"
#include "harness/results.h"
#include "workload/terrain.h"

#include <math.h>
#include <stdlib.h>

static inline void unit(double n[3]) {
    const double scale = 1 / sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int k = 0; k < 3; k++) n[k] *= scale;
}

/* Adds weight times the sum of the normals of the six triangles around a vertex, each as long as twice its area
 * (src/core/hit.c), or times the normal by central differences. */
static inline void add_vertex_normal(const true_surface *s, size_t at, double weight, bool central, double n[3]) {
    const float *z = s->z + at, *north = z + s->nx, *south = z - s->nx;
    const double w = (double)z[-1], e = (double)z[1], nn = (double)north[0], ss = (double)south[0];
    if (central) {
        n[0] += weight * (w - e);
        n[1] += weight * (ss - nn);
        n[2] += weight * 2;
        return;
    }
    const double ne = (double)north[1], sw = (double)south[-1];
    n[0] += weight * (2 * (w - e) + (nn - ne) + (sw - ss));
    n[1] += weight * (2 * (ss - nn) + (e - ne) + (sw - w));
    n[2] += weight * 6;
}

void accuracy_normal_at(const true_surface *s, const cw_hit *hit, accuracy_normal kind, double n[3]) {
    const size_t at = (size_t)hit->j * s->nx + (size_t)hit->i;
    const size_t corner[4] = {at, at + 1, at + s->nx, at + s->nx + 1};
    const bool a = hit->triangle == CW_TRIANGLE_A;
    const bool central = kind >= ACCURACY_CENTRAL_BARYCENTRIC;
    const double u = (double)hit->u, v = (double)hit->v, x = a ? u + v : u, y = a ? v : u + v;
    n[0] = n[1] = n[2] = 0;
    if (kind == ACCURACY_FACET) {
        const double h = (double)s->z[corner[0]], h11 = (double)s->z[corner[3]];
        const double h10 = (double)s->z[corner[1]], h01 = (double)s->z[corner[2]];
        n[0] = a ? h - h10 : h01 - h11;
        n[1] = a ? h10 - h11 : h - h01;
        n[2] = 1;
    } else if (kind == ACCURACY_BARYCENTRIC || kind == ACCURACY_CENTRAL_BARYCENTRIC) {
        add_vertex_normal(s, corner[0], 1 - u - v, central, n);
        add_vertex_normal(s, corner[a ? 1 : 2], a ? u : v, central, n);
        add_vertex_normal(s, corner[3], a ? v : u, central, n);
    } else {
        const double weight[4] = {(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y};
        for (int k = 0; k < 4; k++) add_vertex_normal(s, corner[k], weight[k], central, n);
    }
    unit(n);
}

/* ---- the experiment ---- */

enum { SIDE = 257, HITS = 65536, REPEATS = 9 };

/* A sea that a formula gives: height · sin(x · turn) · cos(0.7 y · turn), turn = 2 pi / length; in cells. */
typedef struct wave {
    double length, height;
} wave;

static double wave_at(const wave *w, double x, double y, double normal[3]) {
    const double k = 2 * 3.14159265358979323846 / w->length;
    normal[0] = -w->height * k * cos(x * k) * cos(0.7 * y * k);
    normal[1] = w->height * 0.7 * k * sin(x * k) * sin(0.7 * y * k);
    normal[2] = 1;
    unit(normal);
    return w->height * sin(x * k) * cos(0.7 * y * k);
}

static cw_hit some_hit(uint32_t seed, uint32_t k) {
    const double x = 1 + (SIDE - 3) * ((double)terrain_hash(seed, k, 1) * 0x1p-32);
    const double y = 1 + (SIDE - 3) * ((double)terrain_hash(seed, k, 2) * 0x1p-32);
    const double i = floor(x), j = floor(y), fx = x - i, fy = y - j;
    const bool a = fy <= fx;
    return (cw_hit){.u = (float)(a ? fx - fy : fx),
                    .v = (float)(a ? fy : fy - fx),
                    .i = (int32_t)i,
                    .j = (int32_t)j,
                    .triangle = a ? CW_TRIANGLE_A : CW_TRIANGLE_B};
}

/* Nanoseconds a normal: the median of some passes. */
static double cost(const true_surface *s, const cw_hit *hits, accuracy_normal kind) {
    double seconds[REPEATS];
    volatile double sink = 0;
    for (int r = 0; r < REPEATS; r++) {
        const double start = clock_cpu_seconds();
        double sum = 0;
        for (size_t k = 0; k < HITS; k++) {
            double n[3];
            accuracy_normal_at(s, &hits[k], kind, n);
            sum += n[0] + n[1];
        }
        seconds[r] = clock_cpu_seconds() - start;
        sink = sink + sum;
    }
    return statistics_of(seconds, REPEATS).median / HITS * 1e9;
}

static json_t *measure_wave(const wave *w, float *z, const cw_hit *hits, double *errors) {
    static const char *const names[ACCURACY_NORMAL_COUNT] = {"facet", "barycentric", "bilinear", "central",
                                                             "central_bilinear"};
    double right[3], n[3], area[3];
    for (size_t k = 0; k < (size_t)SIDE * SIDE; k++)
        z[k] = (float)wave_at(w, (double)(k % SIDE), (double)(k / SIDE), n);
    const true_surface s = true_surface_of(z, SIDE, SIDE);
    json_t *line = json_object();
    results_set_text(line, "kind", "normal");
    results_set_numbers(line, "wave_length wave_height", (double[]){w->length, w->height});
    for (int kind = 0; kind < ACCURACY_NORMAL_COUNT; kind++) {
        double sum = 0, apart = 0;
        for (size_t k = 0; k < HITS; k++) {
            const bool a = hits[k].triangle == CW_TRIANGLE_A;
            const double u = (double)hits[k].u, v = (double)hits[k].v;
            wave_at(w, hits[k].i + (a ? u + v : u), hits[k].j + (a ? v : u + v), right);
            accuracy_normal_at(&s, &hits[k], (accuracy_normal)kind, n);
            errors[k] = accuracy_degrees(n, right);
            sum += errors[k] * errors[k];
            if (kind < ACCURACY_CENTRAL_BARYCENTRIC) continue;
            accuracy_normal_at(&s, &hits[k], (accuracy_normal)(kind - 2), area);
            apart += accuracy_degrees(n, area) * accuracy_degrees(n, area);
        }
        json_t *of = json_object();
        const double median = statistics_of(errors, HITS).median; /* sorts them */
        results_set_numbers(
            of, "degrees_rms degrees_median degrees_worst nanoseconds",
            (double[]){sqrt(sum / HITS), median, errors[HITS - 1], cost(&s, hits, (accuracy_normal)kind)});
        if (kind >= ACCURACY_CENTRAL_BARYCENTRIC) results_set_number(of, "degrees_to_area_rms", sqrt(apart / HITS));
        json_object_set_new(line, names[kind], of);
    }
    return line;
}

void accuracy_normals_run(uint32_t seed, json_t *lines) {
    static const wave waves[] = {{6, 0.6}, {12, 1.2}, {24, 2.4}, {48, 4.8}, {24, 0.3}};
    float *z = memory((size_t)SIDE * SIDE, sizeof *z);
    cw_hit *hits = memory(HITS, sizeof *hits);
    double *errors = memory(HITS, sizeof *errors);
    for (uint32_t k = 0; k < HITS; k++) hits[k] = some_hit(seed, k);
    for (size_t w = 0; w < sizeof waves / sizeof waves[0]; w++)
        results_append(lines, measure_wave(&waves[w], z, hits, errors));
    free(z);
    free(hits);
    free(errors);
}
