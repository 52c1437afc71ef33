/* SPDX-License-Identifier: Apache-2.0 */
/* An array as `cellwalk trace` reads rays: by windows of rows. */

#include "memory.h"
#include "npy.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    enum { ROWS = 3, PASSES_MAX = 1000 };
    static const char name[] = "rays.npy";
    memory_file(0, name, data, size);
    io_npy npy;
    io_error error;
    if (io_npy_open(&npy, name, &error)) {
        static const char *const types[] = {"<f4"};
        char shape[128];
        io_npy_shape_text(&npy, shape, sizeof shape);
        io_npy_expect_type(&npy, types, 1, &error);
        const uint64_t rows = npy.header.rank > 0 ? npy.header.shape[0] : 1;
        volatile unsigned char sum = 0;
        for (uint64_t first = 0; first < rows && first < ROWS * PASSES_MAX; first += ROWS) {
            const uint64_t count = rows - first < ROWS ? rows - first : ROWS;
            const unsigned char *bytes = io_npy_rows(&npy, first, count, &error);
            for (uint64_t k = 0; bytes && k < count * npy.row_bytes; k++) sum = (unsigned char)(sum + bytes[k]);
        }
        io_npy_close(&npy);
    }
    memory_done();
    return 0;
}
