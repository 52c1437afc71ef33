/* SPDX-License-Identifier: Apache-2.0 */
/* Renames the words of the vocabulary that is included next, for vec_twice.h to make pairs of. */
#ifndef CELLWALK_SIMD_VEC_HALF_H
#define CELLWALK_SIMD_VEC_HALF_H

#include "cellwalk.h"

#include <stddef.h>

#define W                 half_W
#define vfloat            half_vfloat
#define vint              half_vint
#define vmask             half_vmask
#define vdouble           half_vdouble
#define vd_add            half_vd_add
#define vd_div            half_vd_div
#define vd_from_vf        half_vd_from_vf
#define vd_max            half_vd_max
#define vd_min            half_vd_min
#define vd_mul            half_vd_mul
#define vd_select         half_vd_select
#define vd_set            half_vd_set
#define vd_sub            half_vd_sub
#define vf_from_vd        half_vf_from_vd
#define vf_abs            half_vf_abs
#define vf_add            half_vf_add
#define vf_div            half_vf_div
#define vf_eq             half_vf_eq
#define vf_flip           half_vf_flip
#define vf_floor          half_vf_floor
#define vf_from_vi        half_vf_from_vi
#define vf_gather         half_vf_gather
#define vf_gather_pairs   half_vf_gather_pairs
#define vf_gather_quads   half_vf_gather_quads
#define vf_ge             half_vf_ge
#define vf_gt             half_vf_gt
#define vf_le             half_vf_le
#define vf_load           half_vf_load
#define vf_load_block     half_vf_load_block
#define vf_load_each_ray  half_vf_load_each_ray
#define vf_load_rays      half_vf_load_rays
#define vf_lowest_of_each half_vf_lowest_of_each
#define vf_lt             half_vf_lt
#define vf_max            half_vf_max
#define vf_min            half_vf_min
#define vf_mul            half_vf_mul
#define vf_power_of_2     half_vf_power_of_2
#define vf_select         half_vf_select
#define vf_set            half_vf_set
#define vf_store          half_vf_store
#define vpick             half_vpick
#define vpick_make        half_vpick_make
#define vf_store_picked   half_vf_store_picked
#define vf_store_hits     half_vf_store_hits
#define vf_sub            half_vf_sub
#define vi_add            half_vi_add
#define vi_and            half_vi_and
#define vi_eq             half_vi_eq
#define vi_from_vf        half_vi_from_vf
#define vi_load           half_vi_load
#define vi_lookup         half_vi_lookup
#define vi_mul            half_vi_mul
#define vi_or             half_vi_or
#define vi_select         half_vi_select
#define vi_set            half_vi_set
#define vi_shift_left     half_vi_shift_left
#define vi_shift_right    half_vi_shift_right
#define vi_store          half_vi_store
#define vi_sub            half_vi_sub
#define vi_where          half_vi_where
#define vi_xor            half_vi_xor
#define vm_and            half_vm_and
#define vm_andnot         half_vm_andnot
#define vm_any            half_vm_any
#define vm_bits           half_vm_bits
#define vm_first          half_vm_first
#define vm_from_bits      half_vm_from_bits
#define vm_not            half_vm_not
#define vm_or             half_vm_or
#define vm_set            half_vm_set
#define vm_xor            half_vm_xor

#endif
