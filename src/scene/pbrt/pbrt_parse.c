/* SPDX-License-Identifier: Apache-2.0 */
/* The directives of a .pbrt file, except those that put something into the world. A directive that is not known is an
 * error and not a guess: a picture without a part of the file would be wrong without a message. */

#include "pbrt_state.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static bool parse_file(pbrt_state *p, const char *path, io_error *error);

static void warn_at(pbrt_state *p, const pbrt_site *site, size_t offset, const char *text) {
    if (p->warn == NULL || p->warnings > PBRT_WARNINGS_MAX) return;
    io_error message;
    if (p->warnings++ < PBRT_WARNINGS_MAX)
        pbrt_fail_at(site, offset, &message, "%s", text);
    else
        io_fail(&message, "further warnings are not printed");
    p->warn(p->warn_context, message.text);
}

static bool read_numbers(const pbrt_site *site, int count, double *numbers, io_error *error) {
    for (int k = 0; k < count; k++) {
        const pbrt_token token = pbrt_next(site->source);
        if (token.kind != PBRT_NUMBER)
            return pbrt_fail_at(site, token.offset, error, "%s: number %d of %d is expected",
                                token.kind == PBRT_BAD   ? token.problem
                                : token.kind == PBRT_END ? "the file ends"
                                                         : "not a number",
                                k + 1, count);
        if (!isfinite(token.number)) return pbrt_fail(site, error, "a number is too large");
        numbers[k] = token.number;
    }
    return true;
}

char *pbrt_resolve(const pbrt_state *p, const char *name) {
    const char *directory = name[0] == '/' ? "" : p->directory;
    const size_t size = strlen(directory) + strlen(name) + 1;
    char *path = malloc(size);
    if (path != NULL) snprintf(path, size, "%s%s", directory, name);
    return path;
}

bool pbrt_measurable(const pbrt_site *site, const transform *to_world, const char *space, io_error *error) {
    return transform_is_measurable(to_world) ||
           pbrt_fail(site, error, "a unit of %s is shorter than 1e-18 or longer than 1e18 in the world", space);
}

/* ---- transforms -------------------------------------------------------------------------------------------------- */

static bool apply(pbrt_state *p, const transform *t) {
    p->attributes.current = transform_multiply(&p->attributes.current, t);
    return true;
}

static bool translate(pbrt_state *p, const pbrt_site *site, io_error *error) {
    double by[3];
    if (!read_numbers(site, 3, by, error)) return false;
    transform t = transform_identity();
    for (int r = 0; r < 3; r++) t.m[r][3] = by[r];
    return apply(p, &t);
}

static bool scale(pbrt_state *p, const pbrt_site *site, io_error *error) {
    double by[3];
    if (!read_numbers(site, 3, by, error)) return false;
    transform t = transform_identity();
    for (int r = 0; r < 3; r++) t.m[r][r] = by[r];
    return apply(p, &t);
}

/* Rodrigues: counterclockwise in a right-handed system, clockwise in the left-handed one of these files. */
static bool rotate(pbrt_state *p, const pbrt_site *site, io_error *error) {
    double n[4];
    if (!read_numbers(site, 4, n, error)) return false;
    double *axis = n + 1;
    if (axis[0] == 0 && axis[1] == 0 && axis[2] == 0) return pbrt_fail(site, error, "the axis has no length");
    normalise(axis);
    const double angle = n[0] * (acos(-1) / 180), c = cos(angle), s = sin(angle);
    const double turn[3][3] = {{0, -axis[2], axis[1]}, {axis[2], 0, -axis[0]}, {-axis[1], axis[0], 0}};
    transform t = transform_identity();
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) t.m[i][j] = (i == j ? c : 0) + (1 - c) * axis[i] * axis[j] + s * turn[i][j];
    return apply(p, &t);
}

static bool look_at(pbrt_state *p, const pbrt_site *site, io_error *error) {
    double n[9];
    if (!read_numbers(site, 9, n, error)) return false;
    double direction[3], left[3], up[3];
    for (int c = 0; c < 3; c++) direction[c] = n[3 + c] - n[c];
    normalise(direction);
    cross(n + 6, direction, left);
    normalise(left);
    cross(direction, left, up);
    transform camera, world;
    for (int r = 0; r < 3; r++) {
        camera.m[r][0] = left[r];
        camera.m[r][1] = up[r];
        camera.m[r][2] = direction[r];
        camera.m[r][3] = n[r];
    }
    if (!transform_invert(&camera, &world))
        return pbrt_fail(site, error, "eye and target coincide, or the up vector lies along the view");
    return apply(p, &world);
}

static bool coord_sys_transform(pbrt_state *p, const pbrt_site *site, io_error *error) {
    char *name = pbrt_read_string(site, error);
    if (name == NULL) return false;
    const bool camera = strcmp(name, "camera") == 0;
    free(name);
    if (!camera) return pbrt_fail(site, error, "only \"camera\" is supported");
    if (!p->camera) return pbrt_fail(site, error, "no Camera has been set");
    p->attributes.current = p->scene->camera_to_world;
    return true;
}

/* ---- before the world -------------------------------------------------------------------------------------------- */

static bool film(pbrt_state *p, const pbrt_site *site, io_error *error) {
    enum { SIDE_MAX = 65536 };
    pbrt_params params = {.count = 0};
    long width = 640, height = 480;
    const char *filename = NULL; /* not used: the program's option says where to write */
    bool good = pbrt_class_read(&params, site, "image", error) &&
                pbrt_param_integer(&params, "xresolution", 1, SIDE_MAX, &width, error) &&
                pbrt_param_integer(&params, "yresolution", 1, SIDE_MAX, &height, error) &&
                pbrt_param_string(&params, "string", "filename", &filename, error);
    if (good && width > IO_IMAGE_PIXELS_MAX / height)
        good = pbrt_fail(site, error, "%ld x %ld pixels are more than %d", width, height, IO_IMAGE_PIXELS_MAX);
    const pbrt_param *display = good ? pbrt_param_find(&params, "bool", "display") : NULL;
    if (display != NULL) warn_at(p, site, display->offset, "\"bool display\" is skipped");
    good = good && pbrt_params_all_used(&params, error);
    if (good) {
        p->scene->width = (size_t)width;
        p->scene->height = (size_t)height;
    }
    pbrt_params_free(&params);
    return good;
}

/* Of any sampler only the number of samples counts: patterns differ in noise alone. */
static bool sampler(pbrt_state *p, const pbrt_site *site, io_error *error) {
    enum { SAMPLES_MAX = 65536 };
    pbrt_params params = {.count = 0};
    long samples = 4;
    const bool good = pbrt_class_read(&params, site, NULL, error) &&
                      pbrt_param_integer(&params, "pixelsamples", 1, SAMPLES_MAX, &samples, error) &&
                      pbrt_params_all_used(&params, error);
    if (good && strcmp(params.class, "bestcandidate") != 0)
        warn_at(p, site, site->offset, "only the number of samples is taken from it");
    if (good) p->scene->samples = (unsigned)samples;
    pbrt_params_free(&params);
    return good;
}

static bool camera(pbrt_state *p, const pbrt_site *site, io_error *error) {
    pbrt_params params = {.count = 0};
    double degrees = 90;
    bool good = pbrt_class_read(&params, site, "perspective", error) &&
                pbrt_param_float(&params, "fov", &degrees, error) && pbrt_params_all_used(&params, error);
    pbrt_params_free(&params);
    if (good && !(degrees > 0 && degrees < 180))
        good = pbrt_fail(site, error, "\"float fov\" must lie between 0 and 180 degrees");
    if (good && !transform_invert(&p->attributes.current, &p->scene->camera_to_world))
        good = pbrt_fail(site, error, "the current transform cannot be inverted");
    if (!good || !pbrt_measurable(site, &p->scene->camera_to_world, "the camera's space", error)) return false;
    p->scene->field_of_view = degrees;
    p->camera = true;
    return true;
}

static bool skip(pbrt_state *p, const pbrt_site *site, io_error *error) {
    pbrt_params params = {.count = 0};
    const bool good = pbrt_class_read(&params, site, NULL, error);
    if (good) warn_at(p, site, site->offset, "skipped; it changes neither geometry nor light");
    pbrt_params_free(&params);
    return good;
}

/* ---- structure --------------------------------------------------------------------------------------------------- */

static bool world_begin(pbrt_state *p, const pbrt_site *site, io_error *error) {
    if (!p->camera) return pbrt_fail(site, error, "no Camera has been set");
    p->world = true;
    p->attributes.current = transform_identity();
    return true;
}

static bool world_end(pbrt_state *p, const pbrt_site *site, io_error *error) {
    if (p->depth > 0) return pbrt_fail(site, error, "an AttributeBegin has no AttributeEnd");
    p->world = false;
    p->ended = true;
    return true;
}

static bool attribute_begin(pbrt_state *p, const pbrt_site *site, io_error *error) {
    if (p->depth == PBRT_DEPTH_MAX) return pbrt_fail(site, error, "too many levels");
    p->saved[p->depth++] = p->attributes;
    return true;
}

static bool attribute_end(pbrt_state *p, const pbrt_site *site, io_error *error) {
    if (p->depth == 0) return pbrt_fail(site, error, "there is no AttributeBegin for it");
    p->attributes = p->saved[--p->depth];
    return true;
}

static bool include(pbrt_state *p, const pbrt_site *site, io_error *error) {
    char *name = pbrt_read_string(site, error);
    if (name == NULL) return false;
    char *path = pbrt_resolve(p, name);
    free(name);
    if (path == NULL) return pbrt_fail(site, error, "out of memory");
    struct stat status;
    bool good = true;
    if (stat(path, &status) != 0) good = pbrt_fail(site, error, "%s: cannot read: %s", path, strerror(errno));
    for (int k = 0; good && k < p->open_count; k++)
        if (p->open[k].device == status.st_dev && p->open[k].inode == status.st_ino)
            good = pbrt_fail(site, error, "%s includes itself", path);
    if (good && p->open_count == PBRT_INCLUDE_MAX) good = pbrt_fail(site, error, "too many levels");
    if (good && p->files == PBRT_FILES_MAX)
        good = pbrt_fail(site, error, "more than %d files are included", PBRT_FILES_MAX);
    if (good && p->bytes + (uint64_t)status.st_size > pbrt_bytes_max)
        good = pbrt_fail(site, error, "more than %llu bytes are included", (unsigned long long)pbrt_bytes_max);
    good = good && parse_file(p, path, error);
    free(path);
    return good;
}

/* Where a directive may stand. */
enum { OUTSIDE = 1, INSIDE = 2, ANYWHERE = 3 };

static const struct directive {
    const char *name;
    pbrt_directive_fn *run;
    int where;
} directives[] = {
    {"Accelerator", skip, OUTSIDE},
    {"AttributeBegin", attribute_begin, INSIDE},
    {"AttributeEnd", attribute_end, INSIDE},
    {"Camera", camera, OUTSIDE},
    {"CoordSysTransform", coord_sys_transform, ANYWHERE},
    {"Film", film, OUTSIDE},
    {"Include", include, ANYWHERE},
    {"LightSource", pbrt_light, INSIDE},
    {"LookAt", look_at, ANYWHERE},
    {"Material", pbrt_material, INSIDE},
    {"Rotate", rotate, ANYWHERE},
    {"Sampler", sampler, OUTSIDE},
    {"Scale", scale, ANYWHERE},
    {"Shape", pbrt_shape, INSIDE},
    {"Texture", pbrt_texture_define, INSIDE},
    {"Translate", translate, ANYWHERE},
    {"WorldBegin", world_begin, OUTSIDE},
    {"WorldEnd", world_end, INSIDE},
};

static bool run_directive(pbrt_state *p, pbrt_source *s, const pbrt_token *token, io_error *error) {
    char name[41];
    snprintf(name, sizeof name, "%.*s", (int)(token->length < 40 ? token->length : 40), token->start);
    pbrt_site site = {s, token->offset, name};
    if (token->kind != PBRT_WORD)
        return pbrt_fail(&site, error, "%s", token->kind == PBRT_BAD ? token->problem : "a directive is expected");
    for (size_t k = 0; k < sizeof directives / sizeof directives[0]; k++) {
        const struct directive *d = &directives[k];
        if (strcmp(d->name, name) != 0) continue;
        site.name = d->name;
        if (p->ended) return pbrt_fail(&site, error, "nothing may follow WorldEnd");
        if (!(d->where & (p->world ? INSIDE : OUTSIDE)))
            return pbrt_fail(&site, error,
                             p->world ? "it must stand before WorldBegin" : "it must stand after WorldBegin");
        return d->run(p, &site, error);
    }
    return pbrt_fail(&site, error, "this directive is not supported");
}

static bool parse_file(pbrt_state *p, const char *path, io_error *error) {
    struct stat status = {0};
    pbrt_source s;
    if (!pbrt_source_open(&s, path, error)) return false;
    stat(path, &status); /* of a file that could just be read; if not, it counts as none that is open */
    p->open[p->open_count].device = status.st_dev;
    p->open[p->open_count].inode = status.st_ino;
    p->open_count++;
    p->files++;
    p->bytes += s.size;
    bool good = true;
    for (pbrt_token token = pbrt_next(&s); good && token.kind != PBRT_END; token = pbrt_next(&s))
        good = run_directive(p, &s, &token, error);
    p->open_count--;
    pbrt_source_close(&s);
    return good;
}

bool pbrt_parse(const char *path, scene *s, scene_warn_fn *warn, void *warn_context, io_error *error) {
    pbrt_state *p = calloc(1, sizeof *p);
    if (p == NULL) return io_fail(error, "%s: out of memory", path);
    p->scene = s;
    p->warn = warn;
    p->warn_context = warn_context;
    p->attributes =
        (pbrt_attributes){.current = transform_identity(), .surface = {.kind = MATTE, .colour = {0.5f, 0.5f, 0.5f}}};
    s->samples = 4;
    s->width = 640;
    s->height = 480;

    const char *slash = strrchr(path, '/');
    p->directory = strndup(path, slash ? (size_t)(slash - path) + 1 : 0);
    bool good = p->directory != NULL || io_fail(error, "%s: out of memory", path);
    good = good && parse_file(p, path, error);
    if (good && !p->ended) good = io_fail(error, "%s: the file ends without WorldEnd", path);

    for (int k = 0; k < p->texture_capacity; k++) free(p->textures[k].name);
    free(p->textures);
    free(p->directory);
    free(p);
    return good;
}
