/* SPDX-License-Identifier: Apache-2.0 */
/* Stands in for embree.c where Embree is not installed. */
#include "peers/embree.h"

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
