/* SPDX-License-Identifier: Apache-2.0 */
/* What files may make GDAL do, as users run the program: wait for nobody, send no request unless asked for, and leave nothing
 * of a GeoTIFF that was not finished. */

#include "program.h"
#include "tool_files.h"

#include <netinet/in.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

static void text_file(const char *name, const char *text) { scratch_write(name, text, strlen(text)); }

static void vrt_file(const char *name, const char *source) {
    char text[2048];
    snprintf(text, sizeof text,
             "<VRTDataset rasterXSize=\"4\" rasterYSize=\"4\"><GeoTransform>0,1,0,4,0,-1</GeoTransform>"
             "<VRTRasterBand dataType=\"Float32\" band=\"1\"><SimpleSource><SourceFilename>%s</SourceFilename>"
             "<SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>",
             source);
    text_file(name, text);
}

/* Refused, and soon, with the words in the message. */
static void check_refused(const char *file, const char *words) {
    const program_setting setting = {.seconds_limit = 20};
    const program_result *r = program_run(&setting, (const char *const[]){"info", file, NULL});
    check(r->status == EXIT_FAILURE, "%s: exit status %d: %s", file, r->status, r->err);
    check(strstr(r->err, words) != NULL, "%s: '%s' is not in '%s'", file, words, r->err);
}

static void pipes_are_refused(void **state) {
    (void)state;
    assert_int_equal(mkfifo("pipe", 0600), 0);
    assert_int_equal(symlink("pipe", "link.tif"), 0);
    check_refused("link.tif", "not a regular file");
    vrt_file("source.vrt", "pipe");
    check_refused("source.vrt", "pipe is not a regular file");
    vrt_file("inner.vrt", "source.vrt");
    check_refused("inner.vrt", "pipe is not a regular file");
    assert_int_equal(symlink("/dev/zero", "zero.tif"), 0);
    check_refused("zero.tif", "not a regular file");
    check_refused("/vsistdin/", "cannot read");
    /* One that GDAL looks into by itself. */
    vrt_file("good.vrt", "grid.asc");
    text_file("grid.asc",
              "ncols 4\nnrows 4\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3 4\n1 2 3 4\n1 2 3 4\n1 2 3 4\n");
    const program_setting setting = {.seconds_limit = 20};
    assert_int_equal(mkfifo("grid.prj", 0600), 0);
    const program_result *r = program_run(&setting, (const char *const[]){"info", "good.vrt", NULL});
    check(r->status == EXIT_SUCCESS, "beside a pipe: exit status %d: %s", r->status, r->err);
}

/* A server that counts who comes, and hangs up. */
typedef struct server {
    int socket, port;
    atomic_uint visits;
    atomic_bool quit;
    pthread_t thread;
} server;

static void *serve(void *context) {
    server *s = context;
    for (;;) {
        const int visitor = accept(s->socket, NULL, NULL);
        if (atomic_load(&s->quit) || visitor < 0) return NULL;
        atomic_fetch_add(&s->visits, 1);
        close(visitor);
    }
}

static void open_server(server *s) {
    struct sockaddr_in here = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t size = sizeof here;
    *s = (server){.socket = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
    assert_true(s->socket >= 0);
    assert_int_equal(bind(s->socket, (struct sockaddr *)&here, size), 0);
    assert_int_equal(listen(s->socket, 64), 0);
    assert_int_equal(getsockname(s->socket, (struct sockaddr *)&here, &size), 0);
    s->port = ntohs(here.sin_port);
    assert_int_equal(pthread_create(&s->thread, NULL, serve, s), 0);
}

static void close_server(server *s) {
    atomic_store(&s->quit, true);
    shutdown(s->socket, SHUT_RDWR);
    pthread_join(s->thread, NULL);
    close(s->socket);
}

/* How often the server is visited. */
static unsigned visits(server *s, const char *file, bool allowed) {
    const program_setting setting = {.seconds_limit = 60};
    const unsigned before = atomic_load(&s->visits);
    const char *const arguments[] = {"info", file, allowed ? "--allow-network" : NULL, NULL};
    const program_result *r = program_run(&setting, arguments);
    check(r->status == EXIT_FAILURE, "%s: exit status %d: %s", file, r->status, r->err);
    return atomic_load(&s->visits) - before;
}

static void no_request_unless_asked_for(void **state) {
    (void)state;
    server s;
    open_server(&s);
    /* No proxy of the machine's stands between. */
    setenv("no_proxy", "127.0.0.1", 1);
    setenv("GDAL_HTTP_MAX_RETRY", "0", 1);
    static const char *const sources[] = {
        "/vsicurl/http://127.0.0.1:%d/a.tif",
        "/vsicurl_streaming/http://127.0.0.1:%d/a.tif",
        "/vsizip//vsicurl/http://127.0.0.1:%d/a.zip/a.tif",
        "NETCDF:&quot;http://127.0.0.1:%d/a.nc&quot;:z",
        "http://127.0.0.1:%d/a.tif",
        "WMTS:http://127.0.0.1:%d/w",
        "map.tif",
    };
    enum { SOURCES = sizeof sources / sizeof sources[0] };
    char text[1024];
    snprintf(text, sizeof text,
             "<GDAL_WMS><Service name=\"TMS\"><ServerUrl>http://127.0.0.1:%d/${z}/${x}/${y}.png</ServerUrl></Service>"
             "<DataWindow><UpperLeftX>0</UpperLeftX><UpperLeftY>4</UpperLeftY><LowerRightX>4</LowerRightX>"
             "<LowerRightY>0</LowerRightY><TileLevel>0</TileLevel><TileCountX>1</TileCountX><TileCountY>1</TileCountY>"
             "</DataWindow><BlockSizeX>4</BlockSizeX><BlockSizeY>4</BlockSizeY><BandsCount>1</BandsCount></GDAL_WMS>",
             s.port);
    text_file("map.tif", text);
    unsigned open_doors = 0;
    for (size_t k = 0; k < SOURCES; k++) {
        snprintf(text, sizeof text, sources[k], s.port);
        vrt_file("net.vrt", text);
        const unsigned uninvited = visits(&s, "net.vrt", false);
        check(uninvited == 0, "%s: %u requests", text, uninvited);
        open_doors += visits(&s, "net.vrt", true) > 0;
    }
    /* By a proxy that GDAL is told of, and that goes before those of the environment. */
    snprintf(text, sizeof text, "127.0.0.1:%d", s.port);
    setenv("GDAL_HTTP_PROXY", text, 1);
    vrt_file("net.vrt", "/vsicurl/http://nowhere.invalid/a.tif");
    assert_int_equal(visits(&s, "net.vrt", false), 0);
    open_doors += visits(&s, "net.vrt", true) > 0;
    unsetenv("GDAL_HTTP_PROXY");
    assert_int_equal(visits(&s, "map.tif", false), 0);
    check_refused("map.tif", "--allow-network");
    open_doors += visits(&s, "map.tif", true) > 0;
    /* By its name. */
    snprintf(text, sizeof text, "/vsicurl/http://127.0.0.1:%d/b.tif", s.port);
    assert_int_equal(visits(&s, text, false), 0);
    check_refused(text, "--allow-network");
    open_doors += visits(&s, text, true) > 0;
    close_server(&s);
    /* A GDAL without libcurl has none of them. */
    print_message("%u of %d ways lead to the network\n", open_doors, SOURCES + 3);
    if (open_doors == 0) skip();
}

static void rough_field(size_t side) {
    float *z = malloc(sizeof *z * side * side);
    assert_non_null(z);
    for (size_t k = 0; k < side * side; k++) z[k] = (float)((k * 2654435761u >> 7) % 1000);
    field_file("rough.npy", z, side, side);
    free(z);
}

static void killed_geotiffs_leave_nothing(void **state) {
    (void)state;
    rough_field(1000);
    const size_t entries = scratch_entries();
    static const char *const options[] = {"--directions=3600", "--cog"};
    for (size_t k = 0; k < 2; k++) {
        const pid_t process = program_start(NULL, (const char *const[]){"horizon", "rough.npy", "--directions", "3600",
                                                                        options[k], "-o", "sky.tif", NULL});
        program_wait_for_output(process);
        const bool unnamed = scratch_entries() == entries;
        nanosleep(&(struct timespec){0, 100000000}, NULL);
        kill(process, SIGKILL);
        assert_int_equal(program_wait(process)->status, 128 + SIGKILL);
        if (!unnamed) skip(); /* this file system knows no files without names */
        assert_int_equal(scratch_entries(), entries);
    }
}

/* A limit on the size of files stands for a disk that is full. */
static void a_full_disk_is_named(void **state) {
    (void)state;
    rough_field(300);
    const size_t entries = scratch_entries();
    static const char *const options[] = {"--compress=none", "--compress=deflate", "--cog", "--cog"};
    /* The last one fails in the COG, which with its smaller copies is larger than the GeoTIFF that it is copied from. */
    size_t size;
    program_run(NULL, (const char *const[]){"horizon", "rough.npy", "--directions", "8", "-o", "sky.tif", NULL});
    free(scratch_read("sky.tif", &size));
    assert_int_equal(unlink("sky.tif"), 0);
    for (size_t k = 0; k < 4; k++) {
        const program_setting little = {.file_size_limit = k == 3 ? size + size / 10 : 100000};
        const program_result *r =
            program_run(&little, (const char *const[]){"horizon", "rough.npy", "--directions", "8", "-o", "sky.tif",
                                                       options[k], k >= 2 ? "--co=BLOCKSIZE=128" : NULL, NULL});
        check(r->status == EXIT_FAILURE, "exit status %d: %s", r->status, r->err);
        check(strstr(r->err, "sky.tif: cannot write: File too large") != NULL, "%s", r->err);
        assert_int_equal(scratch_entries(), entries);
    }
}

/* Statistics of a file that is no longer there would make viewers stretch the new one by them. */
static void old_companions_go(void **state) {
    (void)state;
    rough_field(20);
    static const char *const companions[] = {"sky.tif", "sky.tif.aux.xml", "sky.tif.ovr", "sky.tif.msk",
                                             "sky.npy.aux.xml"};
    for (size_t k = 0; k < sizeof companions / sizeof companions[0]; k++) text_file(companions[k], "old");
    const size_t entries = scratch_entries();
    static const char *const outputs[] = {"sky.npy", "sky.tif"};
    static const int more[] = {1, -2};
    for (size_t k = 0; k < 2; k++) {
        const program_result *r = program_run(
            NULL, (const char *const[]){"horizon", "rough.npy", "--directions", "4", "-o", outputs[k], NULL});
        check(r->status == 0, "%s", r->err);
        assert_int_equal((int)scratch_entries(), (int)entries + more[k]);
    }
    assert_int_equal(access("sky.npy.aux.xml", F_OK), 0);
}

static int enter(void **state) {
    signal(SIGXFSZ, SIG_IGN);
    return scratch_enter(state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(pipes_are_refused, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(no_request_unless_asked_for, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(killed_geotiffs_leave_nothing, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(a_full_disk_is_named, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(old_companions_go, enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
