/* SPDX-License-Identifier: Apache-2.0 */
/* Shape, LightSource, Material and Texture. */

#include "pbrt_state.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* array with room for one more element of this size, or NULL. */
static void *grown(void *array, size_t count, size_t size) { return realloc(array, (count + 1) * size); }

static bool no_memory(const pbrt_site *site, io_error *error) { return pbrt_fail(site, error, "out of memory"); }

/* ---- Texture and Material ----------------------------------------------------------------------------------------- */

bool pbrt_texture_define(pbrt_state *p, const pbrt_site *site, io_error *error) {
    char *word[3] = {NULL, NULL, NULL}; /* name, type of value, class */
    pbrt_params params = {.count = 0};
    const char *filename = NULL;
    bool good = true;
    for (int k = 0; k < 3 && good; k++) good = (word[k] = pbrt_read_string(site, error)) != NULL;
    if (good && (strcmp(word[1], "color") != 0 || strcmp(word[2], "imagemap") != 0))
        good =
            pbrt_fail(site, error, "\"%s\" \"%s\" is not supported, only \"color\" \"imagemap\" is", word[1], word[2]);
    good = good && pbrt_params_read(&params, site, error) &&
           pbrt_param_string(&params, "string", "filename", &filename, error) && pbrt_params_all_used(&params, error);
    if (good && filename == NULL) good = pbrt_fail(site, error, "\"string filename\" is missing");

    pbrt_attributes *a = &p->attributes;
    if (good && a->texture_count == p->texture_capacity) {
        pbrt_texture *more = grown(p->textures, (size_t)p->texture_capacity, sizeof *more);
        good = more != NULL || no_memory(site, error);
        if (more != NULL) {
            p->textures = more;
            p->textures[p->texture_capacity++] = (pbrt_texture){0};
        }
    }
    if (good) {
        /* The place may hold a texture whose name went out of sight at an AttributeEnd. */
        pbrt_texture *t = &p->textures[a->texture_count];
        char place[300];
        snprintf(place, sizeof place, "%s:%zu", site->source->path, pbrt_line(site->source, site->offset));
        free(t->name);
        free(t->path);
        free(t->place);
        *t = (pbrt_texture){.name = word[0], .path = pbrt_resolve(p, filename), .place = strdup(place)};
        word[0] = NULL;
        good = (t->path != NULL && t->place != NULL) || no_memory(site, error);
        a->texture_count++;
    }
    pbrt_params_free(&params);
    for (int k = 0; k < 3; k++) free(word[k]);
    return good;
}

static bool use_texture(pbrt_state *p, const pbrt_site *site, const char *name, io_error *error) {
    for (int k = p->attributes.texture_count; k-- > 0;)
        if (strcmp(p->textures[k].name, name) == 0) {
            p->attributes.image = k;
            return true;
        }
    return pbrt_fail(site, error, "texture \"%s\" is not defined", name);
}

static bool read_material(pbrt_state *p, const pbrt_site *site, pbrt_params *params, io_error *error) {
    pbrt_attributes *a = &p->attributes;
    const char *image = NULL;
    double sigma = 0;
    a->image = -1;
    if (strcmp(params->class, "matte") == 0) {
        a->surface = (material){.kind = MATTE, .colour = {0.5f, 0.5f, 0.5f}};
        if (!pbrt_param_colour(params, "Kd", a->surface.colour, error) ||
            !pbrt_param_string(params, "texture", "Kd", &image, error) ||
            !pbrt_param_float(params, "sigma", &sigma, error))
            return false;
        if (sigma != 0) return pbrt_fail(site, error, "\"sigma\" must be 0");
    } else if (strcmp(params->class, "mirror") == 0) {
        a->surface = (material){.kind = MIRROR, .colour = {0.9f, 0.9f, 0.9f}};
        if (!pbrt_param_colour(params, "Kr", a->surface.colour, error)) return false;
    } else {
        return pbrt_fail(site, error, "\"%s\" is not supported, only \"matte\" and \"mirror\" are", params->class);
    }
    for (int c = 0; c < 3; c++)
        if (a->surface.colour[c] < 0) a->surface.colour[c] = 0;
    if (image != NULL && !use_texture(p, site, image, error)) return false;
    return pbrt_params_all_used(params, error);
}

bool pbrt_material(pbrt_state *p, const pbrt_site *site, io_error *error) {
    pbrt_params params = {.count = 0};
    const bool good = pbrt_class_read(&params, site, NULL, error) && read_material(p, site, &params, error);
    pbrt_params_free(&params);
    return good;
}

/* Reads a file that no other directive has needed before; else it is the scene's already. */
static bool read_image(pbrt_state *p, const pbrt_site *site, const pbrt_texture *t, texture **out, io_error *error) {
    struct stat about = {0};
    stat(t->path, &about); /* a missing file fails when it is read */
    const size_t count = p->scene->texture_count;
    for (size_t k = 0; k < count; k++)
        if (p->images[k].device == about.st_dev && p->images[k].inode == about.st_ino) {
            *out = p->images[k].image;
            return true;
        }
    texture **more = grown(p->scene->textures, count, sizeof *more);
    if (more != NULL) p->scene->textures = more;
    pbrt_image *images = grown(p->images, count, sizeof *images);
    if (images != NULL) p->images = images;
    texture *new = more != NULL &&images != NULL ? calloc(1, sizeof *new) : NULL;
    if (new == NULL) return no_memory(site, error);
    more[p->scene->texture_count++] = new; /* from here on the scene frees it */
    images[count] = (pbrt_image){about.st_dev, about.st_ino, new};

    io_image image;
    io_error why;
    if (!io_image_read(t->path, &image, &why)) return io_fail(error, "%s: Texture: %s", t->place, why.text);
    const size_t pixels = image.width * image.height;
    bool good = pixels <= IO_IMAGE_PIXELS_MAX - p->pixels ||
                io_fail(error, "%s: Texture: the scene's images have more than %d pixels in all", t->place,
                        IO_IMAGE_PIXELS_MAX);
    if (good && !texture_fill(new, &image))
        good = io_fail(error, "%s: Texture: %zu x %zu pixels are too many for their smaller copies", t->place,
                       image.width, image.height);
    if (!good) io_image_free(&image);
    p->pixels += pixels;
    *out = new;
    return good;
}

/* The current material for a shape; this is where its image is needed. */
static bool surface(pbrt_state *p, const pbrt_site *site, material *out, io_error *error) {
    *out = p->attributes.surface;
    if (p->attributes.image < 0 || p->fields_only) return true;
    pbrt_texture *t = &p->textures[p->attributes.image];
    if (t->image == NULL && !read_image(p, site, t, &t->image, error)) return false;
    out->image = t->image;
    return true;
}

/* ---- Shape -------------------------------------------------------------------------------------------------------- */

static bool create_field(const pbrt_state *p, const pbrt_site *site, heightfield *h, io_error *error) {
    cw_field_desc desc = {0};
    desc.samples = h->samples;
    desc.nx = h->nx;
    desc.ny = h->ny;
    desc.storage = CW_BORROW;
    if (!p->fields_only) {
        transform scale = transform_identity();
        scale.m[0][0] = 1 / (double)(h->nx - 1);
        scale.m[1][1] = 1 / (double)(h->ny - 1);
        const transform map = transform_multiply(&h->to_world, &scale);
        memcpy(desc.map, map.m, sizeof desc.map);
    }
    const cw_status status = cw_field_create(&desc, NULL, &h->field);
    return status == CW_OK || pbrt_fail(site, error, "%s", cw_last_error());
}

static bool add_heightfield(pbrt_state *p, const pbrt_site *site, pbrt_params *params, io_error *error) {
    long nu = 0, nv = 0;
    if (!pbrt_param_integer(params, "nu", 2, CW_SIDE_MAX, &nu, error) ||
        !pbrt_param_integer(params, "nv", 2, CW_SIDE_MAX, &nv, error))
        return false;
    pbrt_param *z = pbrt_param_find(params, "float", "Pz");
    if (nu == 0 || nv == 0 || z == NULL || z->floats == NULL)
        return pbrt_fail(site, error, "%s is missing",
                         nu == 0   ? "\"integer nu\""
                         : nv == 0 ? "\"integer nv\""
                                   : "\"float Pz\" with numbers");
    if (z->count != (size_t)nu * (size_t)nv)
        return pbrt_fail_at(site, z->offset, error, "\"float Pz\" has %zu values; nu %ld times nv %ld are %zu",
                            z->count, nu, nv, (size_t)nu * (size_t)nv);
    if (!pbrt_params_all_used(params, error)) return false;

    heightfield *more = grown(p->scene->heightfields, p->scene->heightfield_count, sizeof *more);
    if (more == NULL) return no_memory(site, error);
    p->scene->heightfields = more;
    heightfield *h = &more[p->scene->heightfield_count];
    *h = (heightfield){.nx = (size_t)nu, .ny = (size_t)nv, .to_world = p->attributes.current};
    if (!surface(p, site, &h->surface, error)) return false;
    h->samples = z->floats;
    z->floats = NULL;
    p->scene->heightfield_count++; /* from here on the scene frees it */
    return create_field(p, site, h, error);
}

static bool add_cylinder(pbrt_state *p, const pbrt_site *site, pbrt_params *params, io_error *error) {
    if (!pbrt_params_all_used(params, error)) return false;
    cylinder c = {.to_world = p->attributes.current};
    transform to_object;
    if (!transform_invert(&c.to_world, &to_object))
        return pbrt_fail(site, error, "the current transform cannot be inverted");
    if (!surface(p, site, &c.surface, error)) return false;
    cylinder *more = grown(p->scene->cylinders, p->scene->cylinder_count, sizeof *more);
    if (more == NULL) return no_memory(site, error);
    p->scene->cylinders = more;
    more[p->scene->cylinder_count++] = c;
    return true;
}

bool pbrt_shape(pbrt_state *p, const pbrt_site *site, io_error *error) {
    char *class = pbrt_read_string(site, error);
    if (class == NULL) return false;
    char name[64];
    snprintf(name, sizeof name, "%s \"%s\"", site->name, class);
    const pbrt_site shape = {site->source, site->offset, name};
    pbrt_params params = {.count = 0};
    bool good;
    if (strcmp(class, "heightfield") != 0 && strcmp(class, "cylinder") != 0)
        good = pbrt_fail(site, error, "\"%s\" is not supported, only \"heightfield\" and \"cylinder\" are", class);
    else
        good = pbrt_params_read(&params, &shape, error) &&
               (class[0] == 'h' ? add_heightfield(p, &shape, &params, error) : add_cylinder(p, &shape, &params, error));
    pbrt_params_free(&params);
    free(class);
    return good;
}

/* ---- LightSource -------------------------------------------------------------------------------------------------- */

bool pbrt_light(pbrt_state *p, const pbrt_site *site, io_error *error) {
    pbrt_params params = {.count = 0};
    point_light light = {.intensity = {1, 1, 1}};
    const bool good = pbrt_class_read(&params, site, "point", error) &&
                      pbrt_param_colour(&params, "I", light.intensity, error) && pbrt_params_all_used(&params, error);
    pbrt_params_free(&params);
    if (!good) return false;
    transform_point(&p->attributes.current, (double[3]){0, 0, 0}, light.position);
    point_light *more = grown(p->scene->lights, p->scene->light_count, sizeof *more);
    if (more == NULL) return no_memory(site, error);
    p->scene->lights = more;
    more[p->scene->light_count++] = light;
    return true;
}
