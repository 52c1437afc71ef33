/* SPDX-License-Identifier: Apache-2.0 */
/* The words of one vocabulary, for tests/core/vocabulary.c. Built once for each row of simd/isas.cmake, and once more
 * in vectors of two registers. */

#include "vocabulary.h"

#include "words.h"

#include <string.h>

/* Lanes lie in vectors as in memory, which makes these independent of the words that load and store. Masks have no such
 * form: vm_from_bits and vm_bits carry them. */
#define CARRY(vector, lane, name)                                                                                      \
    _Static_assert(sizeof(vector) == sizeof(lane[LANES]), "vectors hold more than their lanes");                       \
    static inline void put_##name(lane *to, vector a) { memcpy(to, &a, sizeof a); }                                    \
    static inline vector get_##name(const lane *from) {                                                                \
        vector a;                                                                                                      \
        memcpy(&a, from, sizeof a);                                                                                    \
        return a;                                                                                                      \
    }
CARRY(vfloat, float, floats)
CARRY(vint, int32_t, ints)
CARRY(vdouble, double, doubles)
static inline vmask get_mask(const bool *from) {
    unsigned bits = 0;
    for (unsigned k = 0; k < LANES; k++) bits |= (unsigned)from[k] << k;
    return vm_from_bits(bits);
}
static inline void put_mask(uint8_t *to, vmask a) {
    const unsigned bits = vm_bits(a);
    for (unsigned k = 0; k < LANES; k++) to[k] = bits >> k & 1;
}

/* A place in memory with room for the rows of a block on both sides, not aligned. */
static inline const float *block(const word_in *in) { return in->memory + 66; }

#define FLOATS(operand)    get_floats(in->operand + at)
#define INTS(operand)      get_ints(in->operand + at)
#define DOUBLES(operand)   get_doubles(in->wide[operand] + at)
#define MASK(operand)      get_mask(in->mask[operand] + at)
#define TO_FLOATS(result)  put_floats(out->f[0] + at, result)
#define TO_INTS(result)    put_ints(out->i + at, result)
#define TO_DOUBLES(result) put_doubles(out->d + at, result)
#define TO_MASK(result)    put_mask(out->m + at, result)
#define TO_EACH_FLOATS(r, count)                                                                                       \
    for (int k = 0; k < count; k++) put_floats(out->f[k] + at, r[k])

#define WORD(name, result, ...)                                                                                        \
    static void run_##name(const word_in *in, word_out *out, size_t at) {                                              \
        (void)at;                                                                                                      \
        __VA_ARGS__;                                                                                                   \
    }
#include "words.inc.h"
#undef WORD

#define WORD(name, result, ...) {#name, result, run_##name},
static const word words[] = {
#include "words.inc.h"
};
#undef WORD

extern const word_row WORDS_ROW;
const word_row WORDS_ROW = {WORDS_SUFFIX, LANES, sizeof words / sizeof words[0], words};
