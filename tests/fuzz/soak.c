/* SPDX-License-Identifier: Apache-2.0 */
/* soak SECONDS [SEED]: fields made, asked by every kernel, and destroyed, for so long, with what the fuzzer of the library does
 * for random inputs, and with large fields, updates, pools and headings between them. All of it under a limit on memory, and
 * with no byte more in use after each round than after the first: in an hour no caller loses what a second does not show.
 * Allocations may fall into another's place, so the process as a whole may grow by a little; by more it fails, too. */

#include "api.h"
#include "reference.h"

#include "cellwalk_expert.h"

#include <malloc.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

enum {
    ROUNDS_LEAST = 3,
    INPUTS = 500,
    LARGE_SIDE = 600,
    LARGE_RAYS = 20000,
    UPDATES = 4,
    LIMIT_MB = 512,
    GROWTH_MAX_KB = 16 << 10
};

static uint64_t state = 88172645463325252;

static uint64_t draw(void) {
    state ^= state << 13;
    state ^= state >> 7;
    return state ^= state << 17;
}

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static size_t in_use(void) {
    const struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
}

static long resident_kb(void) {
    FILE *file = fopen("/proc/self/statm", "r");
    long total = 0, resident = 0;
    if (file == NULL || fscanf(file, "%ld %ld", &total, &resident) != 2) abort();
    fclose(file);
    return resident * (sysconf(_SC_PAGESIZE) / 1024);
}

static void must(cw_status status, const char *what) {
    if (status == CW_OK) return;
    fprintf(stderr, "soak: %s: %s\n", what, cw_status_message(status));
    exit(EXIT_FAILURE);
}

static cw_ray rays[LARGE_RAYS];
static cw_hit hits[LARGE_RAYS], others[LARGE_RAYS];

/* Some rectangles of the field change; a field made of the new samples gives the same bits. */
static void change(cw_field *field, cw_field_desc *desc, float *samples, cw_pool *pool) {
    for (int k = 0; k < UPDATES; k++) {
        cw_update update = {.at = {.i = draw() % LARGE_SIDE, .j = draw() % LARGE_SIDE}, .stride = LARGE_SIDE};
        update.at.nx = 1 + draw() % (LARGE_SIDE - update.at.i);
        update.at.ny = 1 + draw() % (LARGE_SIDE - update.at.j);
        float *first = samples + update.at.j * LARGE_SIDE + update.at.i;
        for (size_t y = 0; y < update.at.ny; y++)
            for (size_t x = 0; x < update.at.nx; x++) first[y * LARGE_SIDE + x] = (float)(draw() % 64);
        update.samples = first;
        must(cw_field_update(field, &(cw_run){.pool = pool}, &update), "update");
    }
    cw_field *anew;
    must(cw_field_create(desc, NULL, &anew), "field of changed samples");
    must(cw_closest(field, NULL, rays, LARGE_RAYS, hits), "changed field");
    must(cw_closest(anew, NULL, rays, LARGE_RAYS, others), "field of changed samples");
    api_done.rays += LARGE_RAYS;
    cw_field_destroy(anew);
    if (memcmp(hits, others, sizeof hits) == 0) return;
    fprintf(stderr, "soak: an updated field answers otherwise than one made anew\n");
    exit(EXIT_FAILURE);
}

/* A field that threads share, each structure built, each kernel asked; what takes long, only now and then. */
static void large(void) {
    float *samples = malloc(sizeof *samples * LARGE_SIDE * LARGE_SIDE);
    if (samples == NULL) abort();
    for (size_t k = 0; k < (size_t)LARGE_SIDE * LARGE_SIDE; k++) samples[k] = (float)(draw() % 64);
    for (size_t k = 0; k < LARGE_RAYS; k++)
        rays[k] = (cw_ray){.org = {(float)(draw() % LARGE_SIDE), (float)(draw() % LARGE_SIDE), 70},
                           .dir = {(float)(draw() % 9) - 4, (float)(draw() % 9) - 4, -1},
                           .tmax = INFINITY};
    cw_field_desc desc = {0};
    desc.samples = samples;
    desc.nx = desc.ny = LARGE_SIDE;
    cw_field *field;
    cw_pool *pool;
    cw_heading *heading;
    must(cw_pool_create(3, &pool), "pool");
    must(cw_field_create(&desc, NULL, &field), "field");
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        const bool slow = info.default_leaf != CW_LEAF_WATERTIGHT;
        if (!info.available || (slow && draw() % 8 != 0)) continue;
        must(cw_field_build(field, &(cw_run){.expert.kernel = cw_kernel_at(k)}), info.name);
        const size_t n = slow ? LARGE_RAYS / 1000 : LARGE_RAYS;
        const cw_run query = {.expert.kernel = cw_kernel_at(k), .pool = pool};
        must(cw_closest(field, &query, rays, n, hits), info.name);
        api_done.rays += n;
    }
    change(field, &desc, samples, pool);
    must(cw_heading_create(field, &(cw_heading_desc){.dir = {1, 0.5}}, &heading),
         "heading"); /* its slopes go where the samples were */
    const cw_run query = {.pool = pool};
    must(cw_heading_steepest(heading, &query, -INFINITY, INFINITY, (cw_rectangle){0, 0, LARGE_SIDE, LARGE_SIDE},
                             samples),
         "heading");
    cw_heading_destroy(heading);
    cw_field_destroy(field);
    cw_pool_destroy(pool);
    free(samples);
}

static void round_of_inputs(void) {
    for (int k = 0; k < INPUTS; k++) {
        uint8_t data[24];
        for (size_t b = 0; b < sizeof data; b += 8) {
            const uint64_t word = draw();
            memcpy(data + b, &word, 8);
        }
        LLVMFuzzerTestOneInput(data, draw() % (sizeof data + 1));
    }
    large();
}

int main(int count, char **arguments) {
    cw_reference_add();
    const double duration = count == 2 || count == 3 ? atof(arguments[1]) : 0;
    if (count == 3) state = strtoull(arguments[2], NULL, 10);
    if (!(duration > 0) || state == 0) {
        fprintf(stderr, "usage: soak SECONDS [SEED]\n");
        return EXIT_FAILURE;
    }
    static char line[1 << 12]; /* else printing allocates one */
    setvbuf(stdout, line, _IOLBF, sizeof line);
    const struct rlimit limit = {(rlim_t)LIMIT_MB << 20, (rlim_t)LIMIT_MB << 20};
    if (setrlimit(RLIMIT_DATA, &limit) != 0) abort();
    mallopt(M_MXFAST, 0);               /* what is freed is not in use; that threads keep none to themselves, the */
    mallopt(M_MMAP_THRESHOLD, 1 << 20); /* environment says: GLIBC_TUNABLES */
    round_of_inputs();
    const size_t used = in_use();
    const long resident = resident_kb();
    const double begin = seconds();
    double told = begin;
    unsigned long rounds = 1;
    long most = 0;
    for (; rounds < ROUNDS_LEAST || seconds() - begin < duration; rounds++) {
        round_of_inputs();
        const long growth = resident_kb() - resident;
        most = growth > most ? growth : most;
        if (in_use() > used || growth > GROWTH_MAX_KB) {
            fprintf(stderr, "soak: round %lu: %zu bytes in use, %zu after the first; resident %+ld kB\n", rounds,
                    in_use(), used, growth);
            return EXIT_FAILURE;
        }
        if (seconds() - told < 60) continue;
        told = seconds();
        printf("%.0f s: %lu rounds, %llu rays\n", told - begin, rounds, (unsigned long long)api_done.rays);
    }
    printf("%.0f s, %lu rounds of %d small fields and a large one, %llu rays, %llu answers of kernels: %zu bytes in "
           "use as after the "
           "first, at most %+ld kB resident\n",
           seconds() - begin, rounds, INPUTS, (unsigned long long)api_done.rays, (unsigned long long)api_done.answers,
           used, most);
    return EXIT_SUCCESS;
}
