/* SPDX-License-Identifier: Apache-2.0 */
/* Stands in for embree.c and bullet.cpp where these are not installed. */
#include "peers/bullet.h"
#include "peers/embree.h"

#if !CELLWALK_EMBREE

const unsigned peer_embree_widths[PEER_WIDTH_COUNT] = {1, 4, 8, 16};

const char *peer_embree_version(void) { return NULL; }
bool peer_embree_has_assertions(void) { return false; }

peer_embree *peer_embree_create(const cw_field *field, const peer_options *options, io_error *error) {
    (void)field, (void)options;
    io_fail(error, "this program was built without Embree: install libembree-dev and configure again");
    return NULL;
}
void peer_embree_destroy(peer_embree *peer) { (void)peer; }

peer_info peer_embree_describe(const peer_embree *peer) {
    (void)peer;
    return (peer_info){0};
}

void contender_from_peer(contender *c, const peer_embree *peer, unsigned width, bool coherent, const char *prefix) {
    (void)peer, (void)coherent, (void)prefix;
    *c = (contender){.width = width, .embree = true};
}
#endif

#if !CELLWALK_BULLET
const char *peer_bullet_version(void) { return NULL; }
peer_bullet *peer_bullet_create(const cw_field *field, bool accelerated) {
    return (void)field, (void)accelerated, NULL;
}
void peer_bullet_destroy(peer_bullet *peer) { (void)peer; }
size_t peer_bullet_bytes(const peer_bullet *peer) { return (void)peer, 0; }
void contender_from_bullet(contender *c, const peer_bullet *peer) {
    (void)peer;
    *c = (contender){.width = 1};
}
#endif
