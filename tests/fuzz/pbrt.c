/* SPDX-License-Identifier: Apache-2.0 */
/* A scene with all that it includes: bytes 0xff part the input into scene.pbrt, a.pbrt, b.pbrt and a.exr. Read as a
 * scene, and as a file with a height field alone. */

#include "memory.h"
#include "scene.h"

#include <string.h>

static void pass_over(void *context, const char *message) { (void)context, (void)message; }

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const char *const names[] = {"scene.pbrt", "a.pbrt", "b.pbrt", "a.exr"};
    enum { NAMES = sizeof names / sizeof names[0] };
    for (size_t k = 0; k < NAMES; k++) {
        const uint8_t *end = size > 0 && k + 1 < NAMES ? memchr(data, 0xff, size) : NULL;
        const size_t length = end ? (size_t)(end - data) : size;
        memory_file(k, names[k], data, length);
        data += length + (end != NULL);
        size -= length + (end != NULL);
    }
    io_error error;
    scene_free(scene_load(names[0], pass_over, NULL, &error));
    cw_field_destroy(scene_load_heightfield(names[0], NULL, &error));
    memory_done();
    return 0;
}
