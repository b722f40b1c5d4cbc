/* SPDX-License-Identifier: Apache-2.0 */
/* Exponential, logarithm and power. Errors are below 1.4 units in the last place in both precisions, subnormal numbers
 * included. Polynomials as in trig.h. */
#ifndef MEHVAR_PRIVATE_EXP_H
#define MEHVAR_PRIVATE_EXP_H

#include "operations.h"

#ifdef MEHVAR_FLOAT
#define MV_LN2_HEAD K(0x1.62e4p-1) /* times any exponent is exact */
#define MV_LN2_TAIL K(0x1.7f7d1cp-20)
#define MV_SQRT_HALF_BITS 0x3f3504f3u
#define MV_LEAST_NORMAL K(0x1p-126)
#else
#define MV_LN2_HEAD K(0x1.62e42fefa38p-1)
#define MV_LN2_TAIL K(0x1.ef35793c7673p-45)
#define MV_SQRT_HALF_BITS 0x3fe6a09e667f3bcdu
#define MV_LEAST_NORMAL K(0x1p-1022)
#endif
#define MV_ONE_BITS ((mv_word)MV_BIAS << MV_DIGITS)

/* e^r for |r| <= ln(2)/2 */
static inline real mv_exp_reduced(real r)
{
#ifdef MEHVAR_FLOAT
    const real p = MV_POLY5(r, 0.499999940, 0.166665182, 4.16684113e-2, 8.36895686e-3, 1.38141005e-3);
#else
    const real p = MV_POLY10(r, 0.5000000000000011, 0.1666666666666641, 0.041666666666529725, 0.008333333333494982,
                             0.0013888888943760047, 0.0001984126950576483, 2.4801492949541946e-05,
                             2.7557586812271127e-06, 2.763030628401265e-07, 2.5000016081755942e-08);
#endif
    return K(1) + (r + r * r * p);
}

/* y 2^k for n = k + MV_ROUND, in two steps: 2^k itself may be out of range */
static inline real mv_scale(real y, real n)
{
    const mv_bits k = mv_to_bits(n) - (MV_ROUND_BITS - 2 * MV_BIAS); /* k + 2 MV_BIAS */
    const mv_bits half = k >> 1;
    return y * mv_from_bits(half << MV_DIGITS) * mv_from_bits((k - half) << MV_DIGITS);
}

MV_LARGE real mv_exp(real x)
{
#ifdef MEHVAR_FLOAT
    const real least = SPLAT(-104), most = SPLAT(89);
#else
    const real least = SPLAT(-746), most = SPLAT(710);
#endif
    const real above = SELECT(LT(x, least), least, x), v = SELECT(LT(most, above), most, above);
    const real n = v * K(0x1.71547652b82fep0) + MV_ROUND, k = n - MV_ROUND;
    return mv_scale(mv_exp_reduced((v - k * MV_LN2_HEAD) - k * MV_LN2_TAIL), n);
}

/* x = 2^k (1 + f) for positive finite x, sqrt(1/2) <= 1 + f < sqrt(2) */
static inline void mv_split(real x, real *k, real *f)
{
    const mask tiny = LT(x, MV_LEAST_NORMAL);
    const mv_bits b = mv_to_bits(SELECT(tiny, x * (K(4) * MV_WHOLE), x)) + (MV_ONE_BITS - MV_SQRT_HALF_BITS);
    const real biased = mv_from_bits((b >> MV_DIGITS) | mv_to_bits(SPLAT(MV_WHOLE))) - MV_WHOLE;
    *k = biased - SELECT(tiny, SPLAT(MV_BIAS + MV_DIGITS + 2), SPLAT(MV_BIAS));
    *f = mv_from_bits((b & (((mv_word)1 << MV_DIGITS) - 1)) + MV_SQRT_HALF_BITS) - K(1);
}

/* log(1 + f) = 2 atanh(s) = 2s + s R with s = f/(2 + f); 2s is written as f - f^2/2 + s f^2/2, whose first terms carry
 * no rounding error that counts. */
MV_LARGE real mv_log(real x)
{
    real k, f;
    mv_split(x, &k, &f);
    const real s = f / (K(2) + f), z = s * s, half = K(0.5) * f * f;
#ifdef MEHVAR_FLOAT
    const real tail = z * MV_POLY3(z, 0.666667759, 0.399775863, 0.298687637);
#else
    const real tail = z * MV_POLY7(z, 0.6666666666666734, 0.39999999999416935, 0.28571428741933685, 0.22222198616116887,
                                   0.18183562248233687, 0.15314100374555936, 0.14795481293888085);
#endif
    const real y = k * MV_LN2_HEAD - ((half - (s * (half + tail) + k * MV_LN2_TAIL)) - f);
    const real finite = SELECT(LT(x, MV_INFINITY), y, x);
    return SELECT(LE(x, K(0)), SELECT(EQ(x, K(0)), SPLAT(-MV_INFINITY), SPLAT(MV_NAN)), finite);
}

/* x without the lower half of its digits: products of two such numbers are exact */
static inline real mv_head(real x) { return mv_from_bits(mv_to_bits(x) & MV_HEAD_BITS); }

/* log2(x) for positive finite x as head + tail, to about 1.2 times the digits of a real.
 * log2(1 + f) = C s (3 + s^2 + s^4 R) with C = 2/(3 ln 2); each factor is a head, which multiplies exactly, and a tail. */
static inline void mv_log2_parts(real x, real *head, real *tail)
{
#ifdef MEHVAR_FLOAT
    const scalar c = K(0x1.ec709ep-1), c_head = K(0x1.ec6p-1), c_tail = K(0x1.09dc3ap-13);
#else
    const scalar c = K(0x1.ec709dc3a03fdp-1), c_head = K(0x1.ec709d8p-1), c_tail = K(0x1.0e80ff5d27f05p-27);
#endif
    real k, f;
    mv_split(x, &k, &f);
    const real d = K(2) + f, d_head = mv_head(d), d_tail = f - (d_head - K(2)), inverse = K(1) / d;
    const real s_head = mv_head(f * inverse), s_tail = ((f - s_head * d_head) - s_head * d_tail) * inverse;
    const real s = s_head + s_tail, z = s * s, z_head = s_head * s_head;
#ifdef MEHVAR_FLOAT
    const real series = z * z * MV_POLY3(z, 0.600002289, 0.428206295, 0.351288885);
#else
    const real series = z * z * MV_POLY8(z, 0.5999999999999996, 0.42857142857168806, 0.33333333326026865,
                                         0.2727272833965616, 0.230768329691598, 0.2000456621290566,
                                         0.17510396517097615, 0.17998787549088238);
#endif
    const real z_tail = series + s_tail * (s_head + s);
    const real t_head = mv_head(K(3) + z_head + z_tail), t_tail = z_tail - ((t_head - K(3)) - z_head);
    const real u = s_head * t_head, v = s_tail * t_head + t_tail * s;
    const real p_head = mv_head(u + v), p_tail = v - (p_head - u);
    const real w = c_head * p_head, w_tail = c_tail * p_head + p_tail * c;
    *head = mv_head(k + (w + w_tail));
    *tail = w_tail - ((*head - k) - w);
}

/* |x|^y for positive finite |x| */
static inline real mv_pow_magnitude(real a, real y)
{
#ifdef MEHVAR_FLOAT
    const real huge = SPLAT(0x1p40), beyond = SPLAT(200);
#else
    const real huge = SPLAT(0x1p70), beyond = SPLAT(1100);
#endif
    real head, tail;
    mv_log2_parts(a, &head, &tail);
    const real e = SELECT(LT(mv_fabs(y), huge), y, mv_copysign(huge, y)), e_head = mv_head(e);
    const real p = e_head * head, p_tail = (e - e_head) * head + e * tail;
    const mask inside = LT(mv_fabs(p), beyond);
    const real q = SELECT(inside, p, mv_copysign(beyond, p)), q_tail = SELECT0(inside, p_tail);
    const real n = (q + q_tail) + MV_ROUND, k = n - MV_ROUND;
    return mv_scale(mv_exp_reduced(((q - k) + q_tail) * K(0x1.62e42fefa39efp-1)), n);
}

/* Special cases as in C99: among them x^0 = 1 and 1^y = 1 also for NaN, and NaN for a negative number to a power that
 * is not an integer. */
MV_LARGE real mv_pow(real x, real y)
{
    const real a = mv_fabs(x), b = mv_fabs(y), h = K(0.5) * b;
    const mask zero = EQ(a, K(0)), infinite = EQ(a, MV_INFINITY), rises = LT(K(0), y);
    const mask whole = EQ(mv_nearest(b), b), odd = AND(whole, NE(mv_nearest(h), h));
    const real limit = SELECT(XOR(zero, rises), SPLAT(MV_INFINITY), SPLAT(0));
    const real magnitude = SELECT(OR(zero, infinite), limit, mv_pow_magnitude(a, y));
    const real power = SELECT(AND(odd, mv_is_signed(x)), -magnitude, magnitude);
    const mask complex = AND(AND(LT(x, K(0)), NOT(infinite)), NOT(whole));
    const mask undefined = OR(complex, OR(NE(x, x), NE(y, y)));
    return SELECT(OR(EQ(y, K(0)), EQ(x, K(1))), SPLAT(1), SELECT(undefined, SPLAT(MV_NAN), power));
}

#endif
