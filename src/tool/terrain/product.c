/* SPDX-License-Identifier: Apache-2.0 */
#include "product.h"

#include "command.h"

#include <stdlib.h>
#include <string.h>

int product_run(const product_command *p, const options_usage *usage, int argc, char **argv) {
    static const char *const operands[] = {"DEM"};
    option_spec options[PRODUCT_OPTIONS_MOST + PIECES_OPTION_COUNT + GROUND_OPTION_COUNT];
    option_spec *shared = options + usage->option_count;
    memcpy(options, usage->options, usage->option_count * sizeof *options);
    pieces_rows(p->ground, shared);
    ground_rows(p->ground, usage->name, shared + PIECES_OPTION_COUNT);
    options_usage all = *usage;
    all.options = options;
    all.option_count += PIECES_OPTION_COUNT + GROUND_OPTION_COUNT;
    all.operands = operands;
    all.operand_least = all.operand_most = 1;

    const char *path;
    size_t bands = 1;
    const int status = options_parse(&all, argc, argv, &path);
    if (status != OPTIONS_GO) return status;
    if (!p->check(p->context, &bands)) return EXIT_USAGE;
    ground g;
    io_error error = {""};
    const int opened = ground_open(&g, p->ground, path, bands, bands > 0 ? GROUND_PIECES : GROUND_SAMPLES);
    return opened == EXIT_SUCCESS ? ground_close(&g, p->make(p->context, &g, &error), &error) : opened;
}
