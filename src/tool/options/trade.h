/* SPDX-License-Identifier: Apache-2.0 */
/* What choices of speed gain and cost, for the help of commands. The figures are those of papers/tradeoff.md, of commit dcb5604a15. */
/* clang-format off */
#ifndef CELLWALK_TOOL_OPTIONS_TRADE_H
#define CELLWALK_TOOL_OPTIONS_TRADE_H

#define TRADE_TRACE \
    "To save time, measured on rough terrain of 32769 x 32769 samples\n" \
    "(papers/tradeoff.md): --coarser 2 makes rays 1.5 times as fast, with distances\n" \
    "off by 0.0028 % (99 % of them: 0.063 %), --coarser 8 3 times and 0.017 % (99 %\n" \
    "of them: 0.55 %).\n"

#define TRADE_RENDER \
    "To save time, measured on rough terrain of 32769 x 32769 samples\n" \
    "(papers/tradeoff.md): --coarser 2 makes rays 1.5 times as fast, with distances\n" \
    "off by 0.0028 % (99 % of them: 0.063 %), --coarser 8 3 times and 0.017 % (99 %\n" \
    "of them: 0.55 %). With 4 samples a pixel a picture takes 1/12 of the time of 64,\n" \
    "and its RMS error is 0.01 instead of 0.001, with 16 1/3.9 and 0.0032.\n"

#define TRADE_HORIZON \
    "To save time (papers/tradeoff.md): for --svf, 16 directions take 1/3.5 of the\n" \
    "time of 64, and 99 % of the factors are off by at most 0.002. --coarser costs\n" \
    "more error than it is worth here.\n"

#endif
