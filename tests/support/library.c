/* SPDX-License-Identifier: Apache-2.0 */
/* The libraries' functions as a program for tests in Python (words.h, library.py). A command is a function's name and
 * arguments, each a number or room in memory for the call: <SIZE OFFSET is filled from the file in, >SIZE OFFSET goes
 * to the file out, =SIZE OFFSET both. It begins OFFSET behind a multiple of 64; nothing may be written beside it. */

#include "cellwalk_expert.h"
#include "fpenv.h"
#include "pyramid.h"
#include "reference.h"
#include "words.h"

#include "library_terrain.h"

#include <pthread.h>
#include <sys/mman.h>

enum { WORDS = 8, GUARD = 64, UNTOUCHED = 0x5a };

typedef struct value {
    void *p;
    size_t n;
    double d;
    unsigned char *room; /* from which p is offset, with size bytes and two guards; NULL: none */
    size_t size, offset;
    bool goes_out;
} value;

/* ---- functions --------------------------------------------------------------------------------------------------- */

#define P(k)  v[k].p
#define N(k)  v[k].n
#define F(k)  (float)v[k].d
#define U(k)  (uint32_t) v[k].n
#define AT(k) *(const cw_rectangle *)v[k].p

/* Of the floating-point environment of calls; FP_MODES and above: as it is. 0 where fpenv.h has no numbers for it. */
#if defined(__SSE__) || defined(__aarch64__)
enum { FP_MODES = FPENV_FLAGS ? 32 : 16 };
/* Flags in B too are in A, which may have more. */
#define FP_CHANGED(A, B) (mode < FP_MODES && ((((A) ^ (B)) & ~(fpenv)FPENV_FLAGS) != 0 || ((B) & ~(A)) != 0))
#else
enum { FP_MODES = 0 };
#define FP_CHANGED(A, B) false
#endif
static size_t mode = FP_MODES;

/* Bit 0 flushes denormal results to zero, bit 1 denormal operands, two bits choose the rounding, bit 4 unmasks all
 * exceptions and raises two flags. On ARM bit 0 is for operands and results, bit 1 gives every NaN the same bits. */
static fpenv environment(fpenv now) {
#if defined(__SSE__)
    enum { FTZ = 0x8000, DAZ = 0x40, ROUNDING = 0x2000, MASKS = 0x1f80, FLAGS = 0x9 };
    if (mode < FP_MODES)
        now = (unsigned)(FPENV_DEFAULT | (mode & 1 ? FTZ : 0) | (mode & 2 ? DAZ : 0) | mode % 16 / 4 * ROUNDING);
    if (mode < FP_MODES && mode >= 16) now = (now ^ MASKS) | FLAGS;
#elif defined(__aarch64__)
    enum { FZ = 1 << 24, DN = 1 << 25, ROUNDING = 1 << 22 };
    if (mode < FP_MODES) now = (mode & 1 ? FZ : 0) | (mode & 2 ? DN : 0) | mode / 4 * ROUNDING;
#endif
    return now;
}

static void status(cw_status s) { fprintf(answer, "%d %s", s, cw_last_error()); }
static void number(size_t n) { fprintf(answer, "%zu", n); }
static void address(const void *p) { number((size_t)p); }
static void text(const char *t) { fputs(t ? t : "NULL", answer); }

#define QUERY(NAME) X(NAME, status(NAME(P(0), P(1), P(2), N(3), P(4))))
#define FUNCTIONS                                                                                                      \
    X(cw_pool_create, status(cw_pool_create(U(0), P(1))))                                                              \
    X(cw_pool_create_on, status(cw_pool_create_on(P(0), P(1))))                                                        \
    X(cw_pool_destroy, cw_pool_destroy(P(0)))                                                                          \
    X(cw_pool_threads, number(cw_pool_threads(P(0))))                                                                  \
    X(cw_field_create, status(cw_field_create(P(0), P(1), P(2))))                                                      \
    X(cw_field_destroy, cw_field_destroy(P(0)))                                                                        \
    X(cw_field_describe_into, cw_field_describe_into(P(0), P(1), N(2)))                                                \
    X(cw_field_row, address(cw_field_row(P(0), N(1))))                                                                 \
    X(cw_field_build, status(cw_field_build(P(0), P(1))))                                                              \
    X(cw_field_update, status(cw_field_update(P(0), P(1), P(2))))                                                      \
    X(cw_field_move, status(cw_field_move(P(0), P(1), U(2))))                                                          \
    X(cw_run_check, status(cw_run_check(P(0), P(1))))                                                                  \
    X(cw_run_kernel, address(cw_run_kernel(P(0), P(1))))                                                               \
    QUERY(cw_closest)                                                                                                  \
    QUERY(cw_occluded)                                                                                                 \
    QUERY(cw_closest_user)                                                                                             \
    QUERY(cw_occluded_user)                                                                                            \
    QUERY(cw_rays_to_field)                                                                                            \
    QUERY(cw_surface_at)                                                                                               \
    QUERY(cw_surface_at_user)                                                                                          \
    QUERY(cw_hit_points)                                                                                               \
    QUERY(cw_hit_normals)                                                                                              \
    QUERY(cw_hit_phong_normals)                                                                                        \
    X(cw_heading_create, status(cw_heading_create(P(0), P(1), P(2))))                                                  \
    X(cw_heading_destroy, cw_heading_destroy(P(0)))                                                                    \
    X(cw_heading_steepest, status(cw_heading_steepest(P(0), P(1), F(2), F(3), AT(4), P(5))))                           \
    X(cw_heading_occluded, status(cw_heading_occluded(P(0), P(1), F(2), AT(3), P(4))))                                 \
    X(cw_kernel_count, number(cw_kernel_count()))                                                                      \
    X(cw_kernel_at, address(cw_kernel_at(N(0))))                                                                       \
    X(cw_kernel_find, address(cw_kernel_find(P(0))))                                                                   \
    X(cw_kernel_exists, number(cw_kernel_exists(P(0))))                                                                \
    X(cw_kernel_describe_into, cw_kernel_describe_into(P(0), P(1), N(2)))                                              \
    X(cw_isa_best, number((size_t)cw_isa_best()))                                                                      \
    X(cw_isa_limit, cw_isa_limit((cw_isa)N(0)))                                                                        \
    X(cw_isa_includes, number(cw_isa_includes((cw_isa)N(0), (cw_isa)N(1))))                                            \
    X(cw_isa_name, text(cw_isa_name((cw_isa)N(0))))                                                                    \
    X(cw_leaf_name, text(cw_leaf_name((cw_leaf)N(0))))                                                                 \
    X(cw_status_message, text(cw_status_message((cw_status)N(0))))                                                     \
    X(cw_version, text(cw_version()))                                                                                  \
    X(cw_version_number, number(cw_version_number()))                                                                  \
    TERRAIN_FUNCTIONS                                                                                                  \
    X(drop, drop(P(0)))                                                                                                \
    X(keep, address(keep(P(0), v[0].size)))                                                                            \
    X(pages, address(mmap(NULL, N(0), PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0)))                    \
    X(forbid, number((size_t)mprotect(P(0), N(1), PROT_NONE)))                                                         \
    X(peek, memcpy(P(1), P(0), v[1].size))                                                                             \
    X(poke, memcpy(P(0), P(1), v[1].size))                                                                             \
    X(text, text(P(0)))                                                                                                \
    X(inside, inside(P(0)))                                                                                            \
    X(bounds, bounds(P(0), N(1)))                                                                                      \
    X(setenv, setenv(P(0), P(1), 1))                                                                                   \
    X(set_mode, mode = N(0); number(FP_MODES))

/* ---- memory that stays ------------------------------------------------------------------------------------------- */

static void *kept[4096];
static size_t kept_count;

static void *keep(const void *bytes, size_t size) {
    stop_unless(kept_count < sizeof kept / sizeof *kept && (kept[kept_count] = malloc(size + 1)), "keep");
    return memcpy(kept[kept_count++], bytes, size);
}

static void drop(void *p) {
    size_t k = 0;
    while (kept[k] != p) stop_unless(++k < kept_count, "drop");
    free(p);
    kept[k] = kept[--kept_count];
}

/* ---- fields inside ----------------------------------------------------------------------------------------------- */

/* To the file inside: all that is the same in a field made anew. */
static void inside(const cw_field *f) {
    const struct cw_pyramid *p = f->pyramid;
    const struct {
        const void *bytes;
        size_t size;
    } parts[] = {{&f->low, offsetof(cw_field, owned) - offsetof(cw_field, low)}, /* also holes, middle and reach */
                 {&p->steepest, sizeof p->steepest},
                 {&p->high, sizeof p->high},
                 {&p->bytes, sizeof p->bytes},
                 {p->memory, p->bytes}};
    FILE *to = fopen("inside", "wb");
    for (size_t j = 0; to && j < f->ny; j++) fwrite(f->z + j * f->stride, sizeof *f->z, f->nx, to);
    for (size_t k = 0; to && k < sizeof parts / sizeof *parts; k++) fwrite(parts[k].bytes, 1, parts[k].size, to);
    stop_unless(to && fclose(to) == 0, "inside");
}

/* To files: a level's lowest samples of nodes, also of those outside the field, then the highest; its slabs; the
 * highest ahead. Answers how many nodes are in a row, how many of them in the field, and the number of levels. */
static void bounds(const cw_field *f, size_t level) {
    const struct cw_pyramid *p = f->pyramid;
    const cw_pyramid_level *l = &p->level[level];
    const size_t across = 4 * (size_t)l->across, down = 4 * (size_t)l->down, n = across * down;
    float *ends = malloc(2 * n * sizeof *ends);
    stop_unless(ends && level < (size_t)p->levels, "bounds");
    for (size_t k = 0; k < 2 * n; k++) ends[k] = cw_pyramid_node(l, k % n % across, k % n / across)[k < n ? 0 : 16];
    save("ends", ends, 2 * n * sizeof *ends);
    save("ahead", l->ahead, (across + 1) * (down + 1) * sizeof *l->ahead);
    const size_t wide = cw_pyramid_across(f, (int)level), high = cw_pyramid_down(f, (int)level);
    save("slabs", p->slab + p->first[level + 1], wide * high * sizeof *p->slab);
    fprintf(answer, "%zu %zu %d", across, wide, p->levels);
    free(ends);
}

/* ---- what the library calls -------------------------------------------------------------------------------------- */

typedef struct task {
    cw_task_fn *run;
    void *argument;
    uint32_t number;
    pthread_t thread;
} task;
static void *run_task(void *argument) {
    const task *t = argument;
    t->run(t->argument, t->number);
    return NULL;
}
/* Each on a new thread, from the last on. context: how often, and how many in all; or NULL */
static void run_tasks(void *context, cw_task_fn *run, void *argument, uint32_t count) {
    task tasks[8];
    stop_unless(count >= 1 && count <= 8, "tasks");
    if (context) ((uint64_t *)context)[0]++, ((uint64_t *)context)[1] += count;
    for (uint32_t k = count; k-- > 0;) {
        tasks[k] = (task){.run = run, .argument = argument, .number = k};
        stop_unless(pthread_create(&tasks[k].thread, NULL, run_task, &tasks[k]) == 0, "thread");
    }
    for (uint32_t k = 0; k < count; k++) pthread_join(tasks[k].thread, NULL);
}
/* context: how many blocks there are, or NULL */
static void *allocate(void *context, size_t bytes, size_t alignment) {
    if (context) ++*(int64_t *)context;
    stop_unless(alignment <= 1 << 21, "alignment");
    return aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
}
static void release(void *context, void *memory) {
    if (context) --*(int64_t *)context;
    free(memory);
}
/* context: the last share, the one from which on the call ends, and the field if its updates are kept out. */
static bool watch(void *context, double done) {
    double *seen = context;
    cw_field *field = (cw_field *)(uintptr_t)seen[2];
    const cw_field_info info = field ? cw_field_describe(field) : (cw_field_info){0};
    stop_unless(!field || cw_field_move(field, (const double(*)[4])info.map, 0) == CW_ERROR_BUSY, "an update comes in");
    stop_unless(done >= seen[0] && done <= 1, "a share that shrinks, or is more than all");
    seen[0] = done;
    return done < seen[1];
}
static bool lower_limit(void *context, double done) {
    cw_isa_limit(CW_ISA_SCALAR);
    return true;
}

/* ---- commands ---------------------------------------------------------------------------------------------------- */

static value value_of(const char *word, FILE *in) {
    value v = {.goes_out = *word != '<'};
    if (strchr("<>=", *word) == NULL) {
        v.n = whole(word);
        v.d = strtod(word, NULL);
        v.p = (void *)v.n;
        return v;
    }
    char *end;
    v.size = strtoull(word + 1, &end, 10);
    v.offset = GUARD + whole(end);
    const size_t all = (v.offset + v.size + 2 * GUARD - 1) / GUARD * GUARD;
    v.room = aligned_alloc(GUARD, all);
    stop_unless(v.room != NULL, word);
    memset(v.room, UNTOUCHED, all);
    v.p = v.room + v.offset;
    stop_unless(*word == '>' || fread(v.p, 1, v.size, in) == v.size, "in");
    return v;
}

static bool is_untouched(const unsigned char *from, const unsigned char *until) {
    while (from < until && *from == UNTOUCHED) from++;
    return from == until;
}

/* False if something was written beside it. */
static bool let_go(const value *v, FILE *out) {
    if (v->room == NULL) return true;
    unsigned char *begin = v->p, *end = begin + v->size;
    const bool good = is_untouched(v->room, begin) && is_untouched(end, end + GUARD);
    if (v->goes_out) stop_unless(fwrite(begin, 1, v->size, out) == v->size, "out");
    free(v->room);
    return good;
}

static int obey(char **words, io_error *e) {
    static const struct {
        const char *name;
        size_t address;
    } calls_back[] = {{"run_tasks", (size_t)run_tasks},
                      {"allocate", (size_t)allocate},
                      {"release", (size_t)release},
                      {"watch", (size_t)watch},
                      {"lower_limit", (size_t)lower_limit}};
    value v[WORDS] = {{0}};
    for (size_t k = 0; k < sizeof calls_back / sizeof *calls_back; k++)
        if (strcmp(words[0], calls_back[k].name) == 0) return number(calls_back[k].address), DONE;
    FILE *in = fopen("in", "rb"), *out = fopen("out", "wb");
    stop_unless(in && out, "in or out");
    for (size_t k = 0; k < WORDS && words[1 + k] && *words[1 + k]; k++) v[k] = value_of(words[1 + k], in);
    int how = OTHER;
    const fpenv before = fpenv_enter(), wanted = environment(before);
    fpenv_leave(wanted);
#define X(NAME, ...)                                                                                                   \
    if (strcmp(words[0], #NAME) == 0) {                                                                                \
        __VA_ARGS__;                                                                                                   \
        how = DONE;                                                                                                    \
    }
    FUNCTIONS
#undef X
    const fpenv after = fpenv_enter();
    fpenv_leave(before);
    if (FP_CHANGED(after, wanted)) how = io_fail(e, "%s changes the floating-point environment", words[0]);
    for (size_t k = 0; k < WORDS; k++)
        if (!let_go(&v[k], out)) how = io_fail(e, "%s writes beside its argument %zu", words[0], k);
    stop_unless(fclose(in) == 0 && fclose(out) == 0, "in or out");
    return how;
}

int main(int argc, char **argv) {
    cw_reference_add();
    const int done = words_run(argc, argv, obey);
    while (kept_count > 0) free(kept[--kept_count]);
    return done;
}
