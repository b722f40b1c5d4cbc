/* SPDX-License-Identifier: Apache-2.0 */
/* Circular functions and their inverses. Errors are below 1.6 units in the last place in both precisions.
 *
 * Polynomials are minimax in relative error (Remez exchange in 60 digits, coefficients rounded one after the other,
 * the remaining ones refitted each time). */
#ifndef MEHVAR_PRIVATE_TRIG_H
#define MEHVAR_PRIVATE_TRIG_H

#include "operations.h"

/* (sin r - r)/r^3 for |r| <= pi/4, z = r^2 */
static inline real mv_sin_tail(real z)
{
#ifdef MEHVAR_FLOAT
    return MV_POLY4(z, -0.166666672, 8.33337754e-3, -1.98520682e-4, 2.82070033e-6);
#else
    return MV_POLY6(z, -0.1666666666666663, 0.00833333333332184, -0.00019841269829358528, 2.755731353851409e-06,
                    -2.505073438918123e-08, 1.5895433935235015e-10);
#endif
}

/* (cos r - 1 + r^2/2)/r^4 for |r| <= pi/4, z = r^2 */
static inline real mv_cos_tail(real z)
{
#ifdef MEHVAR_FLOAT
    return MV_POLY3(z, 4.16666381e-2, -1.38871302e-3, 2.44123526e-5);
#else
    return MV_POLY6(z, 0.041666666666666595, -0.0013888888888873338, 2.4801587288997478e-05,
                    -2.7557314215296874e-07, 2.087570511451096e-09, -1.135873267618138e-11);
#endif
}

/* (atan q - q)/q^3 for |q| <= 1/2, z = q^2 */
static inline real mv_atan_tail(real z)
{
#ifdef MEHVAR_FLOAT
    return MV_POLY6(z, -0.333333284, 0.199995548, -0.142731071, 0.109484106, -8.00907612e-2, 3.90421674e-2);
#else
    return MV_POLY12(z, -0.3333333333333298, 0.19999999999903104, -0.1428571427638489, 0.11111110659575019,
                     -0.09090896242805041, 0.07692073877102865, -0.06663810210461354, 0.05858295912438468,
                     -0.051219914845780486, 0.04186461863077904, -0.027434235700796613, 0.010116327918966526);
#endif
}

/* (asin s - s)/s^3 for |s| <= 1/2, z = s^2 */
static inline real mv_asin_tail(real z)
{
#ifdef MEHVAR_FLOAT
    return MV_POLY6(z, 0.166666597, 7.50052184e-2, 4.45133820e-2, 3.18388417e-2, 1.43169649e-2, 3.76916453e-2);
#else
    return MV_POLY13(z, 0.1666666666666676, 0.07499999999970865, 0.04464285717456595, 0.030381942709437112,
                     0.022372214952939732, 0.017351612465693368, 0.013980816836211192, 0.011398930650197068,
                     0.010780207936452428, 0.003706382452231472, 0.021707938539241106, -0.02100030695126485,
                     0.03262971650046296);
#endif
}

/* x >= 0 less the nearest k quarter turns, as r + tail with |r| <= pi/4; returns k modulo 4 in its low bits.
 * Cody-Waite: pi/2 in parts so short that k times each, and the first differences, are exact. */
static inline mv_bits mv_quarter_turns(real x, real *r, real *tail)
{
    const real n = x * K(0.6366197723675814) + MV_ROUND, k = n - MV_ROUND;
#ifdef MEHVAR_FLOAT
    const real a = x - k * K(0x1.92p0) - k * K(0x1.ep-12) - k * K(0x1.b4p-16);
    const real b = k * K(0x1.44p-24), ab = a - b;
    const real c = k * K(0x1.08p-34), abc = ab - c;
    const real rest = ((a - ab) - b) + ((ab - abc) - c) - k * K(0x1.a308d4p-41);
#else
    const real a = x - k * K(0x1.921fb5444p0);
    const real b = k * K(0x1.68c234c4p-39), abc = a - b;
    const real rest = ((a - abc) - b) - k * K(0x1.8cc51701b839ap-72);
#endif
    *r = abc + rest;
    *tail = (abc - *r) + rest;
    return mv_to_bits(n);
}

/* sine and cosine of |x| less k quarter turns, each a number and a much smaller rest; k modulo 4 is in the low bits */
typedef struct {
    real sine, sine_rest, cosine, cosine_rest;
    mv_bits turns;
} mv_reduced;

/* Accurate for |x| up to 2e5 (double), 1e5 (float). From there the error grows as |x| does, until neighbouring
 * numbers are a good part of a turn apart: from 2^49 (double), 2^20 (float) on the angle is taken for 0. */
static inline mv_reduced mv_reduce(real x)
{
#ifdef MEHVAR_FLOAT
    const real largest = SPLAT(0x1p20);
#else
    const real largest = SPLAT(0x1p49);
#endif
    const real a = mv_fabs(x);
    real r, tail;
    const mv_bits turns = mv_quarter_turns(SELECT(LT(a, largest), a, a - a), &r, &tail);
    const real z = r * r, half = K(0.5) * z, most = K(1) - half;
    const real sine_rest = r * (z * mv_sin_tail(z)) + tail * most;
    const real cosine_rest = ((K(1) - most) - half) + (z * (z * mv_cos_tail(z)) - r * tail);
    return (mv_reduced){r, sine_rest, most, cosine_rest, turns};
}

MV_LARGE void mv_sincos(real x, real *sine, real *cosine)
{
    const mv_reduced v = mv_reduce(x);
    const real s = v.sine + v.sine_rest, c = v.cosine + v.cosine_rest;
    const mask odd = mv_lowest_bit(v.turns);
    const int shift = 8 * MV_BYTES - 2; /* from the bit that counts two quarter turns to the sign */
    *sine = mv_flip_sign(SELECT(odd, c, s), (v.turns << shift) ^ mv_to_bits(x));
    *cosine = mv_flip_sign(SELECT(odd, s, c), (v.turns + 1) << shift);
}

MV_LARGE real mv_sin(real x)
{
    real s, c;
    mv_sincos(x, &s, &c);
    return s;
}

MV_LARGE real mv_cos(real x)
{
    real s, c;
    mv_sincos(x, &s, &c);
    return c;
}

/* the quotient, with what numerator and denominator lost by rounding put back */
MV_LARGE real mv_tan(real x)
{
    const mv_reduced v = mv_reduce(x);
    const mask odd = mv_lowest_bit(v.turns);
    const real n = SELECT(odd, -v.cosine, v.sine), n_rest = SELECT(odd, -v.cosine_rest, v.sine_rest);
    const real d = SELECT(odd, v.sine, v.cosine), d_rest = SELECT(odd, v.sine_rest, v.cosine_rest);
    const real top = n + n_rest, bottom = d + d_rest, q = top / bottom;
    const real lost = ((n - top) + n_rest) - q * ((d - bottom) + d_rest);
    return mv_flip_sign(q + lost / bottom, mv_to_bits(x));
}

/* n eighths of a turn + a + b, rounded almost only once; n <= 4, and n = 0 or |b| << |a| <= n pi/4 */
static inline real mv_eighths_plus(real n, real a, real b)
{
#ifdef MEHVAR_FLOAT
    const real turn = n * K(0x1.921fbp-1), rest = n * K(0x1.5110b4p-23);
#else
    const real turn = n * K(0x1.921fb54442d18p-1), rest = n * K(0x1.1a62633145c07p-55);
#endif
    const real sum = turn + a;
    return sum + (((turn - sum) + a) + (rest + b));
}

/* Quadrants and signed zeros as in C99. The quotient is at most 1/2: near a diagonal, atan2 is pi/4 less the angle of
 * (large + small, large - small), which must not overflow. */
MV_LARGE real mv_atan2(real y, real x)
{
    const real a = mv_fabs(y), b = mv_fabs(x);
    const mask steep = LT(b, a), left = mv_is_signed(x);
    const real small = SELECT(steep, b, a), large = SELECT(steep, a, b), difference = large - small;
    const mask diagonal = NOT(LE(small, difference));
    const real quotient = SELECT(diagonal, difference, small) / SELECT(diagonal, large + small, large);
    const real q = SELECT0(NE(small, large), quotient); /* 0/0 and inf/inf are on their diagonal */
    const real to_diagonal = NUM(diagonal);
    const real to_steep = SELECT(steep, K(2) - to_diagonal, to_diagonal);
    const real eighths = SELECT(left, K(4) - to_steep, to_steep);
    const real v = SELECT(XOR(XOR(diagonal, steep), left), -q, q), z = q * q;
    return mv_copysign(mv_eighths_plus(eighths, v, v * (z * mv_atan_tail(z))), y);
}

static inline real mv_atan(real x) { return mv_atan2(x, SPLAT(1)); }

/* asin s = s + tail with s = |x|, or where |x| > 1/2 with s = sqrt((1 - |x|)/2), the sine of half the complement */
static inline mask mv_asin_parts(real x, real *s, real *tail)
{
    const real a = mv_fabs(x);
    const mask large = LT(K(0.5), a);
    const real z = SELECT(large, K(0.5) * (K(1) - a), a * a);
    *s = SELECT(large, mv_sqrt(z), a);
    *tail = *s * (z * mv_asin_tail(z));
    return large;
}

MV_LARGE real mv_asin(real x)
{
    real s, tail;
    const mask large = mv_asin_parts(x, &s, &tail);
    const real sign = SELECT(large, SPLAT(-2), SPLAT(1));
    return mv_copysign(mv_eighths_plus(K(2) * NUM(large), sign * s, sign * tail), x);
}

MV_LARGE real mv_acos(real x)
{
    real s, tail;
    const mask large = mv_asin_parts(x, &s, &tail), negative = LT(x, K(0));
    const real positive = SELECT(large, SPLAT(2), SPLAT(-1)), sign = SELECT(negative, -positive, positive);
    const real eighths = SELECT(large, SELECT(negative, SPLAT(4), SPLAT(0)), SPLAT(2));
    return mv_eighths_plus(eighths, sign * s, sign * tail);
}

#endif
