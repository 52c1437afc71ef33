/* SPDX-License-Identifier: Apache-2.0 */
/* Part of every test in C: it tries the reference kernels like all others. */

#include "reference.h"

__attribute__((constructor)) static void add_reference(void) { cw_reference_add(); }
