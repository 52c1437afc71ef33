/* SPDX-License-Identifier: Apache-2.0 */
/* src/io as a program for the tests in Python (words.h). */

#include "image.h"
#include "inputs.h"
#include "npy.h"
#include "raster.h"
#include "raster_out.h"
#include "table.h"
#include "words.h"

#include <errno.h>
#include <fcntl.h>
#include <grp.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>

static bool sync_fails;

/* In place of libc's: what is done to an output, in its order. */
static char events[400];
static void note(const char *what) { strncat(events, what, sizeof events - strlen(events) - 1); }

int fsync(int fd) {
    note("fsync ");
    if (sync_fails) errno = EIO;
    return sync_fails ? -1 : fdatasync(fd);
}

int rename(const char *from, const char *to) {
    note("rename ");
    return renameat(AT_FDCWD, from, AT_FDCWD, to);
}

int fchmod(int fd, mode_t mode) {
    struct stat now;
    if (fstat(fd, &now) == 0 && (now.st_mode & 077) != 0) note("open-to-others ");
    return (int)syscall(SYS_fchmod, fd, mode);
}

/* ---- outputs ----------------------------------------------------------------------------------------------------- */

static io_output outputs[IO_OUTPUT_MAX + 1];

/* A command in a forked child, which then ends. */
static int obey(char **w, io_error *e);
static bool obeys_in_child(char **w, io_error *e) {
    const pid_t child = fork();
    if (child == 0) exit(obey(w, e) == DONE ? EXIT_SUCCESS : EXIT_FAILURE); /* NOLINT: what is done at exit counts */
    int status;
    return (waitpid(child, &status, 0) == child && status == 0) || io_fail(e, "status %d", status);
}

static bool becomes(unsigned user, io_error *e) {
    user_changed = true;
    return (setgroups(0, NULL) == 0 && setgid(user) == 0 && setuid(user) == 0) || io_fail(e, "%s", strerror(errno));
}

static int obey_output(const char *c, char **w, io_error *e) {
    const size_t k = w[1] ? whole(w[1]) : 0;
    io_output *out = &outputs[k <= IO_OUTPUT_MAX ? k : 0];
    size_t size;
    if (strcmp(c, "open") == 0) return io_output_open(out, w[2], e);
    if (strcmp(c, "write") == 0) return io_output_write(out, w[2], strlen(w[2]), e);
    if (strcmp(c, "flush") == 0) return fflush(out->file) == 0;
    if (strcmp(c, "settle") == 0) return io_output_settle(out, e);
    if (strcmp(c, "commit") == 0) return io_output_commit(out, e);
    if (strcmp(c, "discard") == 0) return io_output_discard(out), DONE;
    if (strcmp(c, "discard all") == 0) return io_output_discard_all(), DONE;
    if (strcmp(c, "protect inputs") == 0) return io_inputs_protect(), DONE;
    if (strcmp(c, "in child") == 0) return obeys_in_child(w + 1, e);
    if (strcmp(c, "become") == 0) return becomes((unsigned)k, e);
    if (strcmp(c, "break fsync") == 0) return sync_fails = k != 0, DONE;
    if (strcmp(c, "events") == 0) return fputs(events, answer), events[0] = '\0', DONE;
    if (strcmp(c, "message") == 0) return io_fail(e, "%s", w[1]);
    if (strcmp(c, "read") != 0) return OTHER;
    char *text = io_file_read(w[1], &size, e);
    if (text) fputs(text, answer);
    free(text);
    return text != NULL;
}

/* ---- arrays, tables, pictures ------------------------------------------------------------------------------------ */

static io_npy npy = {.fd = -1}; /* open or not, to be closed */

static bool opens_npy(const char *name, io_error *e) {
    char shape[200];
    io_npy_close(&npy);
    if (!io_npy_open(&npy, name, e)) return false;
    io_npy_shape_text(npy.header.rank, npy.header.shape, shape, sizeof shape);
    fprintf(answer, "%s %zu %s", npy.header.type, (size_t)npy.offset, shape);
    return true;
}

/* The answer is where they are, in bytes of an element. */
static bool shows_rows(size_t first, size_t count, io_error *e) {
    const void *rows = io_npy_rows(&npy, first, count, e);
    if (rows == NULL) return false;
    save("rows", rows, count * (size_t)npy.row_bytes);
    fprintf(answer, "%zu", (uintptr_t)rows % npy.header.item);
    return true;
}

/* Each cell is followed by U+001F, and behind the names each row begins with U+001E and its line. number: of the first
 * cell; columns: that many of x, z, note and y, of which so many are needed. */
static bool reads_table(const char *c, char **w, io_error *e) {
    static const char *const names[] = {"x", "z", "note", "y"};
    io_table t;
    if (!io_table_read(w[1], &t, e)) return false;
    bool good = true;
    double value = 0;
    size_t columns[4] = {0};
    if (strcmp(c, "number") == 0) {
        good = io_table_number(&t, 0, 0, &value, e);
        save("number", &value, sizeof value);
    } else if (strcmp(c, "columns") == 0) {
        good = io_table_columns(&t, names, whole(w[2]), whole(w[3]), columns, &(io_warner){warn, NULL}, e);
        for (size_t k = 0; k < whole(w[2]); k++) fprintf(answer, "%zu ", columns[k]);
    } else {
        for (size_t k = 0; k < t.columns; k++) fprintf(answer, "%s\x1f", t.names[k]);
        for (size_t k = 0; k < t.rows * t.columns; k++) {
            if (k % t.columns == 0) fprintf(answer, "\x1e%zu\x1f", t.lines[k / t.columns]);
            fprintf(answer, "%s\x1f", t.cells[k]);
        }
    }
    io_table_free(&t);
    return good;
}

/* Its pixels go into the file halves. */
static bool reads_image(const char *name, io_error *e) {
    io_image image;
    const bool good = io_image_read(name, IO_IMAGE_PIXELS_MAX, &image, e);
    stop_unless(good || image.halves == NULL, "pixels are left");
    if (!good) return false;
    FILE *file = fopen("halves", "wb");
    stop_unless(file != NULL, "halves");
    for (size_t y = 0; y < image.height; y++)
        fwrite(image.halves + ((image.width + 2) * y + 1) * 4, 8, image.width, file);
    stop_unless(fclose(file) == 0, "halves");
    fprintf(answer, "%zu %zu", image.width, image.height);
    io_image_free(&image);
    return true;
}

static bool writes_image(char **w, io_error *e) {
    size_t size;
    char *rgb = load("rgb", &size);
    const io_image image = {.width = whole(w[2]), .height = whole(w[3]), .rgb = (float *)(void *)rgb};
    const bool good = io_image_can_write(w[1], e) && io_output_open(&outputs[0], w[1], e) &&
                      io_image_put(&outputs[0], &image, e) && io_output_commit(&outputs[0], e);
    io_output_discard(&outputs[0]);
    free(rgb);
    return good;
}

static int obey_file(const char *c, char **w, io_error *e) {
    if (strcmp(c, "npy") == 0) return opens_npy(w[1], e);
    if (strcmp(c, "rows") == 0) return shows_rows(whole(w[1]), whole(w[2]), e);
    if (strcmp(c, "types") == 0) return io_npy_expect_type(&npy, (const char *const *)w + 1, 2, e);
    if (strcmp(c, "npy create") == 0)
        return io_output_open(&outputs[0], w[1], e) &&
               io_npy_write_header(&outputs[0], "'<f4'", 4, 1, &(uint64_t){whole(w[2])}, e);
    if (strcmp(c, "table") == 0 || strcmp(c, "number") == 0 || strcmp(c, "columns") == 0) return reads_table(c, w, e);
    if (strcmp(c, "image") == 0) return reads_image(w[1], e);
    return strcmp(c, "image write") == 0 ? writes_image(w, e) : OTHER;
}

/* ---- rasters ----------------------------------------------------------------------------------------------------- */

static io_raster raster;

static void tell(const io_georef *g) {
    const double numbers[] = {g->unit, g->height_unit, g->semi_major, g->inverse_flattening, g->nodata};
    char name[64];
    io_georef_name(g, name, sizeof name);
    save("georef", numbers, sizeof numbers);
    fprintf(answer, "name=%s\nplaced=%d\ngeographic=%d\nhas_nodata=%d\n", name, g->placed, g->geographic,
            g->has_nodata);
}

static bool reads_system(const char *text, io_error *e) {
    io_georef g = {0};
    const bool good = io_georef_from_wkt(&g, text) || io_fail(e, "no system");
    tell(&g);
    io_georef_free(&g);
    return good;
}

static bool goes_on(void *context, double share) {
    ++*(int *)context;
    return share < 0.5;
}

/* The file options has nodata twice, cellsize and zscale. What is found goes to files, too. */
static bool reads_raster(const char *name, const char *words, io_error *e) {
    size_t size;
    int calls = 0;
    double *numbers = load("options", &size);
    const io_raster_options options = {.band = (unsigned)option(words, "band="),
                                       .nodata = numbers,
                                       .nodata_count = option(words, "nodata="),
                                       .cellsize = numbers[2],
                                       .zscale = numbers[3],
                                       .north_up = option(words, "north_up=") != 0,
                                       .warn = {warn, NULL},
                                       .progress = option(words, "stop=") ? goes_on : NULL,
                                       .context = &calls};
    io_raster_free(&raster);
    const bool good = io_raster_read(name, &options, &raster, e);
    stop_unless(calls != 1, "the reading was to go on until it is half done");
    free(numbers);
    if (!good) return raster = (io_raster){0}, false;
    fprintf(answer, "nx=%zu\nny=%zu\n", raster.nx, raster.ny);
    tell(&raster.georef);
    save("map", raster.map, sizeof raster.map);
    save("z", raster.z, raster.nx * raster.ny * sizeof *raster.z);
    return true;
}

/* A raster where the last one read lies, of cells in the file cells, which may be too few. sparse: the kind of TIFF. */
static bool writes_raster(const char *name, const char *words, io_error *e) {
    static const double identity[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    size_t size;
    char *cells = load("cells", &size), header[4];
    const io_raster_product product = {.nx = option(words, "nx="),
                                       .ny = option(words, "ny="),
                                       .bands = 1,
                                       .cell = IO_CELL_FLOAT32,
                                       .cog = option(words, "cog=") != 0,
                                       .map = raster.nx ? (const double(*)[4])raster.map : identity,
                                       .georef = &raster.georef,
                                       .creation = (const char *const[]){"SPARSE_OK=TRUE"},
                                       .creation_count = option(words, "sparse=")};
    const size_t rows = size / product.nx / (io_raster_is_png(name) ? 3 : io_cell_bytes(product.cell));
    io_raster_writer to;
    bool good = io_raster_create(&to, name, &product, e);
    if (good && !io_raster_write(&to, cells, rows, e)) io_raster_discard(&to), good = false;
    free(cells);
    if (!good || product.creation_count == 0) return good && io_raster_commit(&to, e);
    const int copy = dup(fileno(to.output.file));
    io_raster_discard(&to); /* GDAL writes the header now */
    stop_unless(pread(copy, header, 4, 0) == 4 && close(copy) == 0, name);
    fprintf(answer, "%d", header[2]);
    return true;
}

static int obey_raster(const char *c, char **w, io_error *e) {
    if (strcmp(c, "system") == 0) return reads_system(w[1], e);
    if (strcmp(c, "raster") == 0) return reads_raster(w[1], w[2], e);
    if (strcmp(c, "raster write") == 0) return writes_raster(w[1], w[2], e);
    return strcmp(c, "can write") == 0 ? io_raster_can_write(w[1], whole(w[2]), e) : OTHER;
}

static int obey(char **w, io_error *e) {
    int (*const all[])(const char *, char **, io_error *) = {obey_output, obey_file, obey_raster};
    int found = OTHER;
    for (size_t k = 0; k < 3 && found == OTHER; k++) found = all[k](w[0], w, e);
    return found;
}

int main(int argc, char **argv) {
    const int status = words_run(argc, argv, obey);
    io_npy_close(&npy);
    io_raster_free(&raster);
    return status;
}
