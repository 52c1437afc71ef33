/* SPDX-License-Identifier: Apache-2.0 */
/* cw_rays_to_field for one instruction set. m is the field's to_field. */
#ifndef CELLWALK_CORE_TO_FIELD_H
#define CELLWALK_CORE_TO_FIELD_H

#include "cellwalk.h"

void cw_to_field_avx2(const double m[3][4], const cw_user_ray *in, size_t n, cw_ray *out);

#endif
