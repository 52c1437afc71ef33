/* SPDX-License-Identifier: Apache-2.0 */
/* Rays moved to field space. */
#ifndef CELLWALK_CORE_TO_FIELD_H
#define CELLWALK_CORE_TO_FIELD_H

#include "cellwalk.h"

/* In the IEEE default environment. */
void cw_field_rays_in(const cw_field *field, const cw_user_ray *in, size_t n, cw_ray *out);

/* The same for one instruction set. m is the field's to_field. */
void cw_to_field_avx2(const double m[3][4], const cw_user_ray *in, size_t n, cw_ray *out);

#endif
