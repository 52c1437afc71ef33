/* SPDX-License-Identifier: Apache-2.0 */
/* Runs the built program cellwalk as a user would. */
#ifndef CELLWALK_TESTS_PROGRAM_H
#define CELLWALK_TESTS_PROGRAM_H

#include <stdbool.h>
#include <sys/types.h>

enum { PROGRAM_TEXT_MAX = 1 << 16, PROGRAM_ARGUMENTS_MAX = 24 };

/* Environment and limits of the program. */
typedef struct program_setting {
    const char *isa;                   /* CELLWALK_ISA; NULL: as the test itself has it */
    unsigned long file_size_limit;     /* bytes; 0: none */
    unsigned long address_space_limit; /* bytes; 0: none */
    bool powerless;                    /* without the rights of root, even if the test has them */
    bool refuse_filters;               /* the system call seccomp fails with EINVAL, as in some emulators */
    unsigned seconds_limit;            /* SIGALRM ends it after so long; 0: none */
    const char *preload, *fault, *fault_counts,
        *threads; /* LD_PRELOAD, and variables for ../faults/preload.c; NULL: not set */
} program_setting;

typedef struct program_result {
    int status; /* exit status; 128 + the signal's number if one ended it; 255 if the setting is not to be had */
    char out[PROGRAM_TEXT_MAX], err[PROGRAM_TEXT_MAX]; /* err without the lines that say what was written: */
    char outcome[PROGRAM_TEXT_MAX];
} program_result;

/* Arguments, without the program's name and up to NULL. setting may be NULL. */
typedef const char *const *program_arguments;

/* Runs to the end. The result is static: the next run overwrites it. */
const program_result *program_run(const program_setting *setting, program_arguments arguments);

/* Starts the program, and waits for its end; one at a time. */
pid_t program_start(const program_setting *setting, program_arguments arguments);
const program_result *program_wait(pid_t process);

/* Waits until the started program has an output open in the working directory, which need not have a name there. */
void program_wait_for_output(pid_t process);

/* Waits until the started program has a file of the working directory open; or has read as many bytes as the file has. */
void program_wait_for_input(pid_t process, const char *name);
void program_wait_until_read(pid_t process, const char *name);

#endif
