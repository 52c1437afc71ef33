/* SPDX-License-Identifier: Apache-2.0 */
/* The images of a scene while its file is read. Each file is read once, in the order in which shapes need them, on a
 * second thread if that is allowed: decoding takes longer than most scenes' text. */
#ifndef CELLWALK_SCENE_PBRT_IMAGES_H
#define CELLWALK_SCENE_PBRT_IMAGES_H

#include "error.h"
#include "texture.h"

#include <pthread.h>
#include <sys/types.h>

/* A file's image, however many Texture directives name it. */
typedef struct pbrt_image {
    char *path, *place; /* "file:line" of the Texture directive */
    dev_t device;
    ino_t inode;
    texture *image; /* the scene's; empty until it has been read */
} pbrt_image;

typedef struct pbrt_images {
    bool threaded; /* there is a thread to read them, or will be */
    bool started;  /* it, lock and changed exist */
    pthread_t thread;
    pthread_mutex_t lock; /* of all that follows */
    pthread_cond_t changed;
    pbrt_image *list;
    size_t count, next; /* the first one that has not been begun */
    bool complete;      /* no more will come */
    size_t pixels;      /* of all that have been read */
    bool failed;        /* then no more is read */
    io_error error;
} pbrt_images;

/* threads: 1 for none beside the caller's, 0 for one if there is a CPU for it. */
void pbrt_images_begin(pbrt_images *p, unsigned threads);

/* The image of a file, if it is one of those that have been asked for; else NULL. */
texture *pbrt_images_find(const pbrt_images *p, const char *path);

/* Reads a file into an empty texture, now or later. False, with error, if this one or one before is known to have
 * failed. */
bool pbrt_images_read(pbrt_images *p, const char *path, const char *place, texture *into, io_error *error);

/* Waits until all have been read. False, with error, if one failed: then it was before any other error that the
 * caller has found since, as it comes first in the file. To be called in any case, and once. */
bool pbrt_images_end(pbrt_images *p, io_error *error);

#endif
