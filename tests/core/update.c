/* SPDX-License-Identifier: Apache-2.0 */
/* Fields whose samples change, and fields made by several threads: every byte is that of a field made anew, by any
 * number of threads. Only here and in waiting.c do tests look inside. */

#include "check.h"
#include "field.h"
#include "pyramid.h"
#include "survey.h"
#include "workload/random.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* The last is large enough for two levels above tiles, and has room between rows. */
static const struct {
    size_t nx, ny, gap;
} sizes[] = {{2, 2, 0},    {2, 70, 3},    {20, 31, 0},   {65, 65, 1},    {66, 64, 0},
             {129, 65, 7}, {257, 258, 0}, {40, 1500, 0}, {700, 530, 13}, {1300, 260, 5}};
enum { SIZES = sizeof sizes / sizeof sizes[0], STRIDE_MAX = 1500, LIMIT_SECONDS = 300 };

typedef enum kind { NOISE, LAND, HOLES, PLATEAUS, HIGH_UP, KINDS } kind;
static const char *const kind_names[KINDS] = {"noise", "land", "holes", "plateaus", "high up"};
/* Where time is short each size takes one kind of three, another one than the size before. */
static int kind_step(void) { return (int)test_step(3); }
static int first_kind(size_t size) { return (int)(size % test_step(3)); }

static float height(kind k, size_t i, size_t j, random_state *r) {
    const float u = (float)random_unit(r), x = (float)i, y = (float)j;
    switch (k) {
    case NOISE:
        return u;
    case LAND:
        return 40 * sinf(x / 60) * cosf(y / 90) + 0.3f * u;
    case HOLES: /* single ones and a lake of them; zeros of either sign */
        if (u < 0.02f || (i > 100 && i < 300 && j > 30)) return NAN;
        return u < 0.1f ? -0.0f : u < 0.2f ? 0.0f : u;
    case PLATEAUS:
        return (float)(i / 50 + j / 70);
    case HIGH_UP: /* where a float tells little apart */
        return 1e6f + floorf(3 * u);
    default:
        return 0;
    }
}

/* A field, its samples and what they are to be. */
typedef struct place {
    size_t nx, ny, stride;
    float *z;
} place;

static place make_place(size_t size, kind k, random_state *r) {
    place p = {sizes[size].nx, sizes[size].ny, sizes[size].nx + sizes[size].gap, NULL};
    p.z = malloc(p.stride * p.ny * sizeof *p.z);
    assert_non_null(p.z);
    for (size_t j = 0; j < p.ny; j++)
        for (size_t i = 0; i < p.stride; i++) p.z[j * p.stride + i] = height(k, i, j, r);
    return p;
}

static cw_field *make_field(const place *p, cw_storage storage, cw_pool *pool) {
    cw_field *field;
    const cw_field_desc d = {.samples = p->z, .nx = p->nx, .ny = p->ny, .stride = p->stride, .storage = storage};
    const cw_run how = {.pool = pool};
    check_status(cw_field_create(&d, &how, &field), CW_OK);
    return field;
}

static bool same(const void *a, const void *b, size_t bytes) { return memcmp(a, b, bytes) == 0; }

/* NULL, or what differs. */
static const char *difference(const cw_field *a, const cw_field *b) {
    for (size_t j = 0; j < a->ny; j++)
        if (!same(a->z + j * a->stride, b->z + j * b->stride, a->nx * sizeof *a->z)) return "samples";
    if (!same(&a->low, &b->low, sizeof a->low) || !same(&a->high, &b->high, sizeof a->high)) return "low or high";
    if (a->holes != b->holes) return "holes";
    if (!same(a->middle, b->middle, sizeof a->middle) || !same(a->reach, b->reach, sizeof a->reach)) return "reach";
    const struct cw_pyramid *p = a->pyramid, *q = b->pyramid;
    if (!same(&p->steepest, &q->steepest, sizeof p->steepest)) return "steepest slope";
    if (!same(&p->high, &q->high, sizeof p->high)) return "pyramid's highest";
    if (p->levels != q->levels || p->bytes != q->bytes) return "pyramid's layout";
    return same(p->memory, q->memory, p->bytes) ? NULL : "pyramid";
}

static void check_same(const cw_field *got, const cw_field *wanted, const char *what) {
    const char *differs = difference(got, wanted);
    check(differs == NULL, "%s: another %s", what, differs ? differs : "");
}

/* A rectangle anywhere: mostly small, on borders, of one sample, or all. */
static cw_update some_rectangle(const place *p, random_state *r) {
    cw_update u = {.at = {.i = random_below(r, p->nx), .j = random_below(r, p->ny)}};
    const size_t most = random_below(r, 4) == 0 ? STRIDE_MAX : 40;
    u.at.nx = 1 + random_below(r, most);
    u.at.ny = 1 + random_below(r, most);
    switch (random_below(r, 8)) {
    case 0:
        return (cw_update){.at = {.nx = p->nx, .ny = p->ny}};
    case 1:
        u.at.nx = u.at.ny = 1;
        break;
    case 2: /* where tiles meet */
        u.at.i = u.at.i / 64 * 64;
        u.at.j = u.at.j / 64 * 64;
        u.at.nx = 1;
        break;
    case 3:
        u.at.i = 0;
        u.at.j = p->ny - 1;
        break;
    case 4:
        u.at.i = p->nx - 1;
        break;
    default:
        break;
    }
    u.at.nx = u.at.nx < p->nx - u.at.i ? u.at.nx : p->nx - u.at.i;
    u.at.ny = u.at.ny < p->ny - u.at.j ? u.at.ny : p->ny - u.at.j;
    return u;
}

/* New samples, which may raise what was lowest and lower what was highest; sometimes the old ones again. */
static void change(const place *p, const cw_update *u, kind k, random_state *r) {
    const float by = (float)random_between(r, -30, 30), from = random_below(r, 2) ? 1 : 0;
    for (size_t j = u->at.j; j < u->at.j + u->at.ny; j++)
        for (size_t i = u->at.i; i < u->at.i + u->at.nx; i++) p->z[j * p->stride + i] = from * height(k, i, j, r) + by;
}

static void updates_give_what_is_made_anew(void **state) {
    (void)state;
    random_state r = {3};
    static const unsigned threads[] = {1, 2, 3, 7};
    cw_pool *pool[4];
    for (size_t t = 0; t < 4; t++) check_status(cw_pool_create(threads[t], &pool[t]), CW_OK);
    for (size_t round = 0; round < test_rounds(); round++)
        for (size_t s = 0; s < SIZES; s++)
            for (int k = first_kind(s); k < KINDS; k += kind_step()) {
                const place p = make_place(s, (kind)k, &r);
                cw_field *borrowed = make_field(&p, CW_BORROW, NULL);
                cw_field *copied = make_field(&p, CW_COPY, NULL);
                for (size_t turn = 0; turn < test_share(12, 1); turn++) {
                    char what[100];
                    cw_update u = some_rectangle(&p, &r);
                    change(&p, &u, (kind)(turn % KINDS), &r);
                    snprintf(what, sizeof what, "%zu x %zu, %s, %zu x %zu from (%zu, %zu)", p.nx, p.ny, kind_names[k],
                             u.at.nx, u.at.ny, u.at.i, u.at.j);
                    const cw_run how = {.pool = pool[(turn + s) % 4]};
                    check_status(cw_field_update(borrowed, &how, &u), CW_OK);
                    u.samples = p.z + u.at.j * p.stride + u.at.i;
                    u.stride = p.stride;
                    check_status(cw_field_update(copied, &how, &u), CW_OK);
                    cw_field *anew =
                        make_field(&p, turn % 2 ? CW_COPY : CW_BORROW, pool[(turn + s + (size_t)k + 1) % 4]);
                    check_same(borrowed, anew, what);
                    check_same(copied, anew, what);
                    cw_field_destroy(anew);
                }
                cw_field_destroy(borrowed);
                cw_field_destroy(copied);
                free(p.z);
            }
    for (size_t t = 0; t < 4; t++) cw_pool_destroy(pool[t]);
}

/* True if the node has exactly the lowest and highest of its samples and, above tiles, all of them lie within its slab. Slabs of tiles and
 * smaller nodes are made in float, so samples may be beyond them by rounding, for which rays have a pad. */
static bool bounds_hold(const cw_field *f, int level, size_t x, size_t y) {
    const struct cw_pyramid *p = f->pyramid;
    const size_t side = (size_t)4 << 2 * level;
    const cw_pyramid_slab *s = &p->slab[(size_t)p->first[level + 1] + y * cw_pyramid_across(f, level) + x];
    const float *node = cw_pyramid_node(&p->level[level], x, y);
    float low = INFINITY, high = -INFINITY;
    for (size_t j = y * side; j <= (y + 1) * side && j < f->ny; j++)
        for (size_t i = x * side; i <= (x + 1) * side && i < f->nx; i++) {
            const double dx = (double)i - ((double)x + 0.5) * (double)side,
                         dy = (double)j - ((double)y + 0.5) * (double)side;
            const float z = f->z[j * f->stride + i];
            const double d = (double)z - (double)s->slope_x * dx - (double)s->slope_y * dy;
            if (level > TILE_LEVEL && (d < (double)s->low || d > (double)s->high)) return false;
            low = z < low ? z : low;
            high = z > high ? z : high;
        }
    return low <= high ? node[0] == low && node[16] == high : isnan(node[0]) && isnan(node[16]);
}

/* The highest samples of nodes two by two. */
static bool ahead_holds(const cw_pyramid_level *l) {
    const size_t across = 4 * (size_t)l->across, down = 4 * (size_t)l->down;
    for (size_t y = 0; y <= down; y++)
        for (size_t x = 0; x <= across; x++) {
            float high = -INFINITY;
            for (size_t j = y > 0 ? y - 1 : 0; j <= y && j < down; j++)
                for (size_t i = x > 0 ? x - 1 : 0; i <= x && i < across; i++)
                    if (cw_pyramid_node(l, i, j)[16] > high) high = cw_pyramid_node(l, i, j)[16];
            if (l->ahead[y * (across + 1) + x] != high) return false;
        }
    return true;
}

/* Bounds that leave out a sample lose hits, which no other test shows of large nodes; bounds that are too wide only cost time. */
static void bounds_are_those_of_the_samples(void **state) {
    (void)state;
    random_state r = {5};
    size_t leaning = 0;
    for (size_t s = 0; s < SIZES; s++)
        for (int k = first_kind(s); k < KINDS; k += kind_step()) {
            const place p = make_place(s, (kind)k, &r);
            cw_field *f = make_field(&p, CW_BORROW, NULL);
            for (int l = 0; l < f->pyramid->levels; l++) {
                check(ahead_holds(&f->pyramid->level[l]), "%zu x %zu, %s: ahead of level %d", p.nx, p.ny, kind_names[k],
                      l);
                for (size_t n = 0; n < cw_pyramid_across(f, l) * cw_pyramid_down(f, l); n++) {
                    const size_t x = n % cw_pyramid_across(f, l), y = n / cw_pyramid_across(f, l);
                    check(bounds_hold(f, l, x, y), "%zu x %zu, %s: node (%zu, %zu) of level %d", p.nx, p.ny,
                          kind_names[k], x, y, l);
                    leaning += l > TILE_LEVEL && f->pyramid->slab[(size_t)f->pyramid->first[l + 1] + n].slope_x != 0;
                }
            }
            cw_field_destroy(f);
            free(p.z);
        }
    check(leaning > 10, "%zu slabs above tiles lean", leaning);
}

/* ---- at the same time ------------------------------------------------------------------------------------------------ */

typedef struct meeting {
    cw_field *field;
    cw_update update;
    cw_status status[3]; /* of what was tried meanwhile */
    unsigned tried;
} meeting;

/* From within a query: it runs. */
static bool update_meanwhile(void *context, double done) {
    meeting *m = context;
    (void)done;
    m->status[0] = cw_field_update(m->field, NULL, &m->update);
    m->tried++;
    return true;
}

/* From within an update, on whose pool this is. */
static void ask_meanwhile(void *context, cw_task_fn *task, void *argument, uint32_t count) {
    meeting *m = context;
    const cw_ray ray = {.org = {1, 1, 0}, .dir = {1, 0, 0}, .tmax = 1};
    const cw_user_ray user = {.org = {1, 1, 0}, .dir = {1, 0, 0}, .tmax = 1};
    /* Whose grid the update frees. */
    const cw_run grid = {.expert.kernel = cw_kernel_find("grid3d")};
    cw_hit hit;
    uint8_t occluded;
    double point[3];
    const cw_status status[] = {
        cw_closest(m->field, NULL, &ray, 1, &hit),       cw_occluded(m->field, NULL, &ray, 1, &occluded),
        cw_closest_user(m->field, NULL, &user, 1, &hit), cw_occluded_user(m->field, NULL, &user, 1, &occluded),
        cw_hit_points(m->field, NULL, &hit, 1, point),   cw_field_update(m->field, NULL, &m->update),
        cw_closest(m->field, &grid, &ray, 1, &hit),      cw_occluded(m->field, &grid, &ray, 1, &occluded)};
    for (size_t k = 0; k < sizeof status / sizeof status[0]; k++) check_status(status[k], CW_ERROR_BUSY);
    m->tried++;
    for (unsigned k = 0; k < count; k++) task(argument, k);
}

static void who_comes_second_is_turned_away(void **state) {
    (void)state;
    random_state r = {6};
    const place p = make_place(8, LAND, &r);
    cw_field *f = make_field(&p, CW_COPY, NULL), *anew = make_field(&p, CW_COPY, NULL);
    meeting m = {.field = f, .update = {.at = {.nx = 300, .ny = 300}, .samples = p.z, .stride = p.stride}};
    const cw_ray ray = {.org = {1, 1, 0}, .dir = {1, 0, 0}, .tmax = 1};
    const cw_user_ray user = {.org = {1, 1, 0}, .dir = {1, 0, 0}, .tmax = 1};
    const cw_run q = {.watch = update_meanwhile, .watch_context = &m};
    cw_hit hit;
    check_status(cw_closest(f, &q, &ray, 1, &hit), CW_OK);
    check_status(m.status[0], CW_ERROR_BUSY);
    check_status(cw_closest_user(f, &q, &user, 1, &hit), CW_OK);
    check_status(m.status[0], CW_ERROR_BUSY);
    assert_int_equal(m.tried, 2);

    cw_pool *pool;
    const cw_tasks tasks = {.threads = 2, .run = ask_meanwhile, .context = &m};
    check_status(cw_pool_create_on(&tasks, &pool), CW_OK);
    check_status(cw_field_build(f, &(cw_run){.expert.kernel = cw_kernel_find("grid3d")}), CW_OK);
    check_status(cw_field_update(f, &(cw_run){.pool = pool}, &m.update), CW_OK);
    check(m.tried > 2, "nothing was tried during the update");
    check_same(f, anew, "after all of that");
    check_status(cw_closest(f, NULL, &ray, 1, &hit), CW_OK);
    cw_pool_destroy(pool);
    cw_field_destroy(f);
    cw_field_destroy(anew);
    free(p.z);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(updates_give_what_is_made_anew),
        cmocka_unit_test(bounds_are_those_of_the_samples),
        cmocka_unit_test(who_comes_second_is_turned_away),
    };
    alarm(LIMIT_SECONDS);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
