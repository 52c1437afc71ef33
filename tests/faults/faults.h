/* SPDX-License-Identifier: Apache-2.0 */
/* What can be made to fail: what preload.c counts and faults.c asks for. */
#ifndef CELLWALK_TESTS_FAULTS_H
#define CELLWALK_TESTS_FAULTS_H

typedef enum fault_kind {
    FAULT_MEMORY, /* an allocation */
    FAULT_WRITE,  /* writing, flushing, closing, reserving room, bringing to the disk */
    FAULT_RENAME, /* renaming, linking */
    FAULT_OPEN,
    FAULT_READ, /* reading, asking for a size */
    FAULT_MAP,
    FAULT_THREAD, /* starting one */
    FAULT_KINDS
} fault_kind;

static const char *const fault_names[FAULT_KINDS] = {"memory", "write", "rename", "open", "read", "map", "thread"};

#endif
