/* SPDX-License-Identifier: Apache-2.0 */
/* What is done with the library for one input: shared by the fuzzer and by the soak. */
#ifndef CELLWALK_TESTS_FUZZ_API_H
#define CELLWALK_TESTS_FUZZ_API_H

#include <stddef.h>
#include <stdint.h>

int LLVMFuzzerInitialize(int *count, char ***arguments);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Rays that were compared, and how many answers of kernels they got beside that of `cell`. */
typedef struct api_counts {
    uint64_t rays, answers;
} api_counts;
extern api_counts api_done;

#endif
