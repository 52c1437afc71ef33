/* SPDX-License-Identifier: Apache-2.0 */
/* Shape, LightSource, Material and Texture. */

#include "pbrt_state.h"

#include <stdlib.h>
#include <string.h>

/* array with room for one more element of this size, or NULL. */
static void *grown(void *array, size_t count, size_t size) { return realloc(array, (count + 1) * size); }

static bool no_memory(const pbrt_site *site, io_error *error) { return pbrt_fail(site, error, "out of memory"); }

/* ---- Texture and Material ---------------------------------------------------------------------------------------- */

/* The image becomes the scene's. */
static bool read_image(pbrt_state *p, const pbrt_site *site, const char *filename, texture **out, io_error *error) {
    scene *s = p->scene;
    texture **more = grown(s->textures, s->texture_count, sizeof *more);
    if (more == NULL) return no_memory(site, error);
    s->textures = more;
    texture *new = calloc(1, sizeof *new);
    char *path = pbrt_resolve(p, filename);
    if (new == NULL || path == NULL) {
        free(new);
        free(path);
        return no_memory(site, error);
    }
    *out = more[s->texture_count++] = new;
    io_image image;
    io_error why;
    const size_t left = IO_IMAGE_PIXELS_MAX - p->pixels;
    const bool read = io_image_read(path, left, &image, &why) || pbrt_fail(site, error, "%s", why.text);
    free(path);
    if (!read) return false;
    p->pixels += image.width * image.height;
    if (texture_fill(new, &image)) return true;
    pbrt_fail(site, error, "%zu x %zu pixels are too many for their smaller copies", image.width, image.height);
    io_image_free(&image);
    return false;
}

bool pbrt_texture_define(pbrt_state *p, const pbrt_site *site, io_error *error) {
    char *word[3] = {NULL, NULL, NULL}; /* name, type of value, class */
    pbrt_params params = {.count = 0};
    const char *filename = NULL;
    texture *image = NULL;
    bool good = true;
    for (int k = 0; k < 3 && good; k++) good = (word[k] = pbrt_read_string(site, error)) != NULL;
    if (good && (strcmp(word[1], "color") != 0 || strcmp(word[2], "imagemap") != 0))
        good =
            pbrt_fail(site, error, "\"%s\" \"%s\" is not supported, only \"color\" \"imagemap\" is", word[1], word[2]);
    good = good && pbrt_params_read(&params, site, error) &&
           pbrt_param_string(&params, "string", "filename", &filename, error) && pbrt_params_all_used(&params, error);
    if (good && filename == NULL) good = pbrt_fail(site, error, "\"string filename\" is missing");
    good = good && read_image(p, site, filename, &image, error);

    const int count = p->attributes.texture_count;
    if (good && count == p->texture_capacity) {
        pbrt_texture *more = grown(p->textures, (size_t)count, sizeof *more);
        good = more != NULL || no_memory(site, error);
        if (more != NULL) {
            p->textures = more;
            p->textures[p->texture_capacity++] = (pbrt_texture){0};
        }
    }
    if (good) {
        free(p->textures[count].name); /* one that went out of sight at an AttributeEnd */
        p->textures[count] = (pbrt_texture){word[0], image};
        p->attributes.texture_count++;
        word[0] = NULL;
    }
    pbrt_params_free(&params);
    for (int k = 0; k < 3; k++) free(word[k]);
    return good;
}

static bool use_texture(pbrt_state *p, const pbrt_site *site, const char *name, io_error *error) {
    for (int k = p->attributes.texture_count; k-- > 0;)
        if (strcmp(p->textures[k].name, name) == 0) {
            p->attributes.surface.image = p->textures[k].image;
            return true;
        }
    return pbrt_fail(site, error, "texture \"%s\" is not defined", name);
}

static bool read_material(pbrt_state *p, const pbrt_site *site, pbrt_params *params, io_error *error) {
    pbrt_attributes *a = &p->attributes;
    const char *image = NULL;
    double sigma = 0;
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

/* ---- Shape ------------------------------------------------------------------------------------------------------- */

static bool create_field(const pbrt_site *site, heightfield *h, io_error *error) {
    cw_field_desc desc = {0};
    desc.samples = h->samples;
    desc.nx = h->nx;
    desc.ny = h->ny;
    desc.storage = CW_BORROW;
    transform scale = transform_identity();
    scale.m[0][0] = 1 / (double)(h->nx - 1);
    scale.m[1][1] = 1 / (double)(h->ny - 1);
    const transform map = transform_multiply(&h->to_world, &scale);
    memcpy(desc.map, map.m, sizeof desc.map);
    const cw_status status = cw_field_create(&desc, NULL, &h->field);
    if (status != CW_OK) return pbrt_fail(site, error, "%s", cw_last_error());
    return pbrt_measurable(site, &map, "field space", error);
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
    *h = (heightfield){.nx = (size_t)nu,
                       .ny = (size_t)nv,
                       .samples = z->floats,
                       .to_world = p->attributes.current,
                       .surface = p->attributes.surface};
    z->floats = NULL;
    p->scene->heightfield_count++; /* from here on the scene frees it */
    return create_field(site, h, error);
}

static bool add_cylinder(pbrt_state *p, const pbrt_site *site, pbrt_params *params, io_error *error) {
    if (!pbrt_params_all_used(params, error)) return false;
    const cylinder c = {p->attributes.current, p->attributes.surface};
    transform to_object;
    if (!transform_invert(&c.to_world, &to_object))
        return pbrt_fail(site, error, "the current transform cannot be inverted");
    if (!pbrt_measurable(site, &c.to_world, "the cylinder's space", error)) return false;
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

/* ---- LightSource ------------------------------------------------------------------------------------------------- */

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
