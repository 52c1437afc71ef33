/* SPDX-License-Identifier: Apache-2.0 */
/* What the library itself says, for tests of the program: its kernels; or its answers to rays.
 *
 *   library kernels
 *   library answers NX NY KERNEL KIND < map, samples, rays > hits, occluded, points, normals
 *
 * KERNEL may be default; KIND is field, of cw_ray, or user, of cw_user_ray. Map: 12 doubles. All of it is binary. */

#include "cellwalk_expert.h"
#include "reference.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void stop_unless(bool good, const char *what) {
    if (good) return;
    fprintf(stderr, "library: %s\n", what);
    exit(EXIT_FAILURE);
}

/* Everything that is left of standard input. */
static char *read_all(size_t *size) {
    size_t room = 1 << 20;
    char *bytes = malloc(room);
    for (*size = 0; bytes; bytes = realloc(bytes, room *= 2)) {
        *size += fread(bytes + *size, 1, room - *size, stdin);
        if (*size < room) break;
    }
    stop_unless(bytes != NULL, "out of memory");
    return bytes;
}

static void *room(size_t n, size_t size) {
    void *bytes = calloc(n > 0 ? n : 1, size);
    stop_unless(bytes != NULL, "out of memory");
    return bytes;
}

static void kernels(void) {
    const cw_kernel *chosen = cw_run_kernel(NULL, NULL);
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        printf("%s %u %s %s %d %d\n", info.name, info.width, cw_isa_name(info.isa), cw_leaf_name(info.default_leaf),
               info.available, cw_kernel_at(k) == chosen);
    }
    printf("%s\n", cw_isa_name(cw_isa_best()));
}

static void answers(size_t nx, size_t ny, const char *kernel, bool user) {
    size_t size;
    char *bytes = read_all(&size);
    cw_field_desc desc = {0};
    desc.nx = nx;
    desc.ny = ny;
    memcpy(desc.map, bytes, sizeof desc.map);
    float *z = room(nx * ny, sizeof *z);
    memcpy(z, bytes + sizeof desc.map, nx * ny * sizeof *z);
    desc.samples = z;
    const char *given = bytes + sizeof desc.map + nx * ny * sizeof *z;
    const size_t n = (size_t)(bytes + size - given) / (user ? sizeof(cw_user_ray) : sizeof(cw_ray));
    const cw_run run = {.expert.kernel = strcmp(kernel, "default") == 0 ? NULL : cw_kernel_find(kernel)};
    cw_field *field;
    stop_unless(cw_field_create(&desc, &run, &field) == CW_OK, "the field");
    cw_ray *rays = room(n, sizeof *rays);
    if (user) {
        cw_user_ray *of = room(n, sizeof *of);
        memcpy(of, given, n * sizeof *of);
        cw_rays_to_field(field, NULL, of, n, rays);
        free(of);
    } else {
        memcpy(rays, given, n * sizeof *rays);
    }
    cw_hit *hits = room(n, sizeof *hits);
    uint8_t *occluded = room(n, 1);
    double(*points)[3] = room(n, sizeof *points), (*normals)[3] = room(n, sizeof *normals);
    stop_unless(cw_closest(field, &run, rays, n, hits) == CW_OK && cw_occluded(field, &run, rays, n, occluded) == CW_OK,
                "the query");
    for (size_t k = 0; k < n; k++)
        if (hits[k].i >= 0) {
            cw_hit_points(field, NULL, &hits[k], 1, points[k]);
            cw_hit_normals(field, NULL, &hits[k], 1, normals[k]);
        }
    fwrite(hits, sizeof *hits, n, stdout);
    fwrite(occluded, 1, n, stdout);
    fwrite(points, sizeof *points, n, stdout);
    fwrite(normals, sizeof *normals, n, stdout);
    cw_field_destroy(field);
    free(bytes), free(z), free(rays), free(hits), free(occluded), free(points), free(normals);
}

int main(int argc, char **argv) {
    cw_reference_add(); /* as the program has them */
    if (argc == 2 && strcmp(argv[1], "kernels") == 0)
        kernels();
    else if (argc == 6 && strcmp(argv[1], "answers") == 0)
        answers(strtoul(argv[2], NULL, 10), strtoul(argv[3], NULL, 10), argv[4], strcmp(argv[5], "user") == 0);
    else
        stop_unless(false, "no such command");
    return fflush(stdout) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
