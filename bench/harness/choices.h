/* SPDX-License-Identifier: Apache-2.0 */
/* Options that several commands have, and what they may say. */
#ifndef CELLWALK_BENCH_HARNESS_CHOICES_H
#define CELLWALK_BENCH_HARNESS_CHOICES_H

#include "cellwalk.h"
#include "harness/options.h"

/* What --kernel, --field and --isa may say, the same for every command that has them. Fields: an empty list is filled with
 * the first by_default of all. Without a name the instruction set is the best that may be used here. */
bool choices_kernels(option_list *kernels, io_error *error);
bool choices_fields(option_list *fields, size_t by_default, io_error *error);
bool choices_isa(const char *name, cw_isa *isa, io_error *error);

#endif
