/* SPDX-License-Identifier: Apache-2.0 */
/* GDAL and the libraries behind it have many ways to the network, and a file can trigger most of them. All begin with a
 * socket, so the kernel refuses to make one: a seccomp filter of system calls.
 *
 * All families are refused: a list would miss AF_VSOCK and later ones, and behind some AF_UNIX sockets a name service
 * (nscd, systemd-resolved) uses the network. No library of the program requires a socket. io_uring is refused too, as
 * it makes sockets without that call. Calls of another architecture have other numbers; the program makes none. */

#include "network.h"

#ifdef __linux__ /* not CELLWALK_LINUX: without the filter there is no second way */

#include <elf.h>
#include <errno.h>
#include <link.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <stddef.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

/* The header of this program or library in memory, which the linker defines. */
extern const ElfW(Ehdr) __ehdr_start __attribute__((visibility("hidden")));

/* As <linux/audit.h> composes AUDIT_ARCH_X86_64 and the others. */
static uint32_t own_architecture(void) {
    const uint32_t little = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ ? __AUDIT_ARCH_LE : 0;
    return __ehdr_start.e_machine | little | (sizeof(void *) == 8 ? __AUDIT_ARCH_64BIT : 0);
}

#define LOAD(field)                  BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, field))
#define RETURN(value)                BPF_STMT(BPF_RET | BPF_K, value)
#define REFUSE                       RETURN(SECCOMP_RET_ERRNO | EACCES)
#define REFUSE_IF(comparison, value) BPF_JUMP(BPF_JMP | (comparison) | BPF_K, value, 0, 1), REFUSE

bool network_close(io_error *error) {
    struct sock_filter rules[] = {
        LOAD(arch),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, own_architecture(), 1, 0),
        REFUSE,
        LOAD(nr),
#ifdef __X32_SYSCALL_BIT
        REFUSE_IF(BPF_JGE, __X32_SYSCALL_BIT), /* the same calls once more, with 32-bit pointers */
#endif
#ifdef SYS_socketcall
        REFUSE_IF(BPF_JEQ, SYS_socketcall),
#endif
#ifdef SYS_io_uring_setup
        REFUSE_IF(BPF_JEQ, SYS_io_uring_setup),
#endif
        REFUSE_IF(BPF_JEQ, SYS_socket),
        RETURN(SECCOMP_RET_ALLOW),
    };
    const struct sock_fprog program = {sizeof rules / sizeof rules[0], rules};
    /* TSYNC: for the threads that run already, too. It returns the number of one that cannot follow. */
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
        syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_TSYNC, &program) == 0)
        return true;
    return io_fail(error,
                   "the system refuses the filter that keeps GDAL from the network (seccomp: %s); --allow-network does "
                   "without the filter",
                   strerror(errno));
}

#else

bool network_close(io_error *error) {
    return io_fail(error,
                   "this system has no filter that keeps GDAL from the network; --allow-network does without it");
}

#endif
