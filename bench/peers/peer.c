/* SPDX-License-Identifier: Apache-2.0 */
#include "peers/peer.h"

const peer_kind *const peer_kinds[PEER_KINDS] = {&peer_embree, &peer_bullet};

#if !CELLWALK_EMBREE
const peer_kind peer_embree = {.name = "embree", .package = "libembree-dev", .options = EMBREE_OPTIONS};
#endif
#if !CELLWALK_BULLET
const peer_kind peer_bullet = {.name = "bullet", .package = "libbullet-dev", .options = BULLET_OPTIONS};
#endif
