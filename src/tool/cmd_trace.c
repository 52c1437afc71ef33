/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk trace`: hits of an array of rays. Both are NumPy arrays, read, traced and written piece by piece, so that
 * neither needs to fit into memory. */

#include "cellwalk_expert.h"
#include "clock.h"
#include "command.h"
#include "field_options.h"
#include "inputs.h"
#include "json.h"
#include "npy.h"
#include "raster_out.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

_Static_assert(sizeof(cw_ray) == 8 * sizeof(float), "a row of eight floats is a ray");
_Static_assert(sizeof(cw_user_ray) == 8 * sizeof(double), "a row of eight doubles is a ray in user space");

/* A piece is long enough that starting the threads costs nothing. */
enum { PIECE = 1 << 18, HIT = 24, POINT = 24, NORMAL = 12, AT_ONCE = 1 << 14 };
_Static_assert(sizeof(cw_hit) == HIT, "a hit is a record");

typedef struct trace {
    const char *path, *hits; /* of the field; NULL: hits are not written */
    field_options options;
    bool any, user, points, normals, json, quiet;
    raster_field field;
    io_npy rays;
    io_output output;
    cw_run *query; /* of the options */
    uint64_t count, hit_count;
    double seconds; /* of the queries alone */
} trace;

/* Answers of a piece: the first, or with --occluded the second. */
static cw_hit found[PIECE];
static uint8_t occluded[PIECE];

/* Points and normals of some hits, and the records with them. */
static struct {
    double point[AT_ONCE][3], normal[AT_ONCE][3];
    unsigned char records[AT_ONCE * (HIT + POINT + NORMAL)];
} extras;

static bool open_rays(trace *t, const char *path, io_error *error) {
    static const char *const float32[] = {"<f4"}, *const float64[] = {"<f8"};
    const io_npy_header *h = &t->rays.header;
    char shape[128];
    if (!io_npy_open(&t->rays, strcmp(path, "-") == 0 ? "/dev/stdin" : path, error) ||
        !io_npy_expect_type(&t->rays, t->user ? float64 : float32, 1, error))
        return false;
    io_npy_shape_text(h->rank, h->shape, shape, sizeof shape);
    if (h->rank != 2 || h->shape[1] != 8)
        return io_fail(error, "%s: shape %s, but rays are (N, 8): org x y z, tmin, dir x y z, tmax", t->rays.path,
                       shape);
    t->count = h->shape[0];
    return true;
}

static bool create_hits(trace *t, io_error *error) {
    char type[256] = "'|u1'";
    size_t record = t->any ? 1 : HIT;
    if (!t->any)
        snprintf(type, sizeof type,
                 "[('t', '<f4'), ('i', '<i4'), ('j', '<i4'), ('triangle', '<u4'), ('u', '<f4'), ('v', '<f4')%s%s]",
                 t->points ? ", ('x', '<f8'), ('y', '<f8'), ('z', '<f8')" : "",
                 t->normals ? ", ('nx', '<f4'), ('ny', '<f4'), ('nz', '<f4')" : "");
    if (t->points) record += POINT;
    if (t->normals) record += NORMAL;
    return io_output_open(&t->output, t->hits, error) &&
           io_npy_write_header(&t->output, type, record, 1, &t->count, error);
}

static bool write_extras(trace *t, const cw_hit *hits, size_t n, io_error *error) {
    unsigned char *to = extras.records;
    cw_status status = CW_OK;
    if (t->points) status = cw_hit_points(t->field.field, t->query, hits, n, extras.point[0]);
    if (status == CW_OK && t->normals) status = cw_hit_normals(t->field.field, t->query, hits, n, extras.normal[0]);
    if (status != CW_OK) return io_fail(error, "%s", cw_last_error());
    for (size_t k = 0; k < n; k++) {
        const double *normal = extras.normal[k];
        const float rounded[3] = {(float)normal[0], (float)normal[1], (float)normal[2]};
        memcpy(to, &hits[k], HIT);
        to += HIT;
        if (t->points) memcpy(to, extras.point[k], POINT);
        to += t->points ? POINT : 0;
        if (t->normals) memcpy(to, rounded, NORMAL);
        to += t->normals ? NORMAL : 0;
    }
    return io_output_write(&t->output, extras.records, (size_t)(to - extras.records), error);
}

static bool write_piece(trace *t, size_t n, io_error *error) {
    if (t->any) return io_output_write(&t->output, occluded, n, error);
    if (!t->points && !t->normals) return io_output_write(&t->output, found, n * HIT, error);
    bool good = true;
    for (size_t done = 0; done < n && good; done += AT_ONCE)
        good = write_extras(t, found + done, n - done < AT_ONCE ? n - done : AT_ONCE, error);
    return good;
}

static bool trace_piece(trace *t, uint64_t first, size_t n, io_error *error) {
    const cw_field *f = t->field.field;
    const void *rays = io_npy_rows(&t->rays, first, n, error);
    if (rays == NULL) return false;
    const double start = clock_seconds();
    const cw_status status = t->user  ? t->any ? cw_occluded_user(f, t->query, rays, n, occluded)
                                               : cw_closest_user(f, t->query, rays, n, found)
                              : t->any ? cw_occluded(f, t->query, rays, n, occluded)
                                      : cw_closest(f, t->query, rays, n, found);
    t->seconds += clock_seconds() - start;
    if (status != CW_OK) return io_fail(error, "%s", cw_last_error());
    for (size_t k = 0; k < n; k++) t->hit_count += t->any ? occluded[k] : found[k].i >= 0;
    return t->hits == NULL || write_piece(t, n, error);
}

static bool prepare(trace *t, const char *rays, io_error *error) {
    if (!open_rays(t, rays, error)) return false;
    if (!io_inputs_note_path(t->path)) return io_fail(error, "out of memory");
    if (t->hits && !create_hits(t, error)) return false;
    const cw_status status = cw_pool_create(t->options.threads, &t->query->pool);
    if (status != CW_OK) return io_fail(error, "%s", cw_last_error());
    const field_options *f = &t->options;
    if (!raster_field_open(&t->field, t->path, &f->reading, &f->coarser, &f->query, &f->watch, error)) return false;
    if (t->user && t->field.raster.georef.geographic)
        command_warn("trace", "%s: rays are straight in degrees, which its map is in; gdalwarp -t_srs makes metres",
                     t->path);
    t->query->expert.kernel = cw_run_kernel(t->field.field, t->query);
    return true;
}

static bool trace_all(trace *t, const char *rays, io_error *error) {
    bool good = prepare(t, rays, error);
    for (uint64_t done = 0; good && done < t->count; done += PIECE) {
        good = trace_piece(t, done, t->count - done < PIECE ? (size_t)(t->count - done) : PIECE, error);
        progress_show("tracing", fmin(1, (double)(done + PIECE) / (double)t->count));
    }
    progress_end();
    return good && (t->hits == NULL || io_output_commit(&t->output, error));
}

/* Where the field's bounds are, in the coordinates that rays have; unless all samples are holes. */
static void warn_of_bounds(const trace *t) {
    const cw_field_info f = cw_field_describe(t->field.field);
    const double side[3] = {(double)(f.nx - 1), (double)(f.ny - 1), 1};
    if (!(f.low <= f.high)) return;
    double low[3] = {0, 0, (double)f.low}, high[3] = {side[0], side[1], (double)f.high};
    for (int k = 0; k < 3 && t->user; k++) {
        const double *m = t->field.raster.map[k];
        low[k] = high[k] = m[3];
        for (int a = 0; a < 3; a++) {
            const double from = m[a] * (a < 2 ? 0 : (double)f.low), to = m[a] * (a < 2 ? side[a] : (double)f.high);
            low[k] += fmin(from, to);
            high[k] += fmax(from, to);
        }
    }
    command_warn("trace", "no ray hits the field, which lies at x %.10g to %.10g, y %.10g to %.10g, z %.6g to %.6g%s",
                 low[0], high[0], low[1], high[1], low[2], high[2],
                 t->user                         ? " of the map"
                 : t->field.raster.georef.placed ? "; if the rays are in coordinates of its map, --user takes them so"
                                                 : "");
}

static int run_request(trace *t, const char *rays) {
    io_error error = {""};
    const double start = clock_seconds();
    const bool good = trace_all(t, rays, &error);
    if (good && t->json)
        json_print(stdout, "{'kernel': %s, 'rays': %u, 'hits': %u, 'threads': %u, 'seconds': %g, 'mrays_per_s': %g}\n",
                   cw_kernel_describe(t->query->expert.kernel).name, (size_t)t->count, (size_t)t->hit_count,
                   (size_t)cw_pool_threads(t->query->pool), t->seconds,
                   t->count > 0 ? 1e-6 * (double)t->count / t->seconds : 0);
    if (good)
        command_wrote("trace", t->quiet, t->hits, start, "%.3g %% of %llu rays hit",
                      t->count > 0 ? 100 * (double)t->hit_count / (double)t->count : 0, (unsigned long long)t->count);
    if (good && !t->quiet && !t->any && t->count > 0 && t->hit_count == 0) warn_of_bounds(t);
    io_output_discard(&t->output);
    io_npy_close(&t->rays);
    cw_pool_destroy(t->query->pool);
    raster_field_close(&t->field);
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
                               "  cellwalk trace dem.tif lidar.npy --user --points -o hits.npy\n"
                               "  cellwalk trace dem.asc sun.npy -o shadow.npy --occluded --threads 4\n"
                               "  cellwalk trace terrain.npy rays.npy --threads 1 --json\n"
                               "\n"
                               "In Python:\n"
                               "  rays = numpy.zeros((1000, 8), 'float32')      # origin, tmin, direction, tmax\n"
                               "  numpy.save('rays.npy', rays)\n"
                               "  hits = numpy.load('hits.npy'); depth = hits['t']; missed = hits['i'] < 0\n";

static bool check(const trace *t) {
    const bool to_stdout = t->hits && io_output_descriptor(t->hits) == STDOUT_FILENO;
    if (t->hits == NULL && (!t->json || t->points || t->normals))
        return command_refuse("trace", t->json ? "--points and --normals go into HITS.npy: give -o HITS.npy"
                                               : "nothing to do: give -o HITS.npy for the hits, or --json");
    if (t->any && (t->points || t->normals))
        return command_refuse("trace", "--occluded finds no hits, so --points and --normals cannot be given");
    if (to_stdout && t->json)
        return command_refuse("trace", "standard output cannot take both the hits and the text of --json");
    if (to_stdout && isatty(STDOUT_FILENO))
        return command_refuse("trace", "standard output is a terminal, and hits are no text: give -o HITS.npy");
    if (t->hits && io_raster_is_name(t->hits) && !io_name_ends(t->hits, ".npy"))
        return command_refuse("trace", "%s: is a raster's name, and hits are a NumPy array; give -o HITS.npy", t->hits);
    return true;
}

static int run(int argc, char **argv) {
    static trace t = {.rays = {.fd = -1}}; /* large */
    const option_spec options[] = {
        option_output("HITS.npy", &t.hits, "the array of hits to write; - is standard output"),
        option_flag("occluded", &t.any, "only find whether a ray hits anything: one byte a ray"),
        option_flag("user", &t.user, "RAYS is float64, in the coordinates of the field's map"),
        option_flag("points", &t.points,
                    "also write the hits' places on the map, on the surface to rounding: x, y, z (float64)"),
        option_flag("normals", &t.normals,
                    "also write the triangles' unit normals, in the map's coordinates: nx, ny, nz (float32)"),
        option_flag("json", &t.json,
                    "print one JSON object: kernel, rays, hits, threads, seconds of the queries alone, mrays_per_s; -o "
                    "is then optional"),
        option_flag("quiet", &t.quiet, "leave out the line at the end, and the warning if no ray hits"),
    };
    static const char *const operand_names[] = {"FIELD", "RAYS.npy"};
    const options_usage usage = {.name = "trace",
                                 .synopsis = "FIELD RAYS.npy -o HITS.npy [OPTIONS]",
                                 .what = what,
                                 .examples = examples,
                                 OPTIONS_OF(options),
                                 .operands = operand_names,
                                 .operand_least = 2,
                                 .operand_most = 2};
    const char *operands[2];
    t.query = &t.options.query;
    const int status = field_options_parse(&t.options, &usage, FIELD_LEAVES, argc, argv, operands);
    if (status != OPTIONS_GO) return status;
    t.path = operands[0];
    return check(&t) ? run_request(&t, operands[1]) : EXIT_USAGE;
}

const command command_trace = {"trace", "find where rays hit a height field (NumPy arrays in and out)", run};
