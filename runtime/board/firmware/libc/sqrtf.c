/* SPDX-License-Identifier: Apache-2.0 */
/* Correctly rounded square root for processors without the instruction, one digit at a time. */
#include "mehvar/private/operations.h"

float sqrtf(float x);

float sqrtf(float x)
{
    uint32_t bits = mv_to_bits(x);
    if (x != x || x == K(0) || bits == mv_to_bits(MV_INFINITY)) return x;
    if (bits & MV_SIGN_BITS) return MV_NAN;
    int32_t exponent = (int32_t)(bits >> 23);
    uint32_t digits = bits & 0x7FFFFFu;
    if (exponent == 0)
        for (exponent = 1; !(digits & 0x800000u); exponent--) digits <<= 1;
    digits |= 0x800000u;
    exponent -= 127;
    if (exponent & 1) digits <<= 1;
    exponent = (exponent - (exponent & 1)) / 2;
    uint32_t rest = digits << 1, root = 0, sum = 0;
    for (uint32_t digit = 0x1000000u; digit != 0; digit >>= 1) {
        const uint32_t trial = sum + digit;
        if (trial <= rest) {
            sum = trial + digit;
            rest -= trial;
            root += digit;
        }
        rest <<= 1;
    }
    if (rest != 0) root += root & 1u; /* nearest; a root is never halfway */
    return mv_from_bits((root >> 1) + ((uint32_t)(exponent + 126) << 23));
}
