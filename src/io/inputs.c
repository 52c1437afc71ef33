/* SPDX-License-Identifier: Apache-2.0 */
#include "inputs.h"

#include <pthread.h>
#include <stdlib.h>

static struct {
    pthread_mutex_t lock;
    bool on;
    struct identity {
        dev_t device;
        ino_t inode;
    } * list;
    size_t count, capacity;
} inputs = {.lock = PTHREAD_MUTEX_INITIALIZER};

void io_inputs_protect(void) {
    pthread_mutex_lock(&inputs.lock);
    inputs.on = true;
    pthread_mutex_unlock(&inputs.lock);
}

bool io_inputs_are_protected(void) {
    pthread_mutex_lock(&inputs.lock);
    const bool on = inputs.on;
    pthread_mutex_unlock(&inputs.lock);
    return on;
}

static bool find(const struct stat *about) {
    for (size_t k = 0; k < inputs.count; k++)
        if (inputs.list[k].device == about->st_dev && inputs.list[k].inode == about->st_ino) return true;
    return false;
}

static bool add(const struct stat *about) {
    if (inputs.count == inputs.capacity) {
        const size_t capacity = inputs.capacity ? 2 * inputs.capacity : 16;
        struct identity *list = realloc(inputs.list, capacity * sizeof *list);
        if (list == NULL) return false;
        inputs.list = list;
        inputs.capacity = capacity;
    }
    inputs.list[inputs.count++] = (struct identity){about->st_dev, about->st_ino};
    return true;
}

bool io_inputs_note(const struct stat *about) {
    pthread_mutex_lock(&inputs.lock);
    const bool good = !inputs.on || find(about) || add(about);
    pthread_mutex_unlock(&inputs.lock);
    return good;
}

bool io_inputs_note_path(const char *path) {
    struct stat about;
    return stat(path, &about) != 0 || io_inputs_note(&about);
}

bool io_inputs_have(const struct stat *about) {
    pthread_mutex_lock(&inputs.lock);
    const bool have = find(about);
    pthread_mutex_unlock(&inputs.lock);
    return have;
}
