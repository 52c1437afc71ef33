/* SPDX-License-Identifier: Apache-2.0 */
#include "program.h"

#include "check.h"

#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <linux/securebits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { SANITIZER_STATUS = 99, NO_SETTING = 255 };

static FILE *out, *err;
static bool no_leaks; /* none are looked for */

static void limit(int resource, unsigned long bytes) {
    const struct rlimit l = {bytes, bytes};
    if (bytes > 0 && setrlimit((__rlimit_resource_t)resource, &l) != 0) _exit(NO_SETTING);
}

static void refuse_filters(void) {
    struct sock_filter rules[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_seccomp, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EINVAL),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    };
    const struct sock_fprog all = {sizeof rules / sizeof rules[0], rules};
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 || prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &all) != 0)
        _exit(NO_SETTING);
}

/* In the child. Root may write anywhere unless executing a program gives it no rights. */
static void apply(const program_setting *s) {
    limit(RLIMIT_FSIZE, s->file_size_limit);
    limit(RLIMIT_AS, s->address_space_limit);
    if (s->isa) setenv("CELLWALK_ISA", s->isa, 1);
    if (s->fault) setenv("CELLWALK_FAULT", s->fault, 1);
    if (s->fault_counts) setenv("CELLWALK_FAULT_COUNTS", s->fault_counts, 1);
    if (s->threads) setenv("CELLWALK_THREADS", s->threads, 1);
    if (s->preload) setenv("LD_PRELOAD", s->preload, 1);
    /* AddressSanitizer looks up the symbols of each leak, to leave out GDAL's (leaks.supp), and takes longer for it than most runs
     * of the program. The libraries' names are enough for that. */
    setenv("ASAN_OPTIONS", no_leaks ? "symbolize=0:exitcode=99:detect_leaks=0" : "symbolize=0:exitcode=99", no_leaks);
    if (s->refuse_filters) refuse_filters();
    alarm(s->seconds_limit); /* which the program inherits */
    if (s->powerless && geteuid() == 0 && prctl(PR_SET_SECUREBITS, SECBIT_NOROOT, 0, 0, 0) != 0) _exit(NO_SETTING);
}

pid_t program_start(const program_setting *setting, program_arguments arguments) {
    char *argv[PROGRAM_ARGUMENTS_MAX + 2] = {(char *)"cellwalk"};
    for (size_t k = 0; arguments[k]; k++) {
        assert_true(k < PROGRAM_ARGUMENTS_MAX);
        argv[k + 1] = (char *)arguments[k];
    }
    out = tmpfile();
    err = tmpfile();
    assert_true(out && err);
    const pid_t process = fork();
    assert_true(process >= 0);
    if (process > 0) return process;
    dup2(fileno(out), STDOUT_FILENO);
    dup2(fileno(err), STDERR_FILENO);
    apply(setting ? setting : &(program_setting){0});
    execv(CELLWALK_PROGRAM, argv);
    perror(CELLWALK_PROGRAM); /* it may just be linked anew, by a build at the same time */
    _exit(NO_SETTING);
}

static void take_text(FILE *file, char *text) {
    rewind(file);
    text[fread(text, 1, PROGRAM_TEXT_MAX - 1, file)] = '\0';
    fclose(file);
}

/* "cellwalk shadow: s.npy: 94 % of 3000 samples in the sun, 0.01 s" */
static bool is_outcome(const char *line, size_t length) {
    return strncmp(line, "cellwalk ", 9) == 0 && length > 11 && strncmp(line + length - 2, " s", 2) == 0 &&
           line[length - 3] >= '0' && line[length - 3] <= '9' && strstr(line, " samples") != NULL &&
           strstr(line, " samples") < line + length;
}

/* Lines of what was written go from err to outcome. */
static void part_texts(char *messages, char *outcome) {
    char *to = messages;
    *outcome = '\0';
    for (const char *line = messages; *line;) {
        const size_t length = strcspn(line, "\n"), whole = length + (line[length] == '\n');
        if (is_outcome(line, length)) {
            strncat(outcome, line, whole);
        } else {
            memmove(to, line, whole);
            to += whole;
        }
        line += whole;
    }
    *to = '\0';
}

static program_result result;

static void take_result(pid_t process) {
    int status;
    assert_int_equal(waitpid(process, &status, 0), process);
    result.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    take_text(out, result.out);
    take_text(err, result.err);
    part_texts(result.err, result.outcome);
}

static const program_result *checked(void) {
    check(result.status != SANITIZER_STATUS, "a sanitizer ended the program: %s", result.err);
    check(strstr(result.err, "Sanitizer") == NULL && strstr(result.err, "runtime error") == NULL, "%s", result.err);
    return &result;
}

const program_result *program_wait(pid_t process) {
    take_result(process);
    return checked();
}

/* LeakSanitizer stops the program's threads to look at their memory when it ends, and may crash itself. The status is lost with
 * it: the program runs once more, without a look for leaks. */
const program_result *program_run(const program_setting *setting, program_arguments arguments) {
    take_result(program_start(setting, arguments));
    if (strstr(result.err, "LeakSanitizer has encountered a fatal error") != NULL) {
        no_leaks = true;
        take_result(program_start(setting, arguments));
        no_leaks = false;
    }
    return checked();
}

/* What a descriptor leads to, if that is in the working directory, as seen from there. */
typedef bool file_fits(const char *file, const char *name);

static bool any_descriptor(pid_t process, file_fits *fits, const char *name) {
    char folder[64], here[PATH_MAX], target[PATH_MAX];
    snprintf(folder, sizeof folder, "/proc/%ld/fd", (long)process);
    assert_non_null(getcwd(here, sizeof here));
    const size_t length = strlen(here);
    DIR *descriptors = opendir(folder);
    bool found = false;
    for (const struct dirent *e; descriptors && !found && (e = readdir(descriptors)) != NULL;) {
        const ssize_t size = readlinkat(dirfd(descriptors), e->d_name, target, sizeof target - 1);
        if (size < 0) continue;
        target[size] = '\0';
        found = strncmp(target, here, length) == 0 && fits(target + length, name);
    }
    if (descriptors) closedir(descriptors);
    return found;
}

/* It has no name or a temporary one. */
static bool is_output(const char *file, const char *name) {
    (void)name;
    return strstr(file, "/#") != NULL || strstr(file, ".tmp") != NULL;
}

static bool is_input(const char *file, const char *name) { return file[0] == '/' && strcmp(file + 1, name) == 0; }

/* Whether it has read as many bytes, of whatever files. */
static bool has_read(pid_t process, const char *bytes) {
    char path[64];
    unsigned long long count = 0;
    snprintf(path, sizeof path, "/proc/%ld/io", (long)process);
    FILE *file = fopen(path, "r");
    const bool known = file != NULL && fscanf(file, "rchar: %llu", &count) == 1;
    if (file) fclose(file);
    return known && count >= strtoull(bytes, NULL, 10);
}

static bool has_output(pid_t process, const char *name) { return any_descriptor(process, is_output, name); }

static bool has_input(pid_t process, const char *name) { return any_descriptor(process, is_input, name); }

/* The pause leaves the CPU to the program; it decides nothing. Only its end ends the wait before its time. */
static void wait_until(pid_t process, bool (*is_so)(pid_t, const char *), const char *name, const char *what) {
    const struct timespec pause = {.tv_nsec = 1000000};
    for (;;) {
        siginfo_t end = {.si_pid = 0};
        assert_int_equal(waitid(P_PID, (id_t)process, &end, WEXITED | WNOHANG | WNOWAIT), 0);
        if (is_so(process, name)) return;
        check(end.si_pid == 0, "the program ended before %s %s", name, what);
        nanosleep(&pause, NULL);
    }
}

void program_wait_for_output(pid_t process) { wait_until(process, has_output, "an output", "was opened"); }

void program_wait_for_input(pid_t process, const char *name) { wait_until(process, has_input, name, "was open"); }

void program_wait_until_read(pid_t process, const char *name) {
    struct stat about;
    char bytes[32];
    check(stat(name, &about) == 0, "there is no %s", name);
    snprintf(bytes, sizeof bytes, "%lld", (long long)about.st_size);
    wait_until(process, has_read, bytes, "bytes were read");
}
