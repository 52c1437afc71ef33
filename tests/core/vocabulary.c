/* SPDX-License-Identifier: Apache-2.0 */
/* Every word of every vector vocabulary that this CPU can run gives, lane by lane, what vec_scalar.h gives: on random
 * bits, NaN, infinities, denormals, zeros of both signs, and whatever lies in inactive lanes. */

#include "cellwalk_expert.h"
#include "check.h"
#include "vocabulary/words.h"
#include "workload/random.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* VOCABULARY_ROWS: ROW(4) ROW(4x2) …, all but the scalar one (support/vocabulary.cmake). */
#define ROW(suffix) extern const word_row cw_words_##suffix;
ROW(1)
VOCABULARY_ROWS
#undef ROW
#define ROW(suffix) &cw_words_##suffix,
static const word_row *const rows[] = {VOCABULARY_ROWS};
#undef ROW
enum { ROWS = sizeof rows / sizeof rows[0], MEMORY = 1024, ROUNDS = 1600, UNTOUCHED = 0xa5 };

static float float_of(uint32_t bits) {
    float a;
    memcpy(&a, &bits, sizeof a);
    return a;
}

static uint32_t any_bits(random_state *r) { return (uint32_t)(random_bits(r) >> 32); }
static uint32_t below(random_state *r, uint32_t n) { return (uint32_t)random_below(r, n); }

static float any_float(random_state *r) {
    static const uint32_t special[] = {
        0x00000000, 0x80000000, 0x00000001, 0x80000001, 0x007fffff, 0x807fffff, 0x00800000, 0x80800000,
        0x3f800000, 0xbf800000, 0x3f000000, 0xbf000000, 0x3effffff, 0x3f7fffff, 0x40200000, 0xc0200000,
        0x4b000000, 0xcb000001, 0x4b7fffff, 0x4effffff, 0x4f000000, 0xcf000000, 0x7f7fffff, 0xff7fffff,
        0x7f800000, 0xff800000, 0x7fc00000, 0xffc00000, 0x7fc12345, 0xffd54321, 0x7f800001, 0xffa00000};
    switch (below(r, 4)) {
    case 0:
        return float_of(special[below(r, sizeof special / sizeof special[0])]);
    case 1:
        return float_of(any_bits(r));
    case 2:
        return (float)(int32_t)(below(r, 33) - 16) * 0.25f;
    default:
        return ldexpf((float)(int32_t)any_bits(r), (int)below(r, 64) - 62);
    }
}

static float number(random_state *r) {
    const float a = any_float(r);
    return isnan(a) ? 1 : a;
}

static float whole(random_state *r) {
    const float a = any_float(r);
    return a >= -0x1p31f && a < 0x1p31f ? a : (float)(int32_t)(any_bits(r) & 0xffffff80u);
}

static double any_double(random_state *r) {
    if (below(r, 2)) return (double)any_float(r);
    const uint64_t bits = random_bits(r);
    double a;
    memcpy(&a, &bits, sizeof a);
    /* Random bits round to a float only with an exponent that one has. */
    return below(r, 2) ? a : ldexp((double)(int64_t)bits, (int)below(r, 300) - 212);
}

static void make_operands(word_in *in, random_state *r, const float *memory) {
    memset(in, 0, sizeof *in);
    const unsigned often = below(r, 5); /* how many lanes are active: none, some, all */
    for (int k = 0; k < WORD_LANES; k++) {
        for (int c = 0; c < 3; c++) {
            in->any[c][k] = c > 0 && below(r, 4) == 0 ? in->any[c - 1][k] : any_float(r);
            in->wide[c][k] = c > 0 && below(r, 4) == 0 ? in->wide[c - 1][k] : any_double(r);
            in->ray[k].org[c] = any_float(r);
            in->ray[k].dir[c] = any_float(r);
        }
        in->ray[k].tmin = any_float(r);
        in->ray[k].tmax = any_float(r);
        for (int c = 0; c < WORD_TABLE; c++) in->number[c][k] = number(r);
        for (int c = 0; c < 2; c++) {
            in->whole[c][k] = whole(r);
            in->bits[c][k] = c > 0 && below(r, 4) == 0 ? in->bits[0][k] : (int32_t)any_bits(r);
            in->sum[c][k] = (int32_t)(any_bits(r) >> 1) - (1 << 30);
            in->factor[c][k] = (int32_t)below(r, 80000) - 40000;
            in->mask[c][k] = below(r, 4) < often;
        }
        in->sign[k] = below(r, 2) ? -0.0f : 0;
        in->place[k] = (int32_t)(below(r, 4) ? any_bits(r) >> 8 : (uint32_t)1 << below(r, 25));
        in->shift[k] = (int32_t)below(r, 32);
        in->entry[k] = (int32_t)below(r, 16);
        in->power[k] = (int32_t)below(r, 254) - 126;
        in->index[k] = in->mask[0][k] ? (int32_t)below(r, MEMORY / 4) : below(r, 2) ? INT32_MIN : INT32_MAX;
        in->each[k] = &in->ray[below(r, WORD_LANES)];
    }
    in->one_float = any_float(r);
    in->one_int = (int32_t)any_bits(r);
    in->one_double = any_double(r);
    in->one_bool = below(r, 2) == 1;
    in->count = below(r, WORD_LANES + 2);
    in->lane = any_bits(r);
    in->up = below(r, 2) == 1;
    for (int k = 0; k < WORD_TABLE; k++) in->table[k] = (int32_t)any_bits(r);
    in->block_lane = below(r, 16);
    in->memory = memory;
}

/* What may differ becomes the same: NaNs, and zeros' signs. */
static void take_liberties(word_result result, const word_out *got, word_out *wanted, unsigned width) {
    if (result == GIVES_LOWEST)
        for (int q = 0; q < WORD_TABLE; q++)
            if (wanted->each[q] == got->each[q]) wanted->each[q] = got->each[q];
    for (unsigned k = 0; k < width && result == GIVES_NUMBERS; k++) {
        if (isnan(got->f[0][k]) && isnan(wanted->f[0][k])) wanted->f[0][k] = got->f[0][k];
        if (isnan(got->d[k]) && isnan(wanted->d[k])) wanted->d[k] = got->d[k];
    }
}

static void print_lane(const word_in *in, const word_out *got, const word_out *wanted, size_t k) {
    printf("  lane %zu: operands %a %a %a, whole %a, wide %a %a, bits %d %d, mask %d %d\n", k, (double)in->any[0][k],
           (double)in->any[1][k], (double)in->any[2][k], (double)in->whole[0][k], in->wide[0][k], in->wide[1][k],
           in->bits[0][k], in->bits[1][k], in->mask[0][k], in->mask[1][k]);
    printf("  gives %a, integer %d, double %a, mask %d, not %a, %d, %a, %d\n", (double)got->f[0][k], got->i[k],
           got->d[k], got->m[k], (double)wanted->f[0][k], wanted->i[k], wanted->d[k], wanted->m[k]);
}

/* Whether the CPU, and what bounds it, allow the row. */
static bool available(const word_row *row) {
    char kernel[16];
    const unsigned lanes = (unsigned)strtoul(row->suffix, NULL, 10);
    snprintf(kernel, sizeof kernel, "packet%u", lanes);
    return lanes == 1 || cw_kernel_describe(cw_kernel_find(kernel)).available;
}

/* Whether a word gives on one set of operands what it should; else prints it if it is to say so. */
static bool word_is_right(const word_row *row, size_t number_of_word, const word_in *lanes, bool say) {
    const word *w = &row->words[number_of_word], *scalar = &cw_words_1.words[number_of_word];
    static word_in in;
    static word_out got, wanted;
    in = *lanes;
    in.block_lane -= in.block_lane % row->width;
    memset(&got, UNTOUCHED, sizeof got);
    memset(&wanted, UNTOUCHED, sizeof wanted);
    w->run(&in, &got, 0);
    for (size_t k = 0; k < row->width; k++) scalar->run(&in, &wanted, k);
    take_liberties(w->result, &got, &wanted, row->width);
    if (memcmp(&got, &wanted, sizeof got) == 0) return true;
    if (say) printf("%s of %s is wrong, or writes beyond its lanes\n", w->name, row->suffix);
    for (size_t k = 0; say && k < row->width; k++) print_lane(&in, &got, &wanted, k);
    return false;
}

static void test_words(void **state) {
    static _Alignas(16) float memory[MEMORY + 4];
    static word_in in;
    random_state r = {42};
    for (size_t k = 0; k < sizeof memory / sizeof memory[0]; k++) memory[k] = any_float(&r);
    for (size_t n = 0; n < ROWS; n++) {
        const word_row *row = rows[n];
        check(row->count == cw_words_1.count, "%s has %zu words, the scalar one %zu", row->suffix, row->count,
              cw_words_1.count);
        if (!available(row)) {
            printf("%-4s not on this CPU, or not allowed\n", row->suffix);
            continue;
        }
        size_t wrong = 0;
        const size_t rounds = test_share(ROUNDS, 400) * test_rounds();
        for (size_t round = 0; round < rounds; round++) {
            make_operands(&in, &r, memory);
            for (size_t w = 0; w < row->count; w++) {
                if (row->width > 16 && strcmp(row->words[w].name, "vf_load_block") == 0) continue; /* it has 16 lanes */
                wrong += !word_is_right(row, w, &in, wrong == 0);
            }
        }
        printf("%-4s %zu words, %zu rounds of %u lanes\n", row->suffix, row->count, rounds, row->width);
        check(wrong == 0, "%s: %zu times another answer", row->suffix, wrong);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_words)};
    return cmocka_run_group_tests_name("vocabulary", tests, NULL, NULL);
}
