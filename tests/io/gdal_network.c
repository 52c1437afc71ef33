/* SPDX-License-Identifier: Apache-2.0 */
/* No file makes the program send a request unless asked for; and the filter behind that, tried call by call. */

#include "network.h"
#include "program.h"
#include "tool_files.h"

#include <errno.h>
#include <netinet/in.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
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

/* ---- requests ---------------------------------------------------------------------------------------------------- */

/* A server that counts who comes, and hangs up. */
typedef struct server {
    int socket;
    struct sockaddr_in address;
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
    socklen_t size = sizeof s->address;
    *s = (server){.socket = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0),
                  .address = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)}};
    assert_true(s->socket >= 0);
    assert_int_equal(bind(s->socket, (struct sockaddr *)&s->address, size), 0);
    assert_int_equal(listen(s->socket, 64), 0);
    assert_int_equal(getsockname(s->socket, (struct sockaddr *)&s->address, &size), 0);
    assert_int_equal(pthread_create(&s->thread, NULL, serve, s), 0);
}

static void close_server(server *s) {
    atomic_store(&s->quit, true);
    shutdown(s->socket, SHUT_RDWR);
    pthread_join(s->thread, NULL);
    close(s->socket);
}

/* How many came before this call. Visitors are counted in the order in which they come, so the test visits as the last. */
static unsigned count(server *s) {
    const int visitor = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    char byte;
    assert_true(visitor >= 0);
    assert_int_equal(connect(visitor, (struct sockaddr *)&s->address, sizeof s->address), 0);
    assert_true(read(visitor, &byte, 1) <= 0); /* until the server hangs up */
    close(visitor);
    return atomic_exchange(&s->visits, 0) - 1;
}

/* How often the server is visited. */
static unsigned visits(server *s, const char *file, bool allowed, bool shadow) {
    const program_setting setting = {.seconds_limit = 60};
    const char *allow = allowed ? "--allow-network" : NULL;
    const char *const info[] = {"info", file, allow, NULL};
    const char *const other[] = {"shadow", file, "--sun", "90,10", "-o", "o.tif", allow, NULL};
    const program_result *r = program_run(&setting, shadow ? other : info);
    check(r->status == EXIT_FAILURE, "%s: exit status %d: %s", file, r->status, r->err);
    check(allowed || strstr(r->err, "--allow-network") != NULL, "%s: no way out in '%s'", file, r->err);
    return count(s);
}

static bool is_open_on_request(server *s, const char *file, const char *what, bool shadow) {
    const unsigned uninvited = visits(s, file, false, shadow);
    check(uninvited == 0, "%s: %u requests", what, uninvited);
    return visits(s, file, true, shadow) > 0;
}

static void no_request_unless_asked_for(void **state) {
    (void)state;
    server s;
    open_server(&s);
    const int port = ntohs(s.address.sin_port);
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
             port);
    text_file("map.tif", text);
    unsigned open_doors = 0, doors = 0;
    for (size_t k = 0; k < SOURCES; k++) {
        snprintf(text, sizeof text, sources[k], port);
        vrt_file("net.vrt", text);
        for (int shadow = 0; shadow < (k < 2 ? 2 : 1); shadow++, doors++)
            open_doors += is_open_on_request(&s, "net.vrt", text, shadow);
    }
    /* By a proxy that GDAL is told of, and that goes before those of the environment. */
    snprintf(text, sizeof text, "127.0.0.1:%d", port);
    setenv("GDAL_HTTP_PROXY", text, 1);
    vrt_file("net.vrt", "/vsicurl/http://nowhere.invalid/a.tif");
    open_doors += is_open_on_request(&s, "net.vrt", "GDAL_HTTP_PROXY", false);
    unsetenv("GDAL_HTTP_PROXY");
    /* By one that netCDF finds in the working folder. */
    static const char *const settings[] = {".dodsrc", ".ncrc", ".daprc"};
    vrt_file("net.vrt", "NETCDF:&quot;http://nowhere.invalid/a.nc&quot;:z");
    for (size_t k = 0; k < 3; k++) {
        snprintf(text, sizeof text, "HTTP.PROXY.SERVER=http://127.0.0.1:%d\n", port);
        text_file(settings[k], text);
        open_doors += is_open_on_request(&s, "net.vrt", settings[k], false);
        assert_int_equal(unlink(settings[k]), 0);
    }
    /* By names on the command line. */
    open_doors += is_open_on_request(&s, "map.tif", "map.tif", false);
    snprintf(text, sizeof text, "/vsicurl/http://127.0.0.1:%d/b.tif", port);
    open_doors += is_open_on_request(&s, text, text, false);
    close_server(&s);
    /* A GDAL without libcurl has none of them. */
    print_message("%u of %u ways lead to the network\n", open_doors, doors + 6);
    if (open_doors == 0) skip();
}

/* ---- the filter -------------------------------------------------------------------------------------------------- */

/* 0, or the number of the check that failed. Also called in a program that inherits the filter. */
static int try_sockets(void) {
    for (int family = 0; family < 64; family++)
        for (int type = SOCK_STREAM; type <= SOCK_RAW; type++)
            if (socket(family, type, 0) >= 0 || errno != EACCES) return 1;
#ifdef SYS_io_uring_setup
    if (syscall(SYS_io_uring_setup, 1, NULL) >= 0 || errno != EACCES) return 2;
#endif
#ifdef __X32_SYSCALL_BIT
    if (syscall(__X32_SYSCALL_BIT | SYS_socket, AF_INET, SOCK_STREAM, 0) >= 0 || errno != EACCES) return 3;
#endif
    int pair[2];
    if (socketpair(AF_UNIX, SOCK_STREAM, 0, pair) != 0) return 4; /* leads nowhere else */
    close(pair[0]);
    close(pair[1]);
    return 0;
}

static sem_t go;
static void *try_later(void *context) {
    while (sem_wait(&go) != 0) continue;
    *(int *)context = try_sockets();
    return NULL;
}

static int wait_for(pid_t child) {
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

static const char *self;

static void no_thread_and_no_child_gets_a_socket(void **state) {
    (void)state;
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        io_error error;
        pthread_t thread;
        int of_thread = 100;
        sem_init(&go, 0, 0);
        if (socket(AF_UNIX, SOCK_STREAM, 0) < 0) _exit(90);
        if (pthread_create(&thread, NULL, try_later, &of_thread) != 0) _exit(91);
        if (!network_close(&error) || !network_close(&error)) _exit(92); /* a second time does no harm */
        sem_post(&go);
        pthread_join(thread, NULL);
        const int own = try_sockets();
        if (own != 0 || of_thread != 0) _exit(own ? own : 10 + of_thread);
        execl(self, self, "try", NULL);
        _exit(93);
    }
    assert_int_equal(wait_for(child), 0);
}

#if defined(__x86_64__)
/* A system call by the numbers of i386. */
static long call_i386(long number, long first) {
    long result;
    __asm__ volatile("int $0x80" : "=a"(result) : "a"(number), "b"(first), "c"(0L), "d"(0L) : "memory");
    return (int)result;
}

static int in_child(bool filtered, long number) {
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        io_error error;
        if (filtered && !network_close(&error)) _exit(92);
        const long result = call_i386(number, 1);
        _exit(result == -EACCES ? 1 : result > 0 ? 0 : 2);
    }
    return wait_for(child);
}

static void no_call_of_another_architecture(void **state) {
    (void)state;
    enum { GETPID = 20, SOCKETCALL = 102, SOCKET = 359 };
    if (in_child(false, GETPID) != 0) skip(); /* this system has none */
    assert_int_equal(in_child(true, GETPID), 1);
    assert_int_equal(in_child(true, SOCKETCALL), 1);
    assert_int_equal(in_child(true, SOCKET), 1);
}
#else
static void no_call_of_another_architecture(void **state) {
    (void)state;
    skip();
}
#endif

/* A system without the filter: GDAL is not loaded unless the user says so. */
static void without_a_filter(void **state) {
    (void)state;
    const program_setting setting = {.refuse_filters = true};
    static const float z[4] = {1, 2, 3, 4};
    field_file("field.npy", z, 2, 2);
    text_file("grid.asc", "ncols 4\nnrows 4\ncellsize 1\n1 2 3 4\n1 2 3 4\n1 2 3 4\n1 2 3 4\n");
    vrt_file("dem.vrt", "grid.asc");
    const program_result *r = program_run(&setting, (const char *const[]){"info", "dem.vrt", NULL});
    check(r->status == EXIT_FAILURE && strstr(r->err, "seccomp") && strstr(r->err, "--allow-network"), "status %d: %s",
          r->status, r->err);
    r = program_run(&setting, (const char *const[]){"info", "dem.vrt", "--allow-network", NULL});
    check(r->status == EXIT_SUCCESS, "%s", r->err);
    r = program_run(&setting, (const char *const[]){"info", "field.npy", NULL});
    check(r->status == EXIT_SUCCESS, "%s", r->err);
}

int main(int argc, char **argv) {
    if (argc > 1) return try_sockets();
    self = argv[0];
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(no_request_unless_asked_for, scratch_enter, scratch_leave),
        cmocka_unit_test(no_thread_and_no_child_gets_a_socket),
        cmocka_unit_test(no_call_of_another_architecture),
        cmocka_unit_test_setup_teardown(without_a_filter, scratch_enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
