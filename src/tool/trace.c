/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk trace`: hits of an array of rays. Rays are mapped, traced and written piece by piece, so that neither rays nor
 * hits need to fit into memory. */

#include "cancel.h"
#include "cellwalk.h"
#include "clock.h"
#include "command.h"
#include "field_file.h"
#include "hits_file.h"
#include "json.h"
#include "npy.h"
#include "progress.h"
#include "query_options.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

_Static_assert(sizeof(cw_ray) == 8 * sizeof(float), "a row of eight floats is a ray");

/* A piece is long enough that starting the threads costs nothing, and short enough to stop soon after Ctrl-C. */
enum { PIECE = 1 << 18, PIECE_LEAST = 1 << 12, REPEAT_MOST = 1000000 };

typedef struct request {
    const char *field, *rays, *hits;
    query_options query;
    bool any, json;
    unsigned repeat;
    float tolerance, cone;
} request;

typedef struct trace {
    const request *request;
    field_file field;
    io_npy rays;
    uint64_t ray_count;
    cw_query query;
    io_npy_writer writer; /* not open where no output was asked for */
    size_t piece;
    cw_hit *hits;      /* PIECE of them */
    uint8_t *occluded; /* PIECE of them, for --any */
    progress line;
    uint64_t hit_count;
    double *seconds; /* request->repeat of them */
} trace;

/* Pages of a mapped file come into memory when they are touched; that is no part of a query's time. */
static void touch(const void *memory, size_t bytes) {
    enum { PAGE = 4096 }; /* the smallest there is */
    const volatile char *at = memory;
    for (size_t k = 0; k < bytes; k += PAGE) (void)at[k];
}

/* Traces n rays into t->hits and returns the time that it took. */
static bool trace_piece(trace *t, const cw_ray *rays, size_t n, double *seconds, io_error *error) {
    const double start = clock_seconds();
    const cw_status status = t->request->any ? cw_any(t->field.field, &t->query, rays, n, t->occluded)
                                             : cw_closest(t->field.field, &t->query, rays, n, t->hits);
    *seconds = clock_seconds() - start;
    if (status != CW_OK) return io_fail(error, "%s", cw_status_message(status));
    if (!t->request->any) return true;
    for (size_t k = 0; k < n; k++)
        t->hits[k] = (cw_hit){.t = t->occluded[k] ? rays[k].tmin : INFINITY, .i = -1, .j = -1};
    return true;
}

static uint64_t count_hits(const trace *t, size_t n) {
    uint64_t count = 0;
    for (size_t k = 0; k < n; k++) count += t->request->any ? t->occluded[k] : t->hits[k].i >= 0;
    return count;
}

/* All rays once. The first pass counts and writes. */
static bool pass(trace *t, unsigned number, io_error *error) {
    for (uint64_t done = 0; done < t->ray_count;) {
        if (atomic_load(cancel_flag())) return io_fail(error, "interrupted");
        const size_t n = t->ray_count - done < t->piece ? (size_t)(t->ray_count - done) : t->piece;
        const cw_ray *rays = io_npy_rows(&t->rays, done, n, error);
        if (rays == NULL) return false;
        touch(rays, n * sizeof *rays);
        double seconds = 0;
        if (!trace_piece(t, rays, n, &seconds, error)) return false;
        t->seconds[number] += seconds;
        if (number == 0) t->hit_count += count_hits(t, n);
        if (number == 0 && t->request->hits && !hits_file_write(&t->writer, t->hits, n, error)) return false;
        if (seconds > 1 && t->piece > PIECE_LEAST) t->piece /= 2;
        done += n;
        progress_update(&t->line, (number + (double)done / (double)t->ray_count) / t->request->repeat);
    }
    return true;
}

static bool open_rays(trace *t, io_error *error) {
    static const char *const float32[] = {"<f4"};
    if (!io_npy_open(&t->rays, t->request->rays, error)) return false;
    if (!io_npy_expect_type(&t->rays, float32, 1, error)) return false;
    const io_npy_header *h = &t->rays.header;
    char shape[128];
    io_npy_shape_text(&t->rays, shape, sizeof shape);
    if (h->rank != 2 || h->shape[1] != 8)
        return io_fail(error, "%s: shape %s, but rays are (N, 8): org x y z, tmin, dir x y z, tmax", t->rays.path,
                       shape);
    t->ray_count = h->shape[0];
    return true;
}

static bool prepare(trace *t, io_error *error) {
    const request *r = t->request;
    if (!open_rays(t, error)) return false;
    if (r->hits && !hits_file_create(&t->writer, r->hits, t->ray_count, error)) return false;
    if (!field_file_open(&t->field, r->field, NULL, &t->query, error)) return false;
    t->query.kernel = t->field.kernel;
    const cw_status status = cw_pool_create(r->query.threads, &t->query.pool);
    if (status != CW_OK) return io_fail(error, "%s", cw_status_message(status));
    t->hits = calloc(PIECE, sizeof *t->hits);
    t->occluded = r->any ? calloc(PIECE, sizeof *t->occluded) : NULL;
    t->seconds = calloc(r->repeat, sizeof *t->seconds);
    return (t->hits && t->seconds && (t->occluded || !r->any)) || io_fail(error, "out of memory");
}

static int compare(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void report(trace *t) {
    const unsigned n = t->request->repeat;
    qsort(t->seconds, n, sizeof *t->seconds, compare);
    const double least = t->seconds[0], median = 0.5 * (t->seconds[(n - 1) / 2] + t->seconds[n / 2]);
    const double mrays = t->ray_count > 0 ? 1e-6 * (double)t->ray_count / median : 0;
    const char *kernel = cw_kernel_describe(t->query.kernel).name;
    const unsigned threads = cw_pool_threads(t->query.pool);
    const unsigned long long rays = t->ray_count, hits = t->hit_count;
    if (!t->request->json) {
        printf("%s: %llu rays, %llu hits, %u thread%s, %u run%s: min %.6f s, median %.6f s, %.3f Mrays/s\n", kernel,
               rays, hits, threads, threads == 1 ? "" : "s", n, n == 1 ? "" : "s", least, median, mrays);
        return;
    }
    fputs("{\"kernel\": ", stdout);
    json_string(stdout, kernel);
    printf(", \"rays\": %llu, \"hits\": %llu, \"threads\": %u, \"seconds_min\": ", rays, hits, threads);
    json_number(stdout, least);
    fputs(", \"seconds_median\": ", stdout);
    json_number(stdout, median);
    fputs(", \"mrays_per_s\": ", stdout);
    json_number(stdout, mrays);
    puts("}");
}

static bool trace_all(trace *t, io_error *error) {
    if (!prepare(t, error)) return false;
    t->line = progress_start("tracing");
    bool good = true;
    for (unsigned k = 0; k < t->request->repeat && good; k++) good = pass(t, k, error);
    progress_end(&t->line);
    return good && (t->request->hits == NULL || io_npy_commit(&t->writer, error));
}

static int run_request(const request *r, const cw_query *query, bool timing) {
    trace t = {.request = r, .query = *query, .piece = PIECE, .rays = {.fd = -1}};
    io_error error = {""};
    const bool good = trace_all(&t, &error);
    if (good && timing) report(&t);
    io_npy_discard(&t.writer);
    io_npy_close(&t.rays);
    cw_pool_destroy(t.query.pool);
    field_file_close(&t.field);
    free(t.hits);
    free(t.occluded);
    free(t.seconds);
    return good ? EXIT_SUCCESS : command_fail("trace", "%s", error.text);
}

static const char what[] = "Finds where rays hit a height field.\n"
                           "\n" FIELD_FILE_HELP "\n"
                           "RAYS is a NumPy array (.npy) of float32 with the shape (N, 8): origin x, y, z,\n"
                           "tmin, direction x, y, z, tmax, in field space: org + t dir for t in [tmin, tmax].\n"
                           "\n"
                           "HITS becomes a NumPy array of N records with the fields t (float32), i, j (int32:\n"
                           "the cell), triangle (uint8: 0 below the diagonal, 1 above), u, v (float32:\n"
                           "barycentric). A miss has t = inf, i = j = -1 and 0 elsewhere.\n"
                           "\n"
                           "Rays and hits need not fit into memory. HITS appears under its name only when it\n"
                           "is whole.\n";

static const char examples[] = "  cellwalk trace terrain.npy rays.npy -o hits.npy\n"
                               "  cellwalk trace dem.asc sun.npy -o shadow.npy --any --threads 4\n"
                               "  cellwalk trace terrain.npy rays.npy --kernel packet8 --threads 1 --repeat 9 --json\n"
                               "  cellwalk trace terrain.npy view.npy -o hits.npy --cone 0.001\n"
                               "\n"
                               "In Python:\n"
                               "  rays = numpy.zeros((1000, 8), 'float32')      # origin, tmin, direction, tmax\n"
                               "  numpy.save('rays.npy', rays)\n"
                               "  hits = numpy.load('hits.npy'); depth = hits['t']; missed = hits['i'] < 0\n";

static int run(int argc, char **argv) {
    request r = {.repeat = 0};
    enum { OWN = 6, ALL = OWN + QUERY_OPTION_COUNT };
    option_spec options[ALL] = {
        {.name = "output",
         .letter = 'o',
         .value = "HITS.npy",
         .help = "where the hits go",
         .kind = OPTION_TEXT,
         .to = &r.hits},
        {.name = "any",
         .help = "only ask whether a ray hits anything: an occluded ray\nhas t = its tmin, all else as in a miss",
         .to = &r.any},
        {.name = "repeat",
         .value = "N",
         .help = "trace N times and print the time of the queries\nalone; -o may then be left out",
         .kind = OPTION_COUNT,
         .to = &r.repeat,
         .low = 1,
         .high = REPEAT_MOST},
        {.name = "json",
         .help = "print one JSON object: kernel, rays, hits, threads,\nseconds_min, seconds_median, mrays_per_s\n"
                 "(by the median); -o may then be left out",
         .to = &r.json},
        {.name = "tolerance",
         .value = "H",
         .help =
             "hits may lie off the surface by this height, and a ray\nthat passes as near may hit (default: 0, exact)",
         .kind = OPTION_REAL,
         .to = &r.tolerance},
        {.name = "cone",
         .value = "A",
         .help = "the same, by A more for each unit of distance: a pixel's\nwidth at distance 1",
         .kind = OPTION_REAL,
         .to = &r.cone},
    };
    query_options_rows(&r.query, options + OWN);
    static const char *const operand_names[] = {"FIELD", "RAYS.npy"};
    const options_usage usage = {.name = "trace",
                                 .synopsis = "FIELD RAYS.npy -o HITS.npy [OPTIONS]",
                                 .what = what,
                                 .examples = examples,
                                 .options = options,
                                 .option_count = ALL,
                                 .operands = operand_names,
                                 .operand_least = 2,
                                 .operand_most = 2};
    const char *operands[2];
    const options_result result = options_parse(&usage, argc, argv, operands);
    if (result != OPTIONS_GO) return result == OPTIONS_HELP ? EXIT_SUCCESS : EXIT_USAGE;
    r.field = operands[0];
    r.rays = operands[1];
    const bool timing = r.repeat > 0 || r.json;
    if (r.hits == NULL && !timing) {
        command_fail(usage.name, "nothing to do: give -o HITS.npy for the hits, or --repeat or --json for the time");
        return EXIT_USAGE;
    }
    if (r.repeat == 0) r.repeat = 1;
    cw_query query;
    if (!query_options_resolve(&r.query, usage.name, &query)) return EXIT_USAGE;
    query.tolerance = r.tolerance;
    query.cone = r.cone;
    return run_request(&r, &query, timing);
}

const command command_trace = {"trace", "find where rays hit a height field (NumPy arrays in and out)", run};
