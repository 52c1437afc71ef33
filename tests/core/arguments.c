/* SPDX-License-Identifier: Apache-2.0 */
/* Wrong and empty arguments, one at a time, for each function of the headers that returns a status and for each member of each struct
 * that a caller fills. The header's text says which these are, so none is left out: a function or a struct without a row fails.
 *
 * NULL and NaN fail with CW_ERROR_ARGUMENT and a sentence that begins with the argument's name. Optional pointers may be NULL.
 * Nothing to do, n = 0 or an empty rectangle, succeeds without arrays. */

#include "cellwalk_expert.h"
#include "check.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { SIDE = 5, MOST = 12 };

static char *header;
static char now[1024]; /* the call that is made, should it not return */

/* ---- the header's text --------------------------------------------------------------------------------------------- */

/* Both headers, one after the other. */
static int read_header(void) {
    static const char *const paths[] = {HEADERS "/cellwalk.h", HEADERS "/cellwalk_expert.h"};
    enum { ROOM = 1 << 18 };
    size_t size = 0;
    bool good = (header = calloc(ROOM, 1)) != NULL;
    for (size_t k = 0; k < 2 && good; k++) {
        FILE *f = fopen(paths[k], "rb");
        good = f != NULL;
        if (good) size += fread(header + size, 1, ROOM - 1 - size, f);
        if (good) fclose(f);
    }
    for (char *c = header; good && (c = strstr(c, "/*")) != NULL;) { /* comments become blanks */
        const char *end = strstr(c, "*/");
        memset(c, ' ', end ? (size_t)(end + 2 - c) : strlen(c));
    }
    return good ? 0 : -1;
}

typedef enum value_kind { POINTER, OUT, REAL, COUNT, RECTANGLE, OTHER } value_kind;

typedef struct parameter {
    char name[32];
    value_kind kind;
    size_t offset, size; /* as a member */
} parameter;

/* "const double dir[2]": its name stands before the bracket, that of a pointer to a function behind "(*". member: an array is
 * itself there, and not a pointer. */
static parameter read_parameter(const char *begin, const char *end, bool member) {
    static const struct {
        const char *type;
        value_kind kind;
        size_t size;
    } types[] = {{"**", OUT, 8},
                 {"*", POINTER, 8},
                 {"_fn ", POINTER, 8},
                 {"double ", REAL, 8},
                 {"float ", REAL, 4},
                 {"size_t ", COUNT, 8},
                 {"cw_rectangle ", RECTANGLE, 32},
                 {"uint64_t ", OTHER, 8},
                 {"cw_expert ", OTHER, sizeof(cw_expert)},
                 {"", OTHER, 4}};
    parameter p = {0};
    char text[200];
    while (begin < end && isspace((unsigned char)*begin)) begin++;
    snprintf(text, sizeof text, "%.*s", (int)(end - begin), begin);
    const char *function = strstr(text, "(*"), *bracket = strchr(text, '[');
    const char *last = function ? strchr(function, ')') : bracket ? bracket : text + strlen(text), *name = last;
    while (name > text && (isalnum((unsigned char)name[-1]) || name[-1] == '_')) name--;
    snprintf(p.name, sizeof p.name, "%.*s", (int)(last - name), name);
    size_t k = 0;
    while (strstr(text, types[k].type) == NULL) k++;
    p.kind = bracket && !member ? POINTER : types[k].kind;
    p.size = types[k].size;
    for (; member && bracket; bracket = strchr(bracket + 1, '[')) p.size *= (size_t)atoi(bracket + 1);
    return p;
}

/* Parameters, or the members of a struct, whose places follow from their sizes: none is aligned to more than a pointer. */
static size_t read_list(const char *at, const char *end, bool members, parameter list[MOST]) {
    size_t count = 0, offset = 0;
    for (const char *next; at < end; at = next + 1) {
        int depth = 0;
        for (next = at; next < end && (depth > 0 || *next != (members ? ';' : ',')); next++)
            depth += (*next == '(') - (*next == ')');
        const char *word = at + strspn(at, " \n");
        if (word >= next) continue;
        const size_t length = (size_t)(next - word);
        const char *comma = members && !memchr(word, '(', length) ? memchr(word, ',', length) : NULL;
        check(count + 2 <= MOST, "more than %d parameters", (int)MOST);
        list[count++] = read_parameter(word, comma ? comma : next, members);
        if (comma != NULL) { /* size_t nx, ny */
            list[count] = list[count - 1];
            snprintf(list[count++].name, sizeof list->name, "%.*s", (int)(next - comma - 2), comma + 2);
        }
    }
    for (size_t k = 0; k < count; k++) {
        const size_t alignment = list[k].size < 8 ? 4 : 8;
        list[k].offset = offset = (offset + alignment - 1) / alignment * alignment;
        offset += list[k].size;
    }
    return count;
}

static bool has_word(const char *words, const char *word) {
    const size_t length = strlen(word);
    for (const char *at = words; (at = strstr(at, word)) != NULL; at += length)
        if ((at == words || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0')) return true;
    return false;
}

static void check_refused(cw_status status, const char *name) {
    const size_t length = strlen(name);
    check(status == CW_ERROR_ARGUMENT, "%s: status \"%s\"", now, cw_status_message(status));
    check(strncmp(cw_last_error(), name, length) == 0 && cw_last_error()[length] == ':', "%s: \"%s\"", now,
          cw_last_error());
}

static void check_fine(cw_status status) {
    check(status == CW_OK, "%s: status \"%s\", \"%s\"", now, cw_status_message(status), cw_last_error());
}

/* ---- right arguments, by their names --------------------------------------------------------------------------------- */

typedef union value {
    void *p;
    double d;
    size_t n;
    cw_rectangle at;
} value;

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
static void *out;
static cw_field *field;
static cw_heading *heading;
static cw_field_desc field_desc = {.samples = samples, .nx = SIDE, .ny = SIDE, .map = {{1}, {0, 1}, {0, 0, 1}}};
static cw_heading_desc heading_desc = {.dir = {1, 0.5}};
static cw_run run;
static cw_update update = {.at = {1, 1, 2, 2}, .samples = samples};
static cw_tasks tasks = {.threads = 2, .run = run_tasks};
static cw_allocator allocator = {.allocate = allocate, .release = release};

static const char arrays[] = "rays hits occluded in out xy xyz points normals slope";
static const char optional[] = "run allocator label pool watch watch_context context";

static value good_value(const char *function, const parameter *p, size_t number) {
    const struct {
        const char *name;
        value value;
    } named[] = {
        {"field", {.p = field}},
        {"heading", {.p = heading}},
        {"desc", {.p = strstr(function, "heading") ? (void *)&heading_desc : (void *)&field_desc}},
        {"run", {.p = &run}},
        {"update", {.p = &update}},
        {"tasks", {.p = &tasks}},
        {"dir", {.p = heading_desc.dir}},
        {"threads", {.n = 2}},
        {"n", {.n = 2}},
        {"at", {.at = {0, 0, SIDE, SIDE}}},
        {"low", {.d = -1}},
        {"high", {.d = 1}},
    };
    if (p->kind == OUT) return (value){.p = &out};
    for (size_t k = 0; k < sizeof named / sizeof named[0]; k++)
        if (strcmp(named[k].name, p->name) == 0) return named[k].value;
    if (p->kind == POINTER) return (value){.p = room[number]};
    return (value){0};
}

/* ---- functions ----------------------------------------------------------------------------------------------------- */

#define FUNCTIONS(X)                                                                                                   \
    X(cw_pool_create, (uint32_t)v[0].n, v[1].p)                                                                        \
    X(cw_pool_create_on, v[0].p, v[1].p)                                                                               \
    X(cw_field_create, v[0].p, v[1].p, v[2].p)                                                                         \
    X(cw_field_build, v[0].p, v[1].p)                                                                                  \
    X(cw_field_update, v[0].p, v[1].p, v[2].p)                                                                         \
    X(cw_field_move, v[0].p, v[1].p, (uint32_t)v[2].n)                                                                 \
    X(cw_run_check, v[0].p, v[1].p)                                                                                    \
    X(cw_closest, v[0].p, v[1].p, v[2].p, v[3].n, v[4].p)                                                              \
    X(cw_occluded, v[0].p, v[1].p, v[2].p, v[3].n, v[4].p)                                                             \
    X(cw_closest_user, v[0].p, v[1].p, v[2].p, v[3].n, v[4].p)                                                         \
    X(cw_occluded_user, v[0].p, v[1].p, v[2].p, v[3].n, v[4].p)                                                        \
    X(cw_rays_to_field, v[0].p, v[1].p, v[2].p, v[3].n, v[4].p)                                                        \
    X(cw_surface_at, v[0].p, v[1].p, v[2].p, v[3].n, v[4].p)                                                           \
    X(cw_surface_at_user, v[0].p, v[1].p, v[2].p, v[3].n, v[4].p)                                                      \
    X(cw_hit_points, v[0].p, v[1].p, v[2].p, v[3].n, v[4].p)                                                           \
    X(cw_hit_normals, v[0].p, v[1].p, v[2].p, v[3].n, v[4].p)                                                          \
    X(cw_hit_phong_normals, v[0].p, v[1].p, v[2].p, v[3].n, v[4].p)                                                    \
    X(cw_heading_create, v[0].p, v[1].p, v[2].p)                                                                       \
    X(cw_heading_steepest, v[0].p, v[1].p, (float)v[2].d, (float)v[3].d, v[4].at, v[5].p)                              \
    X(cw_heading_occluded, v[0].p, v[1].p, (float)v[2].d, v[3].at, v[4].p)
#define CALL(NAME, ...)                                                                                                \
    static cw_status call_##NAME(const value *v) { return NAME(__VA_ARGS__); }
#define ROW(NAME, ...) {#NAME, call_##NAME},
FUNCTIONS(CALL)
static const struct function {
    const char *name;
    cw_status (*call)(const value *v);
} functions[] = {FUNCTIONS(ROW)};
enum { FUNCTION_COUNT = sizeof functions / sizeof functions[0] };

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

/* The function that is declared there, and its parameters. */
static const struct function *find(const char *name, parameter list[MOST], size_t *count) {
    const char *open = strchr(name, '(');
    for (const struct function *f = functions; f < functions + FUNCTION_COUNT; f++) {
        if (strlen(f->name) != (size_t)(open - name) || memcmp(f->name, name, strlen(f->name)) != 0) continue;
        *count = read_list(open + 1, strchr(open, ')'), false, list);
        return f;
    }
    check(false, "%.*s has no row", (int)(open - name), name);
    return NULL;
}

static void wrong_arguments(const struct function *f, const parameter *list, size_t count) {
    value good[MOST], v[MOST];
    for (size_t k = 0; k < count; k++) good[k] = good_value(f->name, &list[k], k);
    snprintf(now, sizeof now, "%s", f->name);
    check_fine(call(f, good));
    for (size_t k = 0; k < count; k++) {
        const parameter *p = &list[k];
        memcpy(v, good, sizeof v);
        if (p->kind == POINTER || p->kind == OUT || p->kind == REAL) {
            snprintf(now, sizeof now, "%s, %s %s", f->name, p->name, p->kind == REAL ? "NaN" : "NULL");
            if (p->kind == REAL)
                v[k].d = (double)NAN;
            else
                v[k].p = NULL;
            const bool may_be = has_word(optional, p->name) || strcmp(now, "cw_run_check, field NULL") == 0;
            const cw_status status = call(f, v);
            if (may_be && p->kind != OUT)
                check_fine(status);
            else
                check_refused(status, p->name);
        }
        if (strcmp(p->name, "run") == 0) { /* what a later version would mean by more */
            cw_run later = {0};
            v[k].p = &later;
            for (size_t w = 0; w < sizeof later.reserved / sizeof *later.reserved; w++) {
                snprintf(now, sizeof now, "%s, a later version's run: word %zu", f->name, w);
                later.reserved[w] = (uint64_t)1 << 63;
                check_refused(call(f, v), "cw_run");
                later.reserved[w] = 0;
            }
        }
        if ((p->kind != COUNT || strcmp(p->name, "n") != 0) && p->kind != RECTANGLE) continue;
        snprintf(now, sizeof now, "%s, %s empty, without arrays", f->name, p->name);
        for (size_t a = 0; a < count; a++)
            if (has_word(arrays, list[a].name) && list[a].kind == POINTER) v[a].p = NULL;
        for (int side = 0; side < 3; side++) {
            v[k] = good[k];
            if (p->kind == COUNT)
                v[k].n = 0;
            else if (side != 1)
                v[k].at.nx = 0;
            if (p->kind == RECTANGLE && side != 0) v[k].at.ny = 0;
            check_fine(call(f, v));
        }
    }
}

static void each_function(void **state) {
    (void)state;
    size_t found = 0;
    static const char begin[] = "CW_API cw_status ";
    for (const char *at = header; (at = strstr(at, begin)) != NULL; at++, found++) {
        parameter list[MOST];
        size_t count;
        const struct function *f = find(at + strlen(begin), list, &count);
        wrong_arguments(f, list, count);
    }
    check(found == FUNCTION_COUNT, "%zu functions in the header, and %d here", found, (int)FUNCTION_COUNT);
    now[0] = '\0';
}

/* ---- structs ------------------------------------------------------------------------------------------------------- */

static const struct filled {
    const char *name;
    void *good;
    size_t size;
    const char *declaration; /* of a function that takes it */
    size_t parameter;
} structs[] = {
    {"cw_tasks", &tasks, sizeof tasks, "cw_pool_create_on(", 0},
    {"cw_run", &run, sizeof run, "cw_closest(", 1},
    {"cw_allocator", &allocator, sizeof allocator, "cw_field_create(", 0},
    {"cw_field_desc", &field_desc, sizeof field_desc, "cw_field_create(", 0},
    {"cw_update", &update, sizeof update, "cw_field_update(", 2},
    {"cw_heading_desc", &heading_desc, sizeof heading_desc, "cw_heading_create(", 1},
};
enum { STRUCT_COUNT = sizeof structs / sizeof structs[0] };

static cw_status call_with(const struct filled *s, void *bytes) {
    parameter list[MOST];
    value v[MOST];
    size_t count;
    const struct function *f = find(strstr(header, s->declaration), list, &count);
    for (size_t k = 0; k < count; k++) v[k] = good_value(f->name, &list[k], k);
    cw_field_desc with_allocator = field_desc;
    with_allocator.allocator = bytes;
    v[s->parameter].p = s->good == &allocator ? &with_allocator : bytes;
    return call(f, v);
}

static void wrong_member(const struct filled *s, const parameter *p) {
    max_align_t room_for_one[16];
    unsigned char *bytes = memcpy(room_for_one, s->good, s->size), *member = bytes + p->offset;
    check(s->size <= sizeof room_for_one, "no room");
    snprintf(now, sizeof now, "%s, %s", s->name, p->name);
    if (p->kind == RECTANGLE) { /* empty: then there are no samples either */
        memset(member, 0, p->size);
        check_fine(call_with(s, bytes));
        memset(member + p->size, 0, sizeof(void *));
        check_fine(call_with(s, bytes));
        return;
    }
    const double nan = (double)NAN;
    const float float_nan = NAN;
    if (p->kind == REAL)
        p->size == sizeof float_nan ? memcpy(member, &float_nan, sizeof float_nan) : memcpy(member, &nan, sizeof nan);
    else
        memset(member, p->kind == POINTER ? 0 : 0xff, p->size);
    const cw_status status = call_with(s, bytes);
    if ((p->kind == POINTER || p->kind == REAL) && has_word(optional, p->name) && strcmp(now, "cw_tasks, run") != 0)
        check_fine(status);
    else
        check_refused(status, has_word("reserved zero", p->name) ? s->name : p->name);
}

static void each_struct(void **state) {
    (void)state;
    size_t found = 0;
    static const char begin[] = "typedef struct ";
    for (const char *at = header; (at = strstr(at, begin)) != NULL; at++) {
        const char *name = at + strlen(begin), *open = name + strcspn(name, " ;"), *end = strstr(name, "\n} cw_");
        if (open[0] == ';' || open[1] != '{') continue;
        const struct filled *s = structs;
        while (s < structs + STRUCT_COUNT &&
               (strlen(s->name) != (size_t)(open - name) || memcmp(s->name, name, strlen(s->name)) != 0))
            s++;
        const bool grows = memmem(open, (size_t)(end - open), "reserved", 8) != NULL;
        check(s < structs + STRUCT_COUNT || !grows, "%.*s has no row", (int)(open - name), name);
        if (s == structs + STRUCT_COUNT) continue;
        parameter list[MOST];
        const size_t count = read_list(open + 2, end, true, list);
        const size_t size = (list[count - 1].offset + list[count - 1].size + 7) / 8 * 8;
        check(size == s->size, "%s has %zu bytes, not %zu", s->name, s->size, size);
        for (size_t k = 0; k < count; k++) wrong_member(s, &list[k]);
        found++;
    }
    check(found == STRUCT_COUNT, "%zu structs in the header, and %d here", found, (int)STRUCT_COUNT);
    now[0] = '\0';
}

static int set_up(void **state) {
    (void)state;
    const bool good = cw_field_create(&field_desc, NULL, &field) == CW_OK &&
                      cw_heading_create(field, &heading_desc, &heading) == CW_OK;
    return good ? read_header() : -1;
}

static int tear_down(void **state) {
    (void)state;
    if (now[0] != '\0') print_error("the last call: %s\n", now);
    cw_heading_destroy(heading);
    cw_field_destroy(field);
    free(header);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_function),
        cmocka_unit_test(each_struct),
    };
    return cmocka_run_group_tests_name("arguments", tests, set_up, tear_down);
}
