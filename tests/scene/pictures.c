/* SPDX-License-Identifier: Apache-2.0 */
#include "pictures.h"

#include "check.h"
#include "half.h"
#include "landscape.h"
#include "scratch.h"
#include "workload/random.h"

#include <stdio.h>
#include <string.h>

scene *pictures_load(const char *text) {
    io_error error = {""};
    scratch_write("scene.pbrt", text, strlen(text));
    scene *s = scene_load("scene.pbrt", NULL, NULL, &error);
    check(s != NULL, "%s", error.text);
    return s;
}

io_image pictures_render(const scene *s, const scene_render_options *options, scene_render_stats *stats) {
    io_image image;
    io_error error = {""};
    check(scene_render(s, options, &image, stats, &error), "%s", error.text);
    return image;
}

bool pictures_same(const io_image *a, const io_image *b) {
    return a->width == b->width && a->height == b->height &&
           memcmp(a->rgb, b->rgb, a->width * a->height * 3 * sizeof *a->rgb) == 0;
}

#define LIGHT "LightSource \"point\" \"color I\" [3 2 1]\n"

/* A scene's text while it is put together. */
typedef struct text {
    char all[1 << 16];
    size_t used;
    random_state random;
} text;

static void add(text *t, const char *more) {
    const int length = snprintf(t->all + t->used, sizeof t->all - t->used, "%s", more);
    t->used += (size_t)length;
    check(t->used < sizeof t->all, "the scene's text is too long");
}

/* A field of random heights with what stands before it, a material and transforms. */
static void add_field(text *t, const char *before, int nu, int nv) {
    char part[128];
    add(t, "AttributeBegin\n");
    add(t, before);
    snprintf(part, sizeof part, "Shape \"heightfield\" \"integer nu\" %d \"integer nv\" %d \"float Pz\" [", nu, nv);
    add(t, part);
    for (int k = 0; k < nu * nv; k++) {
        snprintf(part, sizeof part, " %.4f", random_between(&t->random, -1, 1));
        add(t, part);
    }
    add(t, "]\nAttributeEnd\n");
}

scene *pictures_rough_scene(void) {
    static text t;
    t.used = 0;
    t.random = (random_state){11};
    add(&t, "Film \"image\" \"integer xresolution\" 70 \"integer yresolution\" 50\n"
            "LookAt 0 -1 1.5 0 1 0 0 0 1\nCamera \"perspective\" \"float fov\" 60\nWorldBegin\n"
            "AttributeBegin\nTranslate 1 -1 2\n" LIGHT "Translate -2 0 0\n" LIGHT "AttributeEnd\n");
    add_field(&t, "Translate -1 -1 0\nScale 2 2 0.5\n", 17, 15);
    add_field(&t, "Material \"mirror\"\nTranslate -1 -1 0\nScale 2 2 0.1\n", 17, 15);
    add(&t, "WorldEnd\n");
    return pictures_load(t.all);
}

static void write_image(const char *name) {
    enum { WIDTH = 45, HEIGHT = 28 };
    float rgb[WIDTH * HEIGHT * 3];
    random_state r = {17};
    for (int k = 0; k < WIDTH * HEIGHT * 3; k++) rgb[k] = (float)random_between(&r, 0, 1.5);
    io_error error = {""};
    check(io_image_write(name, &(io_image){.width = WIDTH, .height = HEIGHT, .rgb = rgb}, &error), "%s", error.text);
}

scene *pictures_full_scene(void) {
    static text t;
    write_image("image.exr");
    t.used = 0;
    t.random = (random_state){12};
    add(&t, "Film \"image\" \"integer xresolution\" 70 \"integer yresolution\" 50\n"
            "Sampler \"bestcandidate\" \"integer pixelsamples\" 6\nLookAt 0 -1.2 1 0 1 0.1 0 0 1\n"
            "Camera \"perspective\" \"float fov\" 70\nWorldBegin\n"
            "Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"image.exr\"\n"
            "AttributeBegin\nTranslate 1 -1 2\n" LIGHT "Translate -2 0.5 -1\n" LIGHT "Translate 0 9 3\n" LIGHT
            "AttributeEnd\nAttributeBegin\nMaterial \"matte\" \"texture Kd\" \"t\"\nRotate 20 1 0 1\nScale 3 3.5 4\n"
            "Shape \"cylinder\"\nAttributeEnd\n"
            "AttributeBegin\nMaterial \"mirror\" \"color Kr\" [.7 .8 .9]\nTranslate 0.6 0.2 0\nScale 0.2 0.3 0.6\n"
            "Shape \"cylinder\"\nAttributeEnd\n");
    add_field(&t, "Translate -1 -1 0\nRotate 10 0 0 1\nScale 2 2 0.5\n", 17, 15);
    add_field(&t, "Material \"mirror\"\nTranslate -1 -1.1 0.1\nScale 2 2.5 0.1\n", 40, 37);
    add_field(&t, "Material \"matte\" \"texture Kd\" \"t\"\nTranslate -1.5 1 0\nRotate 60 1 0.2 0\nScale 3 1 0.1\n", 2,
              3);
    add_field(&t, "Material \"mirror\" \"color Kr\" [1 .5 0]\nTranslate -2 -1 0.2\nRotate 70 0 1 0\nScale 1 3 0.05\n",
              9, 4);
    add(&t, "WorldEnd\n");
    return pictures_load(t.all);
}

scene *pictures_landscape(void) {
    enum { NX = 40, NY = 33 };
    static const double level = 0.75;
    static float z[NX * NY];
    static cw_field *field;
    random_state r = {13};
    for (int k = 0; k < NX * NY; k++) z[k] = (float)random_between(&r, -3, 3);
    cw_field_destroy(field);
    check(cw_field_create(&(cw_field_desc){.samples = z, .nx = NX, .ny = NY}, NULL, &field) == CW_OK, "no field");
    io_image colours;
    io_error error = {""};
    check(io_image_allocate(&colours, 2, 1, "", &error), "%s", error.text);
    for (int k = 0; k < 6; k++) colours.halves[4 + k / 3 * 4 + k % 3] = half_from_float(0.25f + 0.125f * (float)k);
    const landscape_desc d = {.field = field,
                              .samples = z,
                              .nx = NX,
                              .ny = NY,
                              .to_world = {{2, 0.25, 0, -40}, {0, 1.5, 0, -20}, {0, 0, 1.25, 0}},
                              .colours = &colours,
                              .eye = {-20, -30, 14},
                              .target = {0, 0, 1},
                              .field_of_view = 60,
                              .sun = {0.6, 0, 0.8},
                              .sun_light = 0.85,
                              .sky_light = 0.3,
                              .horizon = {0.7f, 0.8f, 0.93f},
                              .above = {0.16f, 0.34f, 0.7f},
                              .vault = true,
                              .plain = {0.2f, 0.27f, 0.16f},
                              .visibility = 200,
                              .water_level = &level,
                              .width = 70,
                              .height = 50,
                              .samples_a_pixel = 6};
    scene *s = landscape_create(&d, &error);
    check(s != NULL, "%s", error.text);
    return s;
}
