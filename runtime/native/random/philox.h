/* SPDX-License-Identifier: Apache-2.0 */
/* Philox4x64-10: Salmon, Moraes, Dror & Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC11. Numbers that depend
 * on a key and a counter alone; the same stream as NumPy's Philox, whose first block has the counter 1. */
#ifndef MEHVAR_PHILOX_H
#define MEHVAR_PHILOX_H

#include <stdint.h>

static inline uint64_t mv_high_product(uint64_t a, uint64_t b, uint64_t *low)
{
    const unsigned __int128 product = (unsigned __int128)a * b;
    *low = (uint64_t)product;
    return (uint64_t)(product >> 64);
}

static inline void mv_philox(uint64_t key0, uint64_t key1, uint64_t counter, uint64_t words[4])
{
    uint64_t a = counter, b = 0, c = 0, d = 0;
    for (int round = 0; round < 10; round++) {
        uint64_t low_a, low_c;
        const uint64_t high_a = mv_high_product(0xD2E7470EE14C6C93u, a, &low_a);
        const uint64_t high_c = mv_high_product(0xCA5A826395121157u, c, &low_c);
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

#endif
