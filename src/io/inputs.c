/* SPDX-License-Identifier: Apache-2.0 */
#include "inputs.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

static atomic_bool protected;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* of the list */
static struct identity {
    dev_t device;
    ino_t inode;
} * list;
static size_t count;

void io_inputs_protect(void) { atomic_store(&protected, true); }

bool io_inputs_are_protected(void) { return atomic_load(&protected); }

bool io_inputs_have(const struct stat *about) {
    bool have = false;
    pthread_mutex_lock(&lock);
    for (size_t k = 0; k < count; k++) have |= list[k].device == about->st_dev && list[k].inode == about->st_ino;
    pthread_mutex_unlock(&lock);
    return have;
}

bool io_inputs_note(const struct stat *about) {
    if (!io_inputs_are_protected() || io_inputs_have(about)) return true;
    pthread_mutex_lock(&lock);
    struct identity *more = realloc(list, (count + 1) * sizeof *more);
    if (more != NULL) {
        list = more;
        list[count++] = (struct identity){about->st_dev, about->st_ino};
    }
    pthread_mutex_unlock(&lock);
    return more != NULL;
}

bool io_inputs_note_path(const char *path) {
    struct stat about;
    return stat(path, &about) != 0 || io_inputs_note(&about);
}
