/* SPDX-License-Identifier: Apache-2.0 */
/* Names of contenders for rays: BASE, and options that change it. */
#include "measure/measure.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char contenders_help[] =
    "Contenders of rays: default, a kernel, embree, bullet, or coarser:FACTOR. Options follow after colons: a leaf "
    "test (default:moller-trumbore), call=N rays a call, threads=N; for embree robust, grid, medium (the build's "
    "quality) and wN, one packet width of 1, 4, 8 and 16";

bool contenders_number(const char *text, const char *key, unsigned most, unsigned *number) {
    const size_t length = strlen(key);
    char *end;
    if (strncmp(text, key, length) != 0 || text[length] < '0' || text[length] > '9') return false;
    const unsigned long value = strtoul(text + length, &end, 10);
    *number = (unsigned)value;
    return *end == '\0' && value >= 1 && value <= most;
}

static const struct {
    const char *word;
    unsigned option;
} peer_words[] = {{"grid", PEER_GRID}, {"medium", PEER_MEDIUM}, {"robust", PEER_ROBUST}};

static bool take_peer_option(contender_spec *s, const peer_kind *kind, const char *word) {
    for (size_t k = 0; k < sizeof peer_words / sizeof *peer_words; k++)
        if (strcmp(word, peer_words[k].word) == 0) {
            s->options |= peer_words[k].option;
            return kind->options & peer_words[k].option;
        }
    if (!contenders_number(word, "w", 16, &s->width)) return false;
    size_t w = 0;
    while (w < PEER_WIDTHS && kind->widths[w] != 0 && kind->widths[w] != s->width) w++;
    return w < PEER_WIDTHS && (kind->widths[w] != 0 || w == 0); /* none are known of one that was not built */
}

static bool take_option(contender_spec *s, const char *word) {
    unsigned factor;
    if (s->kind < PEER_KINDS) return take_peer_option(s, peer_kinds[s->kind], word);
    if (strcmp(s->base, "coarser") == 0 && contenders_number(word, "", FACTOR_MAX, &factor)) {
        s->factor = factor;
        return true;
    }
    for (int leaf = 1; cw_leaf_name((cw_leaf)leaf); leaf++)
        if (strcmp(word, cw_leaf_name((cw_leaf)leaf)) == 0) {
            s->leaf = (cw_leaf)leaf;
            return true;
        }
    return contenders_number(word, "call=", 1 << 20, &s->call) ||
           contenders_number(word, "threads=", CW_THREADS_MAX, &s->threads);
}

bool contenders_parse(contender_spec *s, const char *name, io_error *error) {
    char text[MEASURE_NAME], *rest = text;
    *s = (contender_spec){.threads = 1, .factor = 1};
    snprintf(text, sizeof text, "%s", name);
    snprintf(s->base, sizeof s->base, "%s", strsep(&rest, ":"));
    while (s->kind < PEER_KINDS && strcmp(s->base, peer_kinds[s->kind]->name) != 0) s->kind++;
    const bool own = strcmp(s->base, "default") == 0 || strcmp(s->base, "coarser") == 0 || s->kind < PEER_KINDS;
    if (!own) s->kernel = cw_kernel_find(s->base);
    bool good = own || cw_kernel_exists(s->kernel);
    for (char *word; good && (word = strsep(&rest, ":")) != NULL;) good = take_option(s, word);
    good = good && (strcmp(s->base, "coarser") != 0 || s->factor > 1);
    return good || io_fail(error, "contender %s: %s", name, contenders_help);
}

bool contenders_know(const char *name, io_error *error) { return contenders_parse(&(contender_spec){0}, name, error); }

/* One for each of the peer's widths, or that of the name. */
static bool enter_peer(land *l, const char *name, const contender_spec *s, bool coherent, cw_isa isa,
                       ray_contender *out, size_t *count, char why[192], io_error *error) {
    const peer_kind *kind = peer_kinds[s->kind];
    const void *peer = land_peer(l, s->kind, isa, s->options, why, error);
    if (peer == NULL) return why[0] != '\0';
    for (size_t w = 0; w < PEER_WIDTHS && kind->widths[w]; w++) {
        if (s->width != 0 && s->width != kind->widths[w]) continue;
        ray_contender *c = &out[(*count)++];
        *c = (ray_contender){.factor = 1};
        kind->enter(&c->contender, peer, kind->widths[w], coherent);
        char full[CONTENDER_NAME];
        snprintf(full, sizeof full, s->width || kind->widths[1] == 0 ? "%s" : "%s:%s", name, c->contender.name);
        memcpy(c->contender.name, full, sizeof full);
    }
    return true;
}

bool contenders_of(land *l, const char *name, bool coherent, cw_isa isa, ray_contender out[WIDTHS_MAX], size_t *count,
                   char why[192], io_error *error) {
    contender_spec s;
    *count = 0;
    if (!contenders_parse(&s, name, error)) return false;
    if (s.kind < PEER_KINDS) return enter_peer(l, name, &s, coherent, isa, out, count, why, error);
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
    if (s.call > 0 && s.kernel == NULL) c->contender.query.expert = (cw_expert){.leaf = s.leaf}; /* the call chooses */
    snprintf(c->contender.name, sizeof c->contender.name, "%s", name);
    *count = 1;
    return true;
}

void contenders_leave(ray_contender *c) { cw_pool_destroy(c->pool); }
