/* SPDX-License-Identifier: Apache-2.0 */
/* Bullet, a physics engine of games and robots, as a peer: its height field, one ray a call, as its users ask. Its
 * accelerator is not on by default, and loses hits: at 257 x 257 samples 4 % of random rays, where without it all agree. Optional: without it peer_bullet_version is NULL and nothing can be made. */
#ifndef CELLWALK_BENCH_PEERS_BULLET_H
#define CELLWALK_BENCH_PEERS_BULLET_H

#include "peers/contender.h"

#ifdef __cplusplus
extern "C" {
#endif

/* "3.24". */
const char *peer_bullet_version(void);

/* NULL if memory is missing. It has its own copy of the samples. */
typedef struct peer_bullet peer_bullet;
peer_bullet *peer_bullet_create(const cw_field *field, bool accelerated);
void peer_bullet_destroy(peer_bullet *peer);
/* That it holds, samples included. */
size_t peer_bullet_bytes(const peer_bullet *peer);

void contender_from_bullet(contender *c, const peer_bullet *peer);

#ifdef __cplusplus
}
#endif
#endif
