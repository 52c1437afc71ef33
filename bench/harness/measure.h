/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench measure: every measurement that the papers quote, one file of results each, in one go. */
#ifndef CELLWALK_BENCH_HARNESS_MEASURE_H
#define CELLWALK_BENCH_HARNESS_MEASURE_H

int measure_main(char **arguments, int count);

#endif
