/* SPDX-License-Identifier: Apache-2.0 */
/* soak SECONDS [SEED]: fields made, asked by every kernel, and destroyed, for so long, with what the fuzzer of the library does
 * for random inputs, and with each function of the libraries on a large field and a pool between them. All of it under a limit on memory, and
 * with no byte more in use after each round than after the first: in an hour no caller loses what a second does not show.
 * Allocations may fall into another's place, so the process as a whole may grow by a little; by more it fails, too. */

#include "api.h"
#include "calls.h"
#include "cellwalk_expert.h"

#include <limits.h>
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <time.h>

enum { ROUNDS_LEAST = 3, INPUTS = 500, SIDE = 250, LIMIT_MB = 512, GROWTH_MAX_KB = 16 << 10 };

static random_state r = {1};

static size_t in_use(void) {
    const struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
}

static long most_resident_kb(void) {
    struct rusage usage;
    return getrusage(RUSAGE_SELF, &usage) == 0 ? usage.ru_maxrss : LONG_MAX;
}

static void must(cw_status status, const char *what) {
    if (status == CW_OK) return;
    fprintf(stderr, "soak: %s: %s\n", what, cw_status_message(status));
    exit(EXIT_FAILURE);
}

/* Every kernel with a walk on a large field, and each function of the libraries, on a pool. */
static void large(void) {
    static test_field land;
    cw_pool *pool;
    field_make(&land, FIELD_RANDOM, SIDE, SIDE, random_bits(&r));
    must(cw_pool_create(3, &pool), "pool");
    cw_field *field = calls_begin(&land, NULL);
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_run query = {.expert.kernel = cw_kernel_at(k), .pool = pool};
        const cw_kernel_info info = cw_kernel_describe(query.expert.kernel);
        if (!info.available || info.default_leaf != CW_LEAF_WATERTIGHT) continue;
        must(cw_field_build(field, &query), info.name);
        must(every_calls[0].make(&query), info.name); /* closest hits */
    }
    for (size_t k = 0; k < every_calls_count; k++)
        must(every_calls[k].make(&(cw_run){.pool = pool}), every_calls[k].name);
    calls_end();
    cw_pool_destroy(pool);
}

static void round_of_inputs(void) {
    for (int k = 0; k < INPUTS; k++) {
        const uint64_t data[3] = {random_bits(&r), random_bits(&r), random_bits(&r)};
        LLVMFuzzerTestOneInput((const uint8_t *)data, random_below(&r, sizeof data + 1));
    }
    large();
}

int main(int count, char **arguments) {
    const unsigned long duration = count == 2 || count == 3 ? strtoul(arguments[1], NULL, 10) : 0;
    if (count == 3) r.state = strtoull(arguments[2], NULL, 10);
    if (duration == 0) {
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
    const long resident = most_resident_kb();
    const time_t end = time(NULL) + (time_t)duration;
    unsigned long rounds = 1;
    for (; rounds < ROUNDS_LEAST || time(NULL) < end; rounds++) {
        round_of_inputs();
        const long growth = most_resident_kb() - resident;
        if (in_use() <= used && growth <= GROWTH_MAX_KB) continue;
        fprintf(stderr, "soak: round %lu: %zu bytes in use, %zu after the first; resident %+ld kB\n", rounds, in_use(),
                used, growth);
        return EXIT_FAILURE;
    }
    printf("%lu s, %lu rounds of %d small fields and a large one, %llu rays, %llu answers of kernels: %zu bytes in use "
           "as after the "
           "first, at most %+ld kB resident\n",
           duration, rounds, INPUTS, (unsigned long long)api_done.rays, (unsigned long long)api_done.answers, used,
           most_resident_kb() - resident);
    return EXIT_SUCCESS;
}
