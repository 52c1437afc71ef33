/* SPDX-License-Identifier: Apache-2.0 */
/* Names of contenders for rays: BASE, and options that change it. */
#include "measure/measure.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char contenders_help[] =
    "Contenders of rays: default, a kernel, embree, bullet, or coarser:FACTOR. Options follow after colons: a leaf "
    "test "
    "(default:moller-trumbore), call=N rays a call, threads=N; for embree robust, grid, medium (the build's quality) "
    "and wN, "
    "one packet width of the four; for bullet accelerated, which loses hits";

typedef struct spec {
    char base[64];
    bool embree, bullet, accelerated, robust, grid, medium;
    unsigned width, threads, call;
    size_t factor;
    cw_leaf leaf;
    const cw_kernel *kernel;
} spec;

/* N of a text that is KEY and a number. */
static bool number_after(const char *text, const char *key, unsigned most, unsigned *number) {
    const size_t length = strlen(key);
    char *end;
    if (strncmp(text, key, length) != 0 || text[length] == '\0') return false;
    const unsigned long value = strtoul(text + length, &end, 10);
    *number = (unsigned)value;
    return *end == '\0' && value >= 1 && value <= most;
}

static bool take_option(spec *s, const char *word) {
    unsigned factor;
    if (strcmp(s->base, "coarser") == 0 && number_after(word, "", FACTOR_MAX, &factor)) {
        s->factor = factor;
        return true;
    }
    if (s->bullet) return strcmp(word, "accelerated") == 0 && (s->accelerated = true);
    if (s->embree) {
        if (strcmp(word, "robust") == 0) return s->robust = true;
        if (strcmp(word, "grid") == 0) return s->grid = true;
        if (strcmp(word, "medium") == 0) return s->medium = true;
        return number_after(word, "w", 16, &s->width);
    }
    for (int leaf = 1; cw_leaf_name((cw_leaf)leaf); leaf++)
        if (strcmp(word, cw_leaf_name((cw_leaf)leaf)) == 0) {
            s->leaf = (cw_leaf)leaf;
            return true;
        }
    return number_after(word, "call=", 1 << 20, &s->call) ||
           number_after(word, "threads=", CW_THREADS_MAX, &s->threads);
}

static bool parse(spec *s, const char *name, io_error *error) {
    char text[MEASURE_NAME], *rest = text;
    *s = (spec){.threads = 1, .factor = 1};
    snprintf(text, sizeof text, "%s", name);
    snprintf(s->base, sizeof s->base, "%s", strsep(&rest, ":"));
    s->embree = strcmp(s->base, "embree") == 0;
    s->bullet = strcmp(s->base, "bullet") == 0;
    const bool own = strcmp(s->base, "default") == 0 || strcmp(s->base, "coarser") == 0 || s->bullet;
    if (!s->embree && !own) s->kernel = cw_kernel_find(s->base);
    bool good = own || s->embree || cw_kernel_exists(s->kernel);
    for (char *word; good && (word = strsep(&rest, ":")) != NULL;) good = take_option(s, word);
    good = good && (strcmp(s->base, "coarser") != 0 || s->factor > 1);
    return good || io_fail(error, "contender %s: %s", name, contenders_help);
}

static bool enter_embree(land *l, const char *name, const spec *s, bool coherent, cw_isa isa, ray_contender *out,
                         size_t *count, char why[192], io_error *error) {
    const peer_options options = {.isa = isa,
                                  .geometry = s->grid ? PEER_GRID : PEER_TRIANGLES,
                                  .quality = s->medium ? PEER_MEDIUM : PEER_HIGH,
                                  .robust = s->robust};
    const peer_embree *peer = land_embree(l, &options, why, error);
    if (peer == NULL) return why[0] != '\0';
    for (size_t w = 0; w < PEER_WIDTH_COUNT; w++) {
        const unsigned width = peer_embree_widths[w];
        if (s->width != 0 && s->width != width) continue;
        ray_contender *c = &out[(*count)++];
        *c = (ray_contender){.factor = 1};
        contender_from_peer(&c->contender, peer, width, coherent, "");
        char *split = c->contender.name; /* "/w8", "/w16-split" */
        char full[CONTENDER_NAME];
        snprintf(full, sizeof full, s->width ? "%s" : "%s:%s", name, split + 1);
        memcpy(c->contender.name, full, sizeof full);
    }
    return *count > 0 || io_fail(error, "contender %s: Embree's widths are 1, 4, 8 and 16", name);
}

bool contenders_of(land *l, const char *name, bool coherent, cw_isa isa, ray_contender out[WIDTHS_MAX], size_t *count,
                   char why[192], io_error *error) {
    spec s;
    *count = 0;
    if (!parse(&s, name, error)) return false;
    if (s.embree) return enter_embree(l, name, &s, coherent, isa, out, count, why, error);
    if (s.bullet) {
        const peer_bullet *peer = land_bullet(l, s.accelerated, why);
        out[0] = (ray_contender){.factor = 1};
        contender_from_bullet(&out[0].contender, peer);
        snprintf(out[0].contender.name, sizeof out[0].contender.name, "%s", name);
        *count = peer != NULL;
        return true;
    }
    cw_field *field = land_coarser(l, s.factor, error);
    if (field == NULL) return false;
    ray_contender *c = &out[0];
    *c = (ray_contender){.factor = s.factor};
    const cw_kernel *kernel = s.kernel ? s.kernel : cw_run_kernel(field, NULL);
    const cw_status status = contender_from_kernel(&c->contender, field, kernel, s.leaf);
    if (status == CW_ERROR_KERNEL) {
        const cw_kernel_info info = cw_kernel_describe(kernel);
        snprintf(why, 192, "%s",
                 info.available ? cw_last_error()
                                : "needs an instruction set that this CPU, or the limit, does not have");
        return true;
    }
    if (status != CW_OK) return io_fail(error, "%s on field %s: %s", name, l->name, cw_last_error());
    if (s.threads > 1 && cw_pool_create(s.threads, &c->pool) != CW_OK)
        return io_fail(error, "contender %s: %s", name, cw_last_error());
    c->contender.query.pool = c->pool;
    c->contender.threads = s.threads;
    c->contender.call = s.call;
    snprintf(c->contender.name, sizeof c->contender.name, "%s", name);
    *count = 1;
    return true;
}

void contenders_leave(ray_contender *c) { cw_pool_destroy(c->pool); }
