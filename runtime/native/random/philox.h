/* SPDX-License-Identifier: Apache-2.0 */
/* Philox4x64-10: Salmon, Moraes, Dror & Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC11. Numbers depend only on a
 * key and a counter. The stream is that of NumPy's Philox, whose first block has the counter 1. */
#ifndef MEHVAR_PHILOX_H
#define MEHVAR_PHILOX_H

#include <stdint.h>

/* one word per lane: keys differ between runs, so that a block of lanes is computed at once */
#if defined MEHVAR_LANES && MEHVAR_LANES > 1
typedef uint64_t mv_words __attribute__((vector_size(MEHVAR_LANES * 8)));
#else
typedef uint64_t mv_words;
#endif

/* Computed by halves, because vectors and some compilers have no integers of 128 bits. */
static inline mv_words mv_high_product(uint64_t a, mv_words b, mv_words *low)
{
    const uint64_t half = 0xFFFFFFFFu, a0 = a & half, a1 = a >> 32;
    const mv_words b0 = b & half, b1 = b >> 32;
    const mv_words cross = a1 * b0 + (a0 * b0 >> 32); /* at most (2^32 - 1)^2 + 2^32 - 1, below 2^64 */
    const mv_words other = a0 * b1 + (cross & half);
    *low = a * b;
    return a1 * b1 + (cross >> 32) + (other >> 32);
}

static inline void mv_philox_of(uint64_t key0, mv_words key1, uint64_t stream, uint64_t counter, mv_words words[4])
{
    const mv_words zero = {0};
    mv_words a = zero + counter, b = zero + stream, c = zero, d = zero;
    for (int round = 0; round < 10; round++) {
        mv_words low_a, low_c;
        const mv_words high_a = mv_high_product(0xD2E7470EE14C6C93u, a, &low_a);
        const mv_words high_c = mv_high_product(0xCA5A826395121157u, c, &low_c);
        a = high_c ^ b ^ key0;
        b = low_c;
        c = high_a ^ d ^ key1;
        d = low_a;
        key0 += 0x9E3779B97F4A7C15u;
        key1 += 0xBB67AE8584CAA73Bu;
    }
    words[0] = a;
    words[1] = b;
    words[2] = c;
    words[3] = d;
}

static inline void mv_philox(uint64_t key0, mv_words key1, uint64_t counter, mv_words words[4])
{
    mv_philox_of(key0, key1, 0, counter, words);
}

#endif
