/* SPDX-License-Identifier: Apache-2.0 */
/* The random numbers that the workload takes, too. */
#ifndef CELLWALK_TESTS_RANDOM_H
#define CELLWALK_TESTS_RANDOM_H

#include "workload/random.h"

#endif
