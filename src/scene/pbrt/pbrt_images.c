/* SPDX-License-Identifier: Apache-2.0 */
#include "pbrt_images.h"

#include "cpus.h"
#include "image.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

void pbrt_images_begin(pbrt_images *p, unsigned threads) {
    *p = (pbrt_images){.threaded = (threads > 0 ? threads : cpus_usable()) > 1};
}

texture *pbrt_images_find(const pbrt_images *p, const char *path) {
    struct stat about;
    if (stat(path, &about) != 0) return NULL;
    for (size_t k = 0; k < p->count; k++)
        if (p->list[k].device == about.st_dev && p->list[k].inode == about.st_ino) return p->list[k].image;
    return NULL;
}

/* pixels: of the images before; grows by this one's. */
static bool read_one(const pbrt_image *one, size_t *pixels, io_error *error) {
    io_image image;
    io_error why;
    if (!io_image_read_halves(one->path, &image, &why)) return io_fail(error, "%s: Texture: %s", one->place, why.text);
    const size_t own = image.width * image.height;
    bool good = own <= IO_IMAGE_PIXELS_MAX - *pixels ||
                io_fail(error, "%s: Texture: the scene's images have more than %d pixels in all", one->place,
                        IO_IMAGE_PIXELS_MAX);
    if (good && !texture_fill(one->image, &image)) good = io_fail(error, "%s: Texture: out of memory", one->place);
    if (good)
        *pixels += own;
    else
        io_image_free(&image);
    return good;
}

/* Reads all images that wait. Called with the lock, which it releases while it reads. */
static void read_next(pbrt_images *p) {
    const pbrt_image one = p->list[p->next++];
    size_t pixels = p->pixels;
    io_error error;
    if (p->started) pthread_mutex_unlock(&p->lock);
    const bool good = read_one(&one, &pixels, &error);
    if (p->started) pthread_mutex_lock(&p->lock);
    p->pixels = pixels;
    if (good) return;
    p->failed = true;
    p->error = error;
}

static void *work(void *context) {
    pbrt_images *p = context;
    pthread_mutex_lock(&p->lock);
    for (;;) {
        while (p->next == p->count && !p->complete) pthread_cond_wait(&p->changed, &p->lock);
        if (p->next == p->count || p->failed) break;
        read_next(p);
    }
    pthread_mutex_unlock(&p->lock);
    return NULL;
}

/* With the first image. If there can be no thread, the caller reads. */
static void start(pbrt_images *p) {
    p->threaded = false;
    if (pthread_mutex_init(&p->lock, NULL) != 0) return;
    if (pthread_cond_init(&p->changed, NULL) != 0) {
        pthread_mutex_destroy(&p->lock);
        return;
    }
    p->started = p->threaded = true; /* before the thread, which looks at it */
    if (pthread_create(&p->thread, NULL, work, p) == 0) return;
    p->started = p->threaded = false;
    pthread_cond_destroy(&p->changed);
    pthread_mutex_destroy(&p->lock);
}

bool pbrt_images_read(pbrt_images *p, const char *path, const char *place, texture *into, io_error *error) {
    struct stat about = {0};
    stat(path, &about); /* a missing file fails when it is read */
    pbrt_image one = {strdup(path), strdup(place), about.st_dev, about.st_ino, into};
    if (p->threaded && !p->started) start(p);
    if (p->started) pthread_mutex_lock(&p->lock);
    pbrt_image *more = realloc(p->list, (p->count + 1) * sizeof *more);
    if (more != NULL) p->list = more;
    bool good = one.path != NULL && one.place != NULL && more != NULL;
    if (good)
        p->list[p->count++] = one;
    else {
        free(one.path);
        free(one.place);
        io_fail(error, "%s: Texture: out of memory", place);
    }
    if (good && p->started) pthread_cond_signal(&p->changed);
    if (good && !p->started) read_next(p);
    if (good && p->failed) {
        good = false;
        if (error != NULL) *error = p->error;
    }
    if (p->started) pthread_mutex_unlock(&p->lock);
    return good;
}

bool pbrt_images_end(pbrt_images *p, io_error *error) {
    if (p->started) {
        pthread_mutex_lock(&p->lock);
        p->complete = true;
        pthread_cond_signal(&p->changed);
        pthread_mutex_unlock(&p->lock);
        pthread_join(p->thread, NULL);
        pthread_cond_destroy(&p->changed);
        pthread_mutex_destroy(&p->lock);
    }
    for (size_t k = 0; k < p->count; k++) {
        free(p->list[k].path);
        free(p->list[k].place);
    }
    free(p->list);
    if (p->failed && error != NULL) *error = p->error;
    return !p->failed;
}
