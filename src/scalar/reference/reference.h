/* SPDX-License-Identifier: Apache-2.0 */
/* Two ways to find hits for comparison alone, which are in no installed library: brute, every triangle, and grid3d, a
 * uniform 3D grid. A program that has called cw_reference_add finds them wherever a kernel is named. */
#ifndef CELLWALK_REFERENCE_H
#define CELLWALK_REFERENCE_H

/* Before the first other call to the library; further calls do nothing. */
void cw_reference_add(void);

#endif
