/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk trace`: hits of an array of rays. Rays are read, traced and written piece by piece, so that neither
 * rays nor hits need to fit into memory. */

#include "cellwalk_expert.h"
#include "clock.h"
#include "command.h"
#include "field_options.h"
#include "inputs.h"
#include "json.h"
#include "progress.h"
#include "trace_files.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* A piece is long enough that starting the threads costs nothing. */
enum { PIECE = 1 << 18, REPEAT_MOST = 1000000 };

typedef struct request {
    const char *field, *rays, *hits;
    field_options options;
    bool any, user, points, normals, stats, json, quiet;
    unsigned repeat;
} request;

typedef struct trace {
    request *request;
    raster_field field;
    ray_source rays;
    cw_run *query;  /* of the options */
    hits_file file; /* not open where no output was asked for */
    uint64_t hit_count;
    double *seconds; /* request->repeat of them */
} trace;

/* Of a piece; with --occluded the latter. */
static cw_hit found[PIECE];
static uint8_t occluded[PIECE];

/* Traces n rays into found or occluded and returns the time that it took. */
static bool trace_piece(trace *t, const void *rays, size_t n, double *seconds, io_error *error) {
    const cw_field *f = t->field.field;
    const bool any = t->request->any;
    const double start = clock_seconds();
    cw_status status;
    if (t->request->user)
        status = any ? cw_occluded_user(f, t->query, rays, n, occluded) : cw_closest_user(f, t->query, rays, n, found);
    else
        status = any ? cw_occluded(f, t->query, rays, n, occluded) : cw_closest(f, t->query, rays, n, found);
    *seconds = clock_seconds() - start;
    return status == CW_OK || io_fail(error, "%s", cw_last_error());
}

static uint64_t count_hits(const trace *t, size_t n) {
    uint64_t count = 0;
    for (size_t k = 0; k < n; k++) count += t->request->any ? occluded[k] : found[k].i >= 0;
    return count;
}

/* All rays once. The first pass counts and writes. */
static bool pass(trace *t, unsigned number, io_error *error) {
    for (uint64_t done = 0; done < t->rays.count;) {
        const size_t n = t->rays.count - done < PIECE ? (size_t)(t->rays.count - done) : PIECE;
        const void *rays = ray_source_rows(&t->rays, t->field.field, done, n, error);
        if (rays == NULL) return false;
        double seconds = 0;
        if (!trace_piece(t, rays, n, &seconds, error)) return false;
        t->seconds[number] += seconds;
        if (number == 0) t->hit_count += count_hits(t, n);
        if (number == 0 && t->request->hits &&
            !hits_file_write(&t->file, t->field.field, t->query, found, occluded, n, error))
            return false;
        done += n;
        progress_show("tracing", (number + (double)done / (double)t->rays.count) / t->request->repeat);
    }
    return true;
}

static bool prepare(trace *t, io_error *error) {
    const request *r = t->request;
    if (!ray_source_open(&t->rays, r->rays, r->user, error)) return false;
    if (!io_inputs_note_path(r->field)) return io_fail(error, "out of memory");
    if (r->hits && !hits_file_create(&t->file, r->hits, t->rays.count, error)) return false;
    const cw_status status = cw_pool_create(r->options.threads, &t->query->pool);
    if (status != CW_OK) return io_fail(error, "%s", cw_last_error());
    if (!field_options_open(&r->options, r->field, &t->field, error)) return false;
    if (r->user && t->field.raster.georef.geographic)
        command_warn("trace",
                     "%s: its map is in degrees, so rays are straight in degrees and heights; gdalwarp -t_srs EPSG:... "
                     "puts it on a map in metres",
                     r->field);
    t->query->expert.kernel = t->field.kernel;
    t->seconds = calloc(r->repeat, sizeof *t->seconds);
    return t->seconds || io_fail(error, "out of memory");
}

static int compare(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void report(trace *t) {
    const unsigned n = t->request->repeat;
    qsort(t->seconds, n, sizeof *t->seconds, compare);
    const double least = t->seconds[0], median = 0.5 * (t->seconds[(n - 1) / 2] + t->seconds[n / 2]);
    const double mrays = t->rays.count > 0 ? 1e-6 * (double)t->rays.count / median : 0;
    const char *kernel = cw_kernel_describe(t->query->expert.kernel).name;
    const unsigned threads = cw_pool_threads(t->query->pool);
    const unsigned long long rays = t->rays.count, hits = t->hit_count;
    if (!t->request->json) {
        printf("%s: %llu rays, %llu hits, %u thread%s, %u run%s: min %.6f s, median %.6f s, %.3f Mrays/s\n", kernel,
               rays, hits, threads, threads == 1 ? "" : "s", n, n == 1 ? "" : "s", least, median, mrays);
        return;
    }
    json_print(stdout,
               "{'kernel': %s, 'rays': %u, 'hits': %u, 'threads': %u, 'seconds_min': %g, 'seconds_median': %g, "
               "'mrays_per_s': %g}\n",
               kernel, (size_t)rays, (size_t)hits, (size_t)threads, least, median, mrays);
}

static bool trace_all(trace *t, io_error *error) {
    if (!prepare(t, error)) return false;
    bool good = true;
    for (unsigned k = 0; k < t->request->repeat && good; k++) good = pass(t, k, error);
    progress_end();
    return good && (t->request->hits == NULL || io_npy_commit(&t->file.writer, error));
}

/* Where the field's bounds are, in the coordinates that rays have. */
static void warn_of_bounds(const trace *t) {
    const cw_field_info f = cw_field_describe(t->field.field);
    const double side[3] = {(double)(f.nx - 1), (double)(f.ny - 1), 1};
    double low[3] = {0, 0, (double)f.low}, high[3] = {side[0], side[1], (double)f.high};
    for (int k = 0; k < 3 && t->request->user; k++) {
        const double *m = t->field.map[k];
        low[k] = high[k] = m[3];
        for (int a = 0; a < 3; a++) {
            const double from = m[a] * (a < 2 ? 0 : (double)f.low), to = m[a] * (a < 2 ? side[a] : (double)f.high);
            low[k] += fmin(from, to);
            high[k] += fmax(from, to);
        }
    }
    command_warn("trace", "no ray meets the field, which lies at x %.10g to %.10g, y %.10g to %.10g, z %.6g to %.6g%s",
                 low[0], high[0], low[1], high[1], low[2], high[2],
                 t->request->user                ? " of the map"
                 : t->field.raster.georef.placed ? "; if the rays are in coordinates of its map, --user takes them so"
                                                 : "");
}

static int run_request(request *r, bool timing) {
    trace t = {.request = r,
               .query = &r->options.query,
               .rays = {.npy = {.fd = -1}},
               .file = {.any = r->any, .points = r->points, .normals = r->normals}};
    io_error error = {""};
    const double start = clock_seconds();
    const bool good = trace_all(&t, &error);
    if (good && timing) report(&t);
    if (good)
        command_wrote("trace", r->quiet, r->hits, start, "%.3g %% of %llu rays hit",
                      t.rays.count > 0 ? 100 * (double)t.hit_count / (double)t.rays.count : 0,
                      (unsigned long long)t.rays.count);
    if (good && t.rays.count > 0 && t.hit_count == 0 && t.rays.none_meets) warn_of_bounds(&t);
    io_npy_discard(&t.file.writer);
    ray_source_close(&t.rays);
    cw_pool_destroy(t.query->pool);
    raster_field_close(&t.field);
    free(t.seconds);
    return good ? EXIT_SUCCESS : command_fail("trace", "%s", error.text);
}

static const char what[] =
    "Finds where rays hit a height field and writes one hit a ray as a NumPy array.\n\n" FIELD_FILE_HELP
    "\nRAYS is a NumPy array (.npy) of float32 with the shape (N, 8): origin x, y, z, tmin, direction x, y, z, tmax, "
    "in field space: org + t dir for t in [tmin, tmax]. With --user it is float64, in the coordinates of the field's "
    "map.\n\n"
    "HITS becomes a NumPy array of N records with the fields t (float32), i, j (int32: the cell), triangle (uint32: 0 "
    "below the diagonal, 1 above), u, v (float32: barycentric). A miss has t = inf, i = j = -1 and 0 elsewhere. With "
    "--occluded it is N numbers of one byte (uint8): 1 where the ray hits anything, else 0.\n\n"
    "Rays and hits need not fit into memory. HITS is renamed into place when complete. The name - is standard output, "
    "and for RAYS standard input, redirected from a file.\n\n" FIELD_TRADE "\n";

static const char examples[] = "  cellwalk trace terrain.npy rays.npy -o hits.npy\n"
                               "  cellwalk trace dem.tif lidar.npy --user --points -o hits.npy --stats\n"
                               "  cellwalk trace dem.asc sun.npy -o shadow.npy --occluded --threads 4\n"
                               "  cellwalk trace terrain.npy rays.npy --threads 1 --repeat 9 --json\n"
                               "\n"
                               "In Python:\n"
                               "  rays = numpy.zeros((1000, 8), 'float32')      # origin, tmin, direction, tmax\n"
                               "  numpy.save('rays.npy', rays)\n"
                               "  hits = numpy.load('hits.npy'); depth = hits['t']; missed = hits['i'] < 0\n";

/* Options that exclude each other. */
static bool check(const request *r, bool timing) {
    const bool to_stdout = r->hits && strcmp(r->hits, "-") == 0;
    if (r->hits == NULL && !timing)
        return command_refuse("trace", "nothing to do: give -o HITS.npy for the hits, or --stats, --repeat or --json");
    if (r->any && (r->points || r->normals))
        return command_refuse("trace", "--occluded finds no hits, so --points and --normals cannot be given");
    if (to_stdout && timing)
        return command_refuse("trace",
                              "standard output cannot take both the hits and the text of --stats, --repeat or --json");
    if (to_stdout && isatty(STDOUT_FILENO))
        return command_refuse("trace", "standard output is a terminal, and hits are no text: give -o HITS.npy");
    return true;
}

static int run(int argc, char **argv) {
    static request r; /* large */
    const option_spec options[] = {
        option_output("HITS.npy", &r.hits, "the array of hits to write; - is standard output"),
        option_flag("occluded", &r.any, "only find whether a ray hits anything: one byte a ray"),
        option_flag("user", &r.user, "RAYS is float64, in the coordinates of the field's map"),
        option_flag("points", &r.points,
                    "also write the hits' places on the map, on the surface to rounding: x, y, z (float64)"),
        option_flag("normals", &r.normals,
                    "also write the triangles' unit normals, in the map's coordinates: nx, ny, nz (float32)"),
        option_flag("stats", &r.stats, "print counts of rays and hits, and the seconds of the queries alone"),
        option_count("repeat", "N", &r.repeat, 1, REPEAT_MOST,
                     "trace N times and print the seconds of the queries alone; -o is then optional"),
        option_flag("json", &r.json,
                    "print one JSON object: kernel, rays, hits, threads, seconds_min, seconds_median, mrays_per_s (by "
                    "the median); -o is then optional"),
        option_flag("quiet", &r.quiet, "leave out the line at the end"),
    };
    static const char *const operand_names[] = {"FIELD", "RAYS.npy"};
    const options_usage usage = {.name = "trace",
                                 .synopsis = "FIELD RAYS.npy -o HITS.npy [OPTIONS]",
                                 .what = what,
                                 .examples = examples,
                                 .options = options,
                                 .option_count = sizeof options / sizeof *options,
                                 .operands = operand_names,
                                 .operand_least = 2,
                                 .operand_most = 2};
    const char *operands[2];
    const int status = field_options_parse(&r.options, &usage, FIELD_KERNELS, argc, argv, operands);
    if (status != OPTIONS_GO) return status;
    r.field = operands[0];
    r.rays = operands[1];
    const bool timing = r.repeat > 0 || r.json || r.stats;
    if (!check(&r, timing)) return EXIT_USAGE;
    if (r.repeat == 0) r.repeat = 1;
    return run_request(&r, timing);
}

const command command_trace = {"trace", "find where rays hit a height field (NumPy arrays in and out)", run};
