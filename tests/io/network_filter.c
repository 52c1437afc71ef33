/* SPDX-License-Identifier: Apache-2.0 */
/* The filter that closes the network to the program, tried call by call. */

#include "check.h"
#include "network.h"

#include <errno.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

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

int main(int argc, char **argv) {
    if (argc > 1) return try_sockets();
    self = argv[0];
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_thread_and_no_child_gets_a_socket),
        cmocka_unit_test(no_call_of_another_architecture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
