/* SPDX-License-Identifier: Apache-2.0 */
#include "pbrt_params.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool pbrt_fail_at(const pbrt_site *site, size_t offset, io_error *error, const char *format, ...) {
    char text[400];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return io_fail(error, "%s:%zu: %s%s%s", site->source->path, pbrt_line(site->source, offset), site->name,
                   site->name[0] ? ": " : "", text);
}

char *pbrt_read_string(const pbrt_site *site, io_error *error) {
    const pbrt_token token = pbrt_next(site->source);
    char *text = token.kind == PBRT_STRING ? strndup(token.start, token.length) : NULL;
    if (token.kind != PBRT_STRING)
        pbrt_fail_at(site, token.offset, error, "%s", token.kind == PBRT_BAD ? token.problem : "a string is expected");
    else if (text == NULL)
        pbrt_fail(site, error, "out of memory");
    return text;
}

/* Splits "float Pz" into type and name. */
static bool declare(pbrt_param *param, const pbrt_token *token) {
    char text[64];
    if (token->length >= sizeof text) return false;
    memcpy(text, token->start, token->length);
    text[token->length] = '\0';
    char rest[2];
    return sscanf(text, "%15s %31s %1s", param->type, param->name, rest) == 2;
}

/* Makes room for one more value at least; *capacity is how many floats there is room for. */
static bool make_room(pbrt_param *param, size_t *capacity) {
    if (param->count < *capacity) return true;
    const size_t more = *capacity ? *capacity * 2 : 4;
    float *floats = realloc(param->floats, more * sizeof *floats);
    if (floats == NULL) return false;
    param->floats = floats;
    *capacity = more;
    return true;
}

/* Takes one value into the parameter; all of a list must be of one kind. */
static bool take_value(pbrt_params *params, pbrt_param *param, const pbrt_token *token, size_t *capacity,
                       io_error *error) {
    const pbrt_site *site = &params->site;
    if (token->kind == PBRT_STRING && param->floats == NULL) {
        if (param->count++ > 0) return true;
        param->text = strndup(token->start, token->length);
        return param->text != NULL || pbrt_fail_at(site, token->offset, error, "out of memory");
    }
    if (token->kind == PBRT_NUMBER && param->text == NULL) {
        const float value = pbrt_float(token);
        if (!isfinite(value))
            return pbrt_fail_at(site, token->offset, error, "\"%s\": %.*s is too large for a float", param->name,
                                (int)(token->length < 40 ? token->length : 40), token->start);
        if (param->count == 0) param->first = token->number;
        if (!make_room(param, capacity)) return pbrt_fail_at(site, token->offset, error, "out of memory");
        param->floats[param->count++] = value;
        return true;
    }
    if (token->kind == PBRT_BAD)
        return pbrt_fail_at(site, token->offset, error, "\"%s\": %s", param->name, token->problem);
    if (token->kind == PBRT_END)
        return pbrt_fail_at(site, token->offset, error, "\"%s\": the file ends within its values", param->name);
    return pbrt_fail_at(site, token->offset, error, "\"%s\": value %zu is not a %s but %.*s", param->name,
                        param->count + 1, param->text ? "string" : "number",
                        (int)(token->length < 40 ? token->length : 40), token->start);
}

static bool read_values(pbrt_params *params, pbrt_param *param, pbrt_source *s, io_error *error) {
    size_t capacity = 0;
    pbrt_token token = pbrt_next(s);
    if (token.kind != PBRT_OPEN) return take_value(params, param, &token, &capacity, error);
    for (token = pbrt_next(s); token.kind != PBRT_CLOSE; token = pbrt_next(s)) {
        if (!take_value(params, param, &token, &capacity, error)) return false;
        if (token.kind != PBRT_NUMBER) continue;
        while (make_room(param, &capacity)) {
            const size_t taken = pbrt_plain_floats(s, param->floats + param->count, capacity - param->count);
            param->count += taken;
            if (taken == 0 || param->count < capacity) break;
        }
    }
    return true;
}

bool pbrt_params_read(pbrt_params *params, const pbrt_site *site, io_error *error) {
    pbrt_source *s = site->source;
    params->site = *site;
    params->count = 0;
    for (;;) {
        const size_t before = s->at;
        const pbrt_token token = pbrt_next(s);
        if (token.kind == PBRT_BAD) return pbrt_fail_at(site, token.offset, error, "%s", token.problem);
        if (token.kind != PBRT_STRING) {
            s->at = before;
            return true;
        }
        if (params->count == PBRT_PARAMS_MAX) return pbrt_fail_at(site, token.offset, error, "too many parameters");
        pbrt_param *param = &params->list[params->count];
        *param = (pbrt_param){.offset = token.offset};
        if (!declare(param, &token))
            return pbrt_fail_at(site, token.offset, error, "\"%.*s\" is no parameter: \"type name\" is expected",
                                (int)(token.length < 40 ? token.length : 40), token.start);
        params->count++;
        for (int k = 0; k + 1 < params->count; k++)
            if (strcmp(params->list[k].name, param->name) == 0 && strcmp(params->list[k].type, param->type) == 0)
                return pbrt_fail_at(site, token.offset, error, "\"%s\" is given twice", param->name);
        if (!read_values(params, param, s, error)) return false;
    }
}

bool pbrt_class_read(pbrt_params *params, const pbrt_site *site, const char *class, io_error *error) {
    params->class = pbrt_read_string(site, error);
    if (params->class == NULL) return false;
    if (class != NULL && strcmp(params->class, class) != 0)
        return pbrt_fail(site, error, "\"%s\" is not supported, only \"%s\" is", params->class, class);
    return pbrt_params_read(params, site, error);
}

void pbrt_params_free(pbrt_params *params) {
    for (int k = 0; k < params->count; k++) {
        free(params->list[k].floats);
        free(params->list[k].text);
    }
    params->count = 0;
    free(params->class);
}

pbrt_param *pbrt_param_find(pbrt_params *params, const char *type, const char *name) {
    for (int k = 0; k < params->count; k++) {
        pbrt_param *param = &params->list[k];
        if (strcmp(param->type, type) != 0 || strcmp(param->name, name) != 0) continue;
        param->used = true;
        return param;
    }
    return NULL;
}

static bool wrong(const pbrt_params *params, const pbrt_param *param, io_error *error, const char *expected) {
    return pbrt_fail_at(&params->site, param->offset, error, "\"%s %s\" must be %s", param->type, param->name,
                        expected);
}

bool pbrt_param_integer(pbrt_params *params, const char *name, long low, long high, long *value, io_error *error) {
    const pbrt_param *param = pbrt_param_find(params, "integer", name);
    if (param == NULL) return true;
    char expected[64];
    snprintf(expected, sizeof expected, "a whole number from %ld to %ld", low, high);
    if (param->count != 1 || param->floats == NULL || param->first != floor(param->first) ||
        param->first < (double)low || param->first > (double)high)
        return wrong(params, param, error, expected);
    *value = (long)param->first;
    return true;
}

bool pbrt_param_float(pbrt_params *params, const char *name, double *value, io_error *error) {
    const pbrt_param *param = pbrt_param_find(params, "float", name);
    if (param == NULL) return true;
    if (param->count != 1 || param->floats == NULL) return wrong(params, param, error, "one number");
    *value = param->first;
    return true;
}

bool pbrt_param_colour(pbrt_params *params, const char *name, float value[3], io_error *error) {
    const pbrt_param *param = pbrt_param_find(params, "color", name);
    if (param == NULL) param = pbrt_param_find(params, "rgb", name);
    if (param == NULL) return true;
    if (param->count != 3 || param->floats == NULL) return wrong(params, param, error, "three numbers");
    memcpy(value, param->floats, 3 * sizeof *value);
    return true;
}

bool pbrt_param_string(pbrt_params *params, const char *type, const char *name, const char **value, io_error *error) {
    const pbrt_param *param = pbrt_param_find(params, type, name);
    if (param == NULL) return true;
    if (param->count != 1 || param->text == NULL) return wrong(params, param, error, "one string");
    *value = param->text;
    return true;
}

bool pbrt_params_all_used(const pbrt_params *params, io_error *error) {
    for (int k = 0; k < params->count; k++)
        if (!params->list[k].used)
            return pbrt_fail_at(&params->site, params->list[k].offset, error, "parameter \"%s %s\" is not supported",
                                params->list[k].type, params->list[k].name);
    return true;
}
