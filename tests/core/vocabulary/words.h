/* SPDX-License-Identifier: Apache-2.0 */
/* The words of a vector vocabulary as functions on arrays of lanes, so that one program can hold several vocabularies.
 * words.c makes them of whichever vocabulary the build names; words.inc.h lists them. */
#ifndef CELLWALK_TESTS_WORDS_H
#define CELLWALK_TESTS_WORDS_H

#include "cellwalk.h"

enum { WORD_LANES = 32, WORD_TABLE = 16, WORD_GUARD = 4 };

/* Operands: arrays with an entry a lane, each within the domain of the words that take it. */
typedef struct word_in {
    float any[3][WORD_LANES];             /* any bits */
    float number[WORD_TABLE][WORD_LANES]; /* no NaN */
    float whole[2][WORD_LANES];           /* from -2^31 to the largest float below 2^31, with fractions */
    float sign[WORD_LANES];               /* 0 or -0 */
    double wide[3][WORD_LANES];           /* any bits, and floats among them */
    int32_t bits[2][WORD_LANES];          /* any bits */
    int32_t sum[2][WORD_LANES];           /* sums and differences are within int32 */
    int32_t factor[2][WORD_LANES];        /* products are within int32 */
    int32_t place[WORD_LANES];            /* 0 to 2^24 */
    int32_t shift[WORD_LANES];            /* 0 to 31 */
    int32_t entry[WORD_LANES];            /* 0 to 15 */
    int32_t power[WORD_LANES];            /* -126 to 127 */
    int32_t index[WORD_LANES];            /* within memory where mask[0], else anything */
    bool mask[2][WORD_LANES];
    cw_ray ray[WORD_LANES];
    const cw_ray *each[WORD_LANES];
    /* The same for all lanes. */
    float one_float;
    int32_t one_int;
    double one_double;
    bool one_bool;
    size_t count;  /* for the first lane; each lane's is one less than that of the lane before, but at least 0 */
    unsigned lane; /* bit k is lane k's */
    bool up;
    size_t block_lane; /* number of the first lane in the block of 16: a multiple of W */
    int32_t table[WORD_TABLE];
    const float *memory; /* 4 floats for each index, aligned to 16 bytes */
} word_in;

/* The results of a word, with room behind them that it must not touch. */
typedef struct word_out {
    float f[8][WORD_LANES + WORD_GUARD];
    int32_t i[WORD_LANES + WORD_GUARD];
    double d[WORD_LANES];
    uint8_t m[WORD_LANES]; /* 0 or 1 */
    cw_hit hit[WORD_LANES + 1];
    unsigned bits;
    uint8_t is_any; /* 0 or 1 */
    float each[WORD_TABLE + WORD_GUARD];
} word_out;

typedef enum word_result {
    GIVES_BITS,    /* the scalar vocabulary's, bit for bit, and nothing beside them */
    GIVES_NUMBERS, /* the same, but that a NaN may be any */
    GIVES_LOWEST   /* each, of all lanes; zeros of either sign are the same */
} word_result;

typedef struct word {
    const char *name;
    word_result result;
    void (*run)(const word_in *in, word_out *out,
                size_t at); /* on operands from lane number at on, 0 unless LANES is 1 */
} word;

typedef struct word_row {
    const char *suffix; /* as in the names of kernels: 8, 8x2 */
    unsigned width;
    size_t count;
    const word *words;
} word_row;

#endif
