/* SPDX-License-Identifier: Apache-2.0 */
/* soak SECONDS [SEED]: fields made, asked by every kernel, and destroyed, for so long, with what the fuzzer of the library does
 * for random inputs, and with each function of the libraries on a large field and a pool between them. All of it under a limit on memory, and
 * with no byte more in use after each round than after the first: in an hour no caller loses what a second does not show.
 * Allocations may fall into another's place, so the process as a whole may grow by a little; by more it fails, too. */

#include "api.h"
#include "calls.h"
#include "rays.h"
#include "reference.h"

#include "cellwalk_expert.h"

#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

enum { ROUNDS_LEAST = 3, INPUTS = 500, SIDE = 250, RAYS = 20000, LIMIT_MB = 512, GROWTH_MAX_KB = 16 << 10 };

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

/* Every kernel on a large field, and each function of the libraries, on a pool. */
static void large(void) {
    static test_field land;
    static cw_ray rays[RAYS];
    static cw_hit hits[RAYS];
    random_state r = {draw()};
    cw_pool *pool;
    field_make(&land, FIELD_RANDOM, SIDE, SIDE, draw());
    for (size_t k = 0; k < RAYS; k++) rays[k] = ray_make((ray_class)(k % RAY_CLASSES), &land, &r);
    must(cw_pool_create(3, &pool), "pool");
    cw_field *field = calls_begin(&land, NULL);
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_run query = {.expert.kernel = cw_kernel_at(k), .pool = pool};
        const cw_kernel_info info = cw_kernel_describe(query.expert.kernel);
        const bool slow = info.default_leaf != CW_LEAF_WATERTIGHT;
        if (!info.available || (slow && draw() % 8 != 0)) continue;
        must(cw_field_build(field, &query), info.name);
        must(cw_closest(field, &query, rays, slow ? RAYS / 1000 : RAYS, hits), info.name);
        api_done.rays += slow ? RAYS / 1000 : RAYS;
    }
    for (size_t k = 0; k < every_calls_count; k++)
        must(every_calls[k].make(&(cw_run){.pool = pool}), every_calls[k].name);
    calls_end();
    cw_pool_destroy(pool);
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
