/* SPDX-License-Identifier: Apache-2.0 */
/* Operations on reals, under short names for readable code. Only .c files may include this header; headers for users must
 * not.
 *
 * MEHVAR_SMALL  when defined, larger functions of one lane are called instead of inlined
 * MEHVAR_NO_LIBM  when defined, square roots and remainders call no C library: in float, one number at a time
 *
 * Nothing branches on data, so each lane gets the same bits at every number of lanes and from every compiler that keeps
 * IEEE 754 and does not contract a*b + c (-ffp-contract=off); -fno-math-errno makes the square root of a vector one
 * instruction. A mask has one truth value per lane. */
#ifndef MEHVAR_PRIVATE_OPERATIONS_H
#define MEHVAR_PRIVATE_OPERATIONS_H

#include <stdint.h>
#ifndef __GNUC__
#include <math.h>
#endif

#include "../real.h"

#if defined __FAST_MATH__ || __FLT_EVAL_METHOD__ == 1 || __FLT_EVAL_METHOD__ == 2
#error "mehvar needs arithmetic in the type's own precision: no -ffast-math, no x87"
#endif

typedef mv_scalar scalar;
typedef mv_real real;

/* MV_WHOLE: from here on every number is an integer. MV_ROUND + k has the integer k in its low bits. */
#ifdef MEHVAR_FLOAT
typedef uint32_t mv_word;
#define MV_DIGITS 23
#define MV_BIAS 127
#define MV_HEAD_BITS 0xfffff000u
#define MV_WHOLE K(0x1p23)
#define MV_ROUND K(0x1.8p23)
#define MV_ROUND_BITS 0x4b400000u
#define MV_SCALAR(function) MV_LIBRARY(function##f)
#else
typedef uint64_t mv_word;
#define MV_DIGITS 52
#define MV_BIAS 1023
#define MV_HEAD_BITS 0xfffffffff8000000u
#define MV_WHOLE K(0x1p52)
#define MV_ROUND K(0x1.8p52)
#define MV_ROUND_BITS 0x4338000000000000u
#define MV_SCALAR(function) MV_LIBRARY(function)
#endif

/* GNU C provides these without a header, and thus without a C library. */
#ifdef __GNUC__
#define MV_LIBRARY(function) __builtin_##function
#define MV_INFINITY K(__builtin_inf())
#define MV_NAN K(__builtin_nan(""))
#else
#define MV_LIBRARY(function) function
#define MV_INFINITY K(INFINITY)
#define MV_NAN K(NAN)
#endif

#if MEHVAR_LANES > 1 /* a call would spill every vector register */
#define MV_LARGE __attribute__((always_inline)) static inline
#elif defined MEHVAR_SMALL && defined __GNUC__
#define MV_LARGE static __attribute__((noinline, unused))
#else
#define MV_LARGE static inline
#endif
#define MV_SIGN_BITS ((mv_word)1 << (8 * MV_BYTES - 1))

#define K(c) ((scalar)(c))

#if MEHVAR_LANES == 1

typedef mv_word mv_bits;
typedef int mask;

#define SPLAT(c) K(c)
#define LT(a, b) ((a) < (b))
#define LE(a, b) ((a) <= (b))
#define EQ(a, b) ((a) == (b))
#define NE(a, b) ((a) != (b))
#define NOT(m) (!(m))

static inline mv_bits mv_to_bits(real x) { return ((union { real number; mv_bits bits; }){x}).bits; }
static inline real mv_from_bits(mv_bits b) { return ((union { mv_bits bits; real number; }){b}).number; }
static inline mask mv_lowest_bit(mv_bits b) { return (int)(b & 1); }
static inline real mv_select(mask m, real a, real b) { return m ? a : b; }
static inline real mv_fabs(real x) { return MV_SCALAR(fabs)(x); }
static inline real mv_copysign(real x, real sign) { return MV_SCALAR(copysign)(x, sign); }
#ifdef MEHVAR_NO_LIBM
#include "root.h"
#else
static inline real mv_sqrt(real x) { return MV_SCALAR(sqrt)(x); }
#endif

#else

typedef mv_word mv_bits __attribute__((vector_size(MEHVAR_LANES * MV_BYTES)));
typedef __typeof__((real){0} < (real){0}) mask;

/* gcc compares and fills vectors longer than the machine's one lane at a time, so both are done in parts. */
#if defined __clang__ || defined __AVX512F__
#define MV_MACHINE_BYTES 64
#elif defined __AVX__
#define MV_MACHINE_BYTES 32
#else
#define MV_MACHINE_BYTES 16
#endif
#if MEHVAR_LANES * MV_BYTES > MV_MACHINE_BYTES
#define MV_PART_BYTES MV_MACHINE_BYTES
#else
#define MV_PART_BYTES (MEHVAR_LANES * MV_BYTES)
#endif
typedef scalar mv_part __attribute__((vector_size(MV_PART_BYTES), may_alias));
typedef __typeof__((mv_part){0} < (mv_part){0}) mv_part_plain_mask;
typedef mv_part_plain_mask mv_part_mask __attribute__((may_alias));

#define MV_PARTS (MEHVAR_LANES * MV_BYTES / MV_PART_BYTES)

#define MV_DEFINE_COMPARISON(name, operator)                                                                         \
    static inline mask name(real a, real b)                                                                          \
    {                                                                                                                \
        mask m;                                                                                                      \
        for (int i = 0; i < MV_PARTS; i++)                                                                           \
            ((mv_part_mask *)&m)[i] = ((const mv_part *)&a)[i] operator ((const mv_part *)&b)[i];                    \
        return m;                                                                                                    \
    }
MV_DEFINE_COMPARISON(mv_less, <)
MV_DEFINE_COMPARISON(mv_less_equal, <=)
MV_DEFINE_COMPARISON(mv_equal, ==)
MV_DEFINE_COMPARISON(mv_not_equal, !=)

/* x - 0 is x, also for -0, and makes a scalar as wide as a part */
static inline real mv_splat(scalar x)
{
    real v;
    for (int i = 0; i < MV_PARTS; i++) ((mv_part *)&v)[i] = x - (mv_part){0};
    return v;
}
static inline real mv_same(real x) { return x; }

#define SPLAT(c) mv_splat(K(c))
#define MV_WIDE(a) _Generic((a), real: mv_same, default: mv_splat)(a)
#define LT(a, b) mv_less(MV_WIDE(a), MV_WIDE(b))
#define LE(a, b) mv_less_equal(MV_WIDE(a), MV_WIDE(b))
#define EQ(a, b) mv_equal(MV_WIDE(a), MV_WIDE(b))
#define NE(a, b) mv_not_equal(MV_WIDE(a), MV_WIDE(b))
#define NOT(m) (~(m))

static inline mv_bits mv_to_bits(real x) { return (mv_bits)x; }
static inline real mv_from_bits(mv_bits b) { return (real)b; }
static inline mask mv_lowest_bit(mv_bits b) { return (mask)-(b & 1); }
static inline real mv_select(mask m, real a, real b)
{
    return (real)(((mv_bits)a & (mv_bits)m) | ((mv_bits)b & ~(mv_bits)m));
}
static inline real mv_fabs(real x) { return (real)((mv_bits)x & ~MV_SIGN_BITS); }
static inline real mv_copysign(real x, real sign)
{
    return (real)(((mv_bits)x & ~MV_SIGN_BITS) | ((mv_bits)sign & MV_SIGN_BITS));
}
static inline real mv_sqrt(real x)
{
    for (int lane = 0; lane < MEHVAR_LANES; lane++) x[lane] = MV_SCALAR(sqrt)(x[lane]);
    return x;
}

#endif

#define AND(a, b) ((a) & (b))
#define OR(a, b) ((a) | (b))
#define XOR(a, b) ((a) ^ (b))
#define SELECT(m, a, b) mv_select(m, a, b)
#define SELECT0(m, a) mv_select(m, a, SPLAT(0))
#define TRUTH(a) NE(a, K(0))
#define NUM(m) mv_select(m, SPLAT(1), SPLAT(0))

/* x with the sign changed where b has its sign bit set; other bits of b do not count */
static inline real mv_flip_sign(real x, mv_bits b) { return mv_from_bits(mv_to_bits(x) ^ (b & MV_SIGN_BITS)); }

/* true if the sign bit is set, also for -0 */
static inline mask mv_is_signed(real x) { return LT(mv_copysign(SPLAT(1), x), K(0)); }

/* sign(0) = 0, sign(NaN) = NaN */
static inline real mv_sign(real x) { return SELECT(LT(K(0), x), SPLAT(1), SELECT(LT(x, K(0)), SPLAT(-1), x)); }

/* as C99 fmin and fmax: the other operand when one is NaN */
static inline real mv_min(real a, real b) { return SELECT(OR(LT(a, b), NE(b, b)), a, b); }
static inline real mv_max(real a, real b) { return SELECT(OR(LT(b, a), NE(b, b)), a, b); }

/* nearest integer, even when halfway, for x >= 0 */
static inline real mv_nearest(real x) { return SELECT(LT(x, MV_WHOLE), x + MV_WHOLE - MV_WHOLE, x); }

static inline real mv_floor(real x)
{
    const real n = mv_copysign(mv_nearest(mv_fabs(x)), x);
    return n - NUM(LT(x, n));
}

static inline real mv_ceil(real x) { return -mv_floor(-x); }

/* squares are not scaled: overflows when the larger operand exceeds the square root of the largest number */
static inline real mv_hypot(real x, real y) { return mv_sqrt(x * x + y * y); }

/* Polynomial in z by Horner's rule, lowest coefficient first. Without `...`, which Microsoft's older preprocessor
 * hands on as one argument. */
#define MV_POLY2(z, a, b) (K(b) * (z) + K(a))
#define MV_POLY3(z, a, b, c) (MV_POLY2(z, b, c) * (z) + K(a))
#define MV_POLY4(z, a, b, c, d) (MV_POLY3(z, b, c, d) * (z) + K(a))
#define MV_POLY5(z, a, b, c, d, e) (MV_POLY4(z, b, c, d, e) * (z) + K(a))
#define MV_POLY6(z, a, b, c, d, e, f) (MV_POLY5(z, b, c, d, e, f) * (z) + K(a))
#define MV_POLY7(z, a, b, c, d, e, f, g) (MV_POLY6(z, b, c, d, e, f, g) * (z) + K(a))
#define MV_POLY8(z, a, b, c, d, e, f, g, h) (MV_POLY7(z, b, c, d, e, f, g, h) * (z) + K(a))
#define MV_POLY9(z, a, b, c, d, e, f, g, h, i) (MV_POLY8(z, b, c, d, e, f, g, h, i) * (z) + K(a))
#define MV_POLY10(z, a, b, c, d, e, f, g, h, i, j) (MV_POLY9(z, b, c, d, e, f, g, h, i, j) * (z) + K(a))
#define MV_POLY11(z, a, b, c, d, e, f, g, h, i, j, k) (MV_POLY10(z, b, c, d, e, f, g, h, i, j, k) * (z) + K(a))
#define MV_POLY12(z, a, b, c, d, e, f, g, h, i, j, k, l) (MV_POLY11(z, b, c, d, e, f, g, h, i, j, k, l) * (z) + K(a))
#define MV_POLY13(z, a, b, c, d, e, f, g, h, i, j, k, l, m)                                                          \
    (MV_POLY12(z, b, c, d, e, f, g, h, i, j, k, l, m) * (z) + K(a))

#endif
