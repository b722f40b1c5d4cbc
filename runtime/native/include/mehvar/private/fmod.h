/* SPDX-License-Identifier: Apache-2.0 */
/* Remainder of a division, which is exact, for free-standing builds: one number at a time, digit by digit. */
#ifndef MEHVAR_PRIVATE_FMOD_H
#define MEHVAR_PRIVATE_FMOD_H

#include "operations.h"

#if MEHVAR_LANES == 1
/* the integer m and the exponent e of |x| = m 2^(e - constant), for finite x that is not zero */
static inline mv_word mv_whole_digits(real x, int *e)
{
    const mv_word bits = mv_to_bits(x) & ~MV_SIGN_BITS, one = (mv_word)1 << MV_DIGITS;
    *e = (int)(bits >> MV_DIGITS);
    if (*e > 0) return (bits & (one - 1)) | one;
    *e = 1;
    return bits;
}

static inline real mv_fmod(real x, real y)
{
    const real a = mv_fabs(x), b = mv_fabs(y);
    if (!(a < MV_INFINITY) || !(K(0) < b)) return MV_NAN;
    if (a < b) return x;
    int ex, ey;
    mv_word rest = mv_whole_digits(a, &ex);
    const mv_word divisor = mv_whole_digits(b, &ey), one = (mv_word)1 << MV_DIGITS;
    for (; ex > ey && rest != 0; ex--) rest = (rest % divisor) << 1;
    rest %= divisor;
    for (; rest != 0 && rest < one && ex > 1; ex--) rest <<= 1;
    const mv_word size = rest < one ? rest : (rest - one) | (mv_word)ex << MV_DIGITS;
    return mv_copysign(mv_from_bits(size), x);
}
#endif

#endif
