/* SPDX-License-Identifier: Apache-2.0 */
/* Standard normal numbers from words of Philox, a pair from a pair: Box & Muller, Ann. Math. Statist. 29 (1958) 610. */
#ifndef MEHVAR_NOISE_H
#define MEHVAR_NOISE_H

#include "mehvar/private/arithmetic.h"
#include "philox.h"

/* the upper 52 bits, of a float 23, as a fraction in [0, 1) */
static inline real mv_fraction(mv_bits word)
{
    return mv_from_bits((word >> (8 * MV_BYTES - MV_DIGITS)) | mv_to_bits(SPLAT(1))) - K(1);
}

static inline void mv_normal_pair(const mv_bits word[2], real *first, real *second)
{
    real s, c;
    mv_sincos(K(0x1.921fb54442d18p2) * mv_fraction(word[1]), &s, &c);
    const real radius = mv_sqrt(K(-2) * mv_log(K(1) - mv_fraction(word[0])));
    *first = radius * c;
    *second = radius * s;
}

/* the lower bits of words: of floats a half */
static inline mv_bits mv_lower(mv_words words)
{
#if defined MEHVAR_FLOAT && MEHVAR_LANES > 1
    mv_bits bits;
    for (int lane = 0; lane < MEHVAR_LANES; lane++) bits[lane] = (mv_word)words[lane];
    return bits;
#else
    return (mv_bits)words;
#endif
}

/* Streams of numbers by purpose, each with its own counters. */
enum mv_stream { MV_OF_MEASUREMENTS, MV_OF_WIENER_PROCESSES, MV_OF_RANDOM_STEPS };

/* the numbers of one sample or step of the runs in the lanes */
static inline void mv_noise(uint64_t seed, const uint64_t *run, enum mv_stream stream, uint64_t sample, int size, real *e)
{
    const int blocks = (size + 3) / 4;
    mv_words key;
    for (int lane = 0; lane < MEHVAR_LANES; lane++) ((uint64_t *)&key)[lane] = run[lane];
    for (int j = 0; j < blocks; j++) {
        mv_words own[4];
        mv_bits words[4];
        mv_philox_of(seed, key, stream, 1 + sample * (uint64_t)blocks + (uint64_t)j, own);
        for (int i = 0; i < 4; i++) words[i] = mv_lower(own[i]);
        real pair[4];
        mv_normal_pair(words, &pair[0], &pair[1]);
        mv_normal_pair(words + 2, &pair[2], &pair[3]);
        for (int i = 0; i < 4 && 4 * j + i < size; i++) e[4 * j + i] = pair[i];
    }
}

#endif
