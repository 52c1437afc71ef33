/* SPDX-License-Identifier: Apache-2.0 */
/* The calls that can be made to fail: preload.c counts them, ../tool/test_faults.py chooses one. */
#ifndef CELLWALK_TESTS_FAULTS_H
#define CELLWALK_TESTS_FAULTS_H

typedef enum fault_kind {
    FAULT_MEMORY, /* an allocation */
    FAULT_WRITE,  /* writing, flushing, closing, reserving room, rights, bringing to the disk */
    FAULT_RENAME, /* renaming */
    FAULT_OPEN,
    FAULT_READ,   /* reading, asking for a size or a link */
    FAULT_THREAD, /* starting one */
    FAULT_KINDS
} fault_kind;

typedef struct fault_counts {
    unsigned long calls[FAULT_KINDS];
    long blocks; /* of memory that were not freed */
} fault_counts;

/* In a test that preload.c is a part of: from now on the call of that number fails, 0 for none; until the end. */
void faults_begin(fault_kind kind, unsigned long number);
fault_counts faults_end(void);

static const char *const fault_names[FAULT_KINDS] = {"memory", "write", "rename", "open", "read", "thread"};

#endif
