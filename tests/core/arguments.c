/* SPDX-License-Identifier: Apache-2.0 */
/* Wrong and empty arguments, one at a time, for each function of the headers that returns a status and for each member of each struct
 * that a caller fills. The rows are compared with the header's text, so none is left out.
 *
 * NULL and NaN fail with CW_ERROR_ARGUMENT and a sentence that begins with the argument's name. Optional pointers may be NULL.
 * Nothing to do, n = 0 or an empty rectangle, succeeds without arrays. */

#include "cellwalk_expert.h"
#include "check.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { SIDE = 5, MOST = 6 };

static char header[1 << 18]; /* both, one after the other */
static char now[256];        /* the call that is made, should it not return */

static void check_refused(cw_status status, const char *name) {
    const size_t length = strlen(name);
    check(status == CW_ERROR_ARGUMENT, "%s: status \"%s\"", now, cw_status_message(status));
    check(strncmp(cw_last_error(), name, length) == 0 && cw_last_error()[length] == ':', "%s: \"%s\"", now,
          cw_last_error());
}

static void check_fine(cw_status status) {
    check(status == CW_OK, "%s: status \"%s\", \"%s\"", now, cw_status_message(status), cw_last_error());
}

/* ---- right arguments ------------------------------------------------------------------------------------------------- */

static void run_tasks(void *context, cw_task_fn *task, void *argument, uint32_t count) {
    (void)context;
    for (uint32_t k = 0; k < count; k++) task(argument, k);
}
static void *allocate(void *context, size_t bytes, size_t alignment) {
    (void)context;
    return aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
}
static void release(void *context, void *memory) {
    (void)context;
    free(memory);
}

static float samples[SIDE * SIDE];
static double room[MOST][32]; /* for two of anything, or a number for each sample */
static cw_field_desc desc = {.samples = samples, .nx = SIDE, .ny = SIDE, .map = {{1}, {0, 1}, {0, 0, 1}}};
static cw_heading_desc heading_desc = {.dir = {1, 0.5}};
static cw_run run;
static cw_update update = {.at = {1, 1, 2, 2}, .samples = samples};
static cw_tasks tasks = {.threads = 2, .run = run_tasks};
static cw_allocator allocator = {.allocate = allocate, .release = release};
static cw_field *field;
static cw_heading *heading;
static void *out;

/* ---- functions ------------------------------------------------------------------------------------------------------- */

typedef union value {
    void *p;
    double d;
    size_t n;
    cw_rectangle at;
} value;

/* Parameters by their names in the header, and what they are: ? an optional pointer, & where a result goes, [ an array, # a count, @ a
 * rectangle, ~ a number, = what no value here is wrong for. */
#define QUERY(NAME, in, out) X(NAME, "*field ?run [" in " #n [" out, v[0].p, v[1].p, v[2].p, v[3].n, v[4].p)
#define FUNCTIONS                                                                                                      \
    X(cw_pool_create, "=threads &pool", (uint32_t)v[0].n, v[1].p)                                                      \
    X(cw_pool_create_on, "*tasks &pool", v[0].p, v[1].p)                                                               \
    X(cw_field_create, "*desc ?run &field", v[0].p, v[1].p, v[2].p)                                                    \
    X(cw_field_build, "*field ?run", v[0].p, v[1].p)                                                                   \
    X(cw_field_update, "*field ?run *update", v[0].p, v[1].p, v[2].p)                                                  \
    X(cw_field_move, "*field *map =wait", v[0].p, v[1].p, (uint32_t)v[2].n)                                            \
    X(cw_run_check, "?field ?run", v[0].p, v[1].p)                                                                     \
    QUERY(cw_closest, "rays", "hits")                                                                                  \
    QUERY(cw_occluded, "rays", "occluded")                                                                             \
    QUERY(cw_closest_user, "rays", "hits")                                                                             \
    QUERY(cw_occluded_user, "rays", "occluded")                                                                        \
    QUERY(cw_rays_to_field, "in", "out")                                                                               \
    QUERY(cw_surface_at, "xy", "hits")                                                                                 \
    QUERY(cw_surface_at_user, "xyz", "hits")                                                                           \
    QUERY(cw_hit_points, "hits", "points")                                                                             \
    QUERY(cw_hit_normals, "hits", "normals")                                                                           \
    QUERY(cw_hit_phong_normals, "hits", "normals")                                                                     \
    X(cw_heading_create, "*field *desc &heading", v[0].p, v[1].p, v[2].p)                                              \
    X(cw_heading_steepest, "*heading ?run ~low ~high @at [slope", v[0].p, v[1].p, (float)v[2].d, (float)v[3].d,        \
      v[4].at, v[5].p)                                                                                                 \
    X(cw_heading_occluded, "*heading ?run ~slope @at [occluded", v[0].p, v[1].p, (float)v[2].d, v[3].at, v[4].p)
#define X(NAME, names, ...)                                                                                            \
    static cw_status call_##NAME(const value *v) { return NAME(__VA_ARGS__); }
FUNCTIONS
#undef X
#define X(NAME, names, ...) {#NAME, names, call_##NAME},
static const struct function {
    const char *name, *parameters;
    cw_status (*call)(const value *v);
} functions[] = {FUNCTIONS};
enum { FUNCTION_COUNT = sizeof functions / sizeof functions[0] };

typedef struct parameter {
    char kind, name[16];
    value good;
} parameter;

/* Takes a row apart; each name stands in the header at its place. */
static size_t parameters_of(const struct function *f, parameter list[MOST]) {
    const struct {
        const char *name;
        value value;
    } named[] = {{"field", {.p = field}},
                 {"heading", {.p = heading}},
                 {"run", {.p = &run}},
                 {"update", {.p = &update}},
                 {"tasks", {.p = &tasks}},
                 {"threads", {.n = 2}},
                 {"n", {.n = 2}},
                 {"at", {.at = {0, 0, SIDE, SIDE}}},
                 {"low", {.d = -1}},
                 {"high", {.d = 1}},
                 {"desc", {.p = strstr(f->name, "heading") ? (void *)&heading_desc : &desc}}};
    size_t count = 0;
    char declared[64];
    snprintf(declared, sizeof declared, "cw_status %s(", f->name);
    const char *text = strstr(header, declared);
    check(text != NULL, "%s is not in the header", f->name);
    for (const char *at = f->parameters; *at; at += strspn(at, " "), count++) {
        parameter *p = &list[count];
        const int length = (int)strcspn(at, " ");
        *p = (parameter){.kind = *at};
        snprintf(p->name, sizeof p->name, "%.*s", length - 1, at + 1);
        at += length;
        if (strchr("*[?", p->kind)) p->good.p = room[count];
        for (size_t k = 0; k < sizeof named / sizeof named[0]; k++)
            if (strcmp(named[k].name, p->name) == 0) p->good = named[k].value;
        if (p->kind == '&') p->good.p = &out;
        const char *end = text + strcspn(text, ",;"), *name = end;
        while (strchr(")[]43", name[-1])) name--; /* double map[3][4] */
        check(*end == (*at ? ',' : ';') && strncmp(name - length + 1, p->name, (size_t)length - 1) == 0,
              "%s: another parameter than %s in the header", f->name, p->name);
        text = end + 1;
    }
    return count;
}

static cw_status call(const struct function *f, const value *v) {
    const cw_status status = f->call(v);
    if (strstr(f->name, "pool"))
        cw_pool_destroy(out);
    else if (strstr(f->name, "heading"))
        cw_heading_destroy(out);
    else
        cw_field_destroy(out);
    out = NULL;
    return status;
}

static void wrong_arguments(const struct function *f) {
    parameter list[MOST];
    value good[MOST], v[MOST];
    const size_t count = parameters_of(f, list);
    for (size_t k = 0; k < count; k++) good[k] = list[k].good;
    snprintf(now, sizeof now, "%s", f->name);
    check_fine(call(f, good));
    for (size_t k = 0; k < count; k++) {
        const char kind = list[k].kind;
        memcpy(v, good, sizeof v);
        snprintf(now, sizeof now, "%s, %s NULL, NaN or empty", f->name, list[k].name);
        if (kind == '~')
            v[k].d = (double)NAN;
        else if (strchr("*?&[", kind))
            v[k].p = NULL;
        if (kind == '?')
            check_fine(call(f, v));
        else if (strchr("*&[~", kind))
            check_refused(call(f, v), list[k].name);
        if (strcmp(list[k].name, "run") == 0) { /* what a later version would mean by more */
            cw_run later = {0};
            v[k].p = &later;
            for (size_t w = 0; w < sizeof later.reserved / sizeof *later.reserved; w++) {
                later.reserved[w] = (uint64_t)1 << 63;
                check_refused(call(f, v), "cw_run");
                later.reserved[w] = 0;
            }
        }
        for (size_t a = 0; a < count; a++)
            if (list[a].kind == '[') v[a].p = NULL;
        for (int side = 1; side < 4 && strchr("#@", kind); side++) {
            v[k] = good[k];
            if (kind == '#') v[k].n = 0;
            if (kind == '@' && side & 1) v[k].at.nx = 0;
            if (kind == '@' && side & 2) v[k].at.ny = 0;
            check_fine(call(f, v));
        }
    }
}

static size_t times(const char *text) {
    size_t n = 0;
    for (const char *at = header; (at = strstr(at, text)) != NULL; at++) n++;
    return n;
}

static void each_function(void **state) {
    (void)state;
    for (size_t k = 0; k < FUNCTION_COUNT; k++) wrong_arguments(&functions[k]);
    check(times("CW_API cw_status ") == FUNCTION_COUNT, "a function of the header has no row");
    now[0] = '\0';
}

/* ---- structs --------------------------------------------------------------------------------------------------------- */

/* Members with a wrong value: NULL, NaN, or all bits set; ? NULL is none; : all bits set, and the error names the struct. */
static const struct filled {
    const char *name;
    void *good;
    size_t size;
    const char *function;
    size_t parameter;
    struct member {
        const char *name;
        char kind;
        size_t offset, size;
    } members[10];
} structs[] = {
#define M(kind, type, member)                                                                                          \
    { #member, kind, offsetof(type, member), sizeof((type *)0)->member }
    {"cw_tasks",
     &tasks,
     sizeof tasks,
     "cw_pool_create_on",
     0,
     {M('*', cw_tasks, run), M('?', cw_tasks, context), M('=', cw_tasks, threads), M(':', cw_tasks, zero),
      M(':', cw_tasks, reserved)}},
    {"cw_run",
     &run,
     sizeof run,
     "cw_closest",
     1,
     {M('?', cw_run, pool), M('?', cw_run, watch), M('?', cw_run, watch_context), M('=', cw_run, expert),
      M(':', cw_run, reserved)}},
    {"cw_allocator",
     &allocator,
     sizeof allocator,
     "cw_field_create",
     0,
     {M('*', cw_allocator, allocate), M('*', cw_allocator, release), M('?', cw_allocator, context),
      M(':', cw_allocator, reserved)}},
    {"cw_field_desc",
     &desc,
     sizeof desc,
     "cw_field_create",
     0,
     {M('*', cw_field_desc, samples), M('=', cw_field_desc, nx), M('=', cw_field_desc, ny),
      M('=', cw_field_desc, stride), M('~', cw_field_desc, map), M('?', cw_field_desc, allocator),
      M('=', cw_field_desc, storage), M(':', cw_field_desc, zero), M(':', cw_field_desc, reserved)}},
    {"cw_update",
     &update,
     sizeof update,
     "cw_field_update",
     2,
     {M('@', cw_update, at), M('*', cw_update, samples), M('=', cw_update, stride), M('=', cw_update, wait),
      M(':', cw_update, zero), M(':', cw_update, reserved)}},
    {"cw_heading_desc",
     &heading_desc,
     sizeof heading_desc,
     "cw_heading_create",
     1,
     {M('~', cw_heading_desc, dir), M('~', cw_heading_desc, reach), M('~', cw_heading_desc, drop),
      M(':', cw_heading_desc, reserved)}},
};
enum { STRUCT_COUNT = sizeof structs / sizeof structs[0] };

static cw_status call_with(const struct filled *s, void *bytes) {
    parameter list[MOST];
    value v[MOST];
    const struct function *f = functions;
    while (strcmp(f->name, s->function) != 0) f++;
    const size_t count = parameters_of(f, list);
    for (size_t k = 0; k < count; k++) v[k] = list[k].good;
    cw_field_desc with_allocator = desc;
    with_allocator.allocator = bytes;
    v[s->parameter].p = s->good == &allocator ? &with_allocator : bytes;
    return call(f, v);
}

static void wrong_member(const struct filled *s, const struct member *m) {
    max_align_t room_for_one[16];
    unsigned char *bytes = memcpy(room_for_one, s->good, s->size), *member = bytes + m->offset;
    snprintf(now, sizeof now, "%s, %s", s->name, m->name);
    memset(member, strchr("*?@", m->kind) ? 0 : 0xff, m->size); /* all bits set: also a NaN */
    const cw_status status = call_with(s, bytes);
    if (strchr("?@", m->kind))
        check_fine(status);
    else
        check_refused(status, m->kind == ':' ? s->name : m->name);
    if (m->kind != '@') return;
    memset(member + m->size, 0, sizeof(void *)); /* empty: then there are no samples either */
    check_fine(call_with(s, bytes));
}

static void each_struct(void **state) {
    (void)state;
    check(times("uint64_t reserved[") == STRUCT_COUNT, "a struct of the header has no row");
    for (size_t k = 0; k < STRUCT_COUNT; k++) {
        const struct filled *s = &structs[k];
        size_t end = 0;
        for (const struct member *m = s->members; m->name; m++) {
            const size_t alignment = m->size < 8 ? 4 : 8;
            check(m->offset == (end + alignment - 1) / alignment * alignment, "%s: a member before %s has no row",
                  s->name, m->name);
            end = m->offset + m->size;
            wrong_member(s, m);
        }
        check(end == s->size, "%s: %zu bytes of %zu have rows", s->name, end, s->size);
    }
    now[0] = '\0';
}

static int set_up(void **state) {
    (void)state;
    static const char *const paths[] = {HEADERS "/cellwalk.h", HEADERS "/cellwalk_expert.h"};
    for (size_t k = 0; k < 2; k++) {
        FILE *f = fopen(paths[k], "rb");
        const size_t size = strlen(header);
        if (f == NULL || fread(header + size, 1, sizeof header - 1 - size, f) == 0) return -1;
        fclose(f);
    }
    check_status(cw_field_create(&desc, NULL, &field), CW_OK);
    check_status(cw_heading_create(field, &heading_desc, &heading), CW_OK);
    return 0;
}

static int tear_down(void **state) {
    (void)state;
    if (now[0] != '\0') print_error("the last call: %s\n", now);
    cw_heading_destroy(heading);
    cw_field_destroy(field);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(each_function), cmocka_unit_test(each_struct)};
    return cmocka_run_group_tests_name("arguments", tests, set_up, tear_down);
}
