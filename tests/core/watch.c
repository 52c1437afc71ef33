/* SPDX-License-Identifier: Apache-2.0 */
/* A watch sees growing shares of each call up to all of it, from one thread at a time, and ends the call wherever it says so; it changes
 * no answer. Products of terrain are in terrain/areas.c. */

#include "cellwalk_terrain.h"
#include "check.h"
#include "fields.h"
#include "rays.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum { RAYS = 30000, NX = 613, NY = 101 };

static test_field shape;
static cw_field *field;
static cw_ray rays[RAYS];
static cw_user_ray user_rays[RAYS];
static cw_hit found[RAYS]; /* to ask for their points and normals */
static struct answers {
    cw_hit hits[RAYS];
    uint8_t occluded[RAYS];
    double many[RAYS][3];
} now, unwatched;

/* ---- calls ------------------------------------------------------------------------------------------------------------- */

static cw_status closest(const cw_run *run) { return cw_closest(field, run, rays, RAYS, now.hits); }
static cw_status closest_user(const cw_run *run) { return cw_closest_user(field, run, user_rays, RAYS, now.hits); }
static cw_status any(const cw_run *run) { return cw_occluded(field, run, rays, RAYS, now.occluded); }
static cw_status any_user(const cw_run *run) { return cw_occluded_user(field, run, user_rays, RAYS, now.occluded); }
static cw_status points(const cw_run *run) { return cw_hit_points(field, run, found, RAYS, now.many[0]); }
static cw_status normals(const cw_run *run) { return cw_hit_normals(field, run, found, RAYS, now.many[0]); }
static cw_status smooth_normals(const cw_run *run) {
    return cw_hit_phong_normals(field, run, found, RAYS, now.many[0]);
}
static cw_status create(const cw_run *run, cw_storage storage) {
    const cw_field_desc desc = {.samples = shape.z, .nx = NX, .ny = NY, .storage = storage};
    cw_field *made;
    const cw_status status = cw_field_create(&desc, run, &made);
    check((made != NULL) == (status == CW_OK), "a field with status %d", (int)status);
    cw_field_destroy(made);
    return status;
}
static cw_status copy(const cw_run *run) { return create(run, CW_COPY); }
static cw_status borrow(const cw_run *run) { return create(run, CW_BORROW); }
static cw_status coarser(const cw_run *run) {
    cw_field *made;
    cw_difference difference;
    const cw_status status = cw_field_coarser(field, run, 2, CW_FILTER_MEAN, &made, &difference, sizeof difference);
    check((made != NULL) == (status == CW_OK), "a coarser field with status %d", (int)status);
    cw_field_destroy(made);
    return status;
}

static const struct {
    const char *name;
    cw_status (*make)(const cw_run *run);
} calls[] = {
    {"closest hits", closest},
    {"closest hits, user's", closest_user},
    {"any hits", any},
    {"any hits, user's", any_user},
    {"points", points},
    {"normals", normals},
    {"smooth normals", smooth_normals},
    {"a field", borrow},
    {"a field of a copy", copy},
    {"a coarser field", coarser},
};

/* ---- tests ------------------------------------------------------------------------------------------------------------- */

typedef struct watch {
    double first, last, stop_at;
    unsigned calls, wrong;
    atomic_int inside;
} watch;

static bool look(void *context, double done) {
    watch *w = context;
    w->wrong += atomic_fetch_add(&w->inside, 1) != 0 || !(done > w->last && done <= 1) || w->last >= w->stop_at;
    if (w->calls++ == 0) w->first = done;
    w->last = done;
    atomic_fetch_sub(&w->inside, 1);
    return done < w->stop_at;
}

static void each_call_is_watched(void **state) {
    (void)state;
    cw_pool *pool;
    check_status(cw_pool_create(3, &pool), CW_OK);
    for (size_t k = 0; k < sizeof calls / sizeof *calls; k++) {
        memset(&now, 0xa5, sizeof now);
        check_status(calls[k].make(NULL), CW_OK);
        unwatched = now;
        for (int shared = 0; shared < 2; shared++) {
            watch w = {.stop_at = 2};
            const cw_run run = {.pool = shared ? pool : NULL, .watch = look, .watch_context = &w};
            memset(&now, 0xa5, sizeof now);
            check_status(calls[k].make(&run), CW_OK);
            check(memcmp(&now, &unwatched, sizeof now) == 0, "%s: other answers under a watch", calls[k].name);
            check(fabs(w.last - 1) < 1e-9 && w.calls > 2 && w.wrong == 0, "%s: %u calls, %u wrong, up to %g",
                  calls[k].name, w.calls, w.wrong, w.last);
            /* Rays may be slow, so the first piece is small. */
            check(k > 3 || shared || w.first <= 64.0 / RAYS, "%s: %g at once", calls[k].name, w.first);
            for (double stop = 1e-9; stop < 1; stop += 0.1) {
                w = (watch){.stop_at = stop};
                check(calls[k].make(&run) == CW_ERROR_CANCELLED && w.wrong == 0, "%s goes on after %g", calls[k].name,
                      w.last);
            }
        }
    }
    cw_pool_destroy(pool);
}

static int set_up(void **state) {
    (void)state;
    random_state r = {9};
    field_make(&shape, FIELD_HOLES, NX, NY, 5);
    field = field_of(shape.z, NX, NY);
    for (size_t k = 0; k < RAYS; k++) {
        rays[k] = ray_make((ray_class)(k % RAY_CLASSES), &shape, &r);
        user_rays[k] = ray_for_user(&rays[k]);
    }
    check_status(cw_closest(field, NULL, rays, RAYS, found), CW_OK);
    return 0;
}

static int tear_down(void **state) {
    (void)state;
    cw_field_destroy(field);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(each_call_is_watched)};
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
