/* SPDX-License-Identifier: Apache-2.0 */
/* Dual numbers, in place of the headers of plain numbers: a value and its derivative along one direction. With them,
 * generated functions give directional derivatives, exact to rounding, with respect to all their arguments.
 *
 * They are complex numbers whose imaginary part is the derivative times TINY, so that products of two such parts vanish.
 * The derivative of a step is zero, as is 0 * inf in the chain rule for saturated arguments. */
#ifndef MEHVAR_FMU_DUAL_H
#define MEHVAR_FMU_DUAL_H

#define MEHVAR_REAL_H
#define MEHVAR_PRIVATE_ARITHMETIC_H
#define MEHVAR_LANES 1

#include <math.h>

/* Its square is below the least double, also times 1e36; what it is multiplied by is not, down to 1e-100. */
#define TINY 0x1p-600

typedef double mv_scalar, scalar;
typedef double _Complex mv_real, real;
typedef int mask;

#define K(c) ((double)(c))
#define SPLAT(c) ((real)K(c))
#define LT(a, b) ((double)(a) < (double)(b))
#define LE(a, b) ((double)(a) <= (double)(b))
#define EQ(a, b) ((double)(a) == (double)(b))
#define NE(a, b) ((double)(a) != (double)(b))
#define NOT(m) (!(m))
#define AND(a, b) ((a) & (b))
#define OR(a, b) ((a) | (b))
#define SELECT(m, a, b) ((m) ? (real)(a) : (real)(b))
#define SELECT0(m, a) SELECT(m, a, 0.0)
#define TRUTH(a) NE(a, 0.0)
#define NUM(m) SPLAT((m) ? 1 : 0)

static inline real mv_dual(double value, double slope, double along)
{
    real z;
    __real__ z = value;
    __imag__ z = along == 0.0 ? 0.0 : slope * along;
    return z;
}

/* Of x, the value of z. */
#define MV_DUAL(name, value, slope)                                                                                  \
    static inline real mv_##name(real z)                                                                             \
    {                                                                                                                \
        const double x = __real__ z;                                                                                 \
        return mv_dual(value, slope, __imag__ z);                                                                    \
    }
MV_DUAL(sqrt, sqrt(x), 0.5 / sqrt(x))
MV_DUAL(fabs, fabs(x), (x > 0) - (x < 0))
MV_DUAL(sign, x > 0 ? 1.0 : x < 0 ? -1.0 : x, 0.0)
MV_DUAL(floor, floor(x), 0.0)
MV_DUAL(ceil, ceil(x), 0.0)
MV_DUAL(sin, sin(x), cos(x))
MV_DUAL(cos, cos(x), -sin(x))
MV_DUAL(tan, tan(x), 1 + tan(x) * tan(x))
MV_DUAL(asin, asin(x), 1 / sqrt((1 - x) * (1 + x)))
MV_DUAL(acos, acos(x), -1 / sqrt((1 - x) * (1 + x)))
MV_DUAL(atan, atan(x), 1 / (1 + x * x))
MV_DUAL(exp, exp(x), exp(x))
MV_DUAL(log, log(x), 1 / x)
MV_DUAL(log1p, log1p(x), 1 / (1 + x))
MV_DUAL(expm1, expm1(x), exp(x))
MV_DUAL(sinh, sinh(x), cosh(x))
MV_DUAL(cosh, cosh(x), sinh(x))
MV_DUAL(tanh, tanh(x), 1 / (cosh(x) * cosh(x)))
MV_DUAL(asinh, asinh(x), 1 / sqrt(1 + x * x))
MV_DUAL(acosh, acosh(x), 1 / sqrt((x - 1) * (x + 1)))
MV_DUAL(atanh, atanh(x), 1 / ((1 - x) * (1 + x)))
MV_DUAL(erf, erf(x), 1.1283791670955126 * exp(-x * x))

/* Of two, with the slope by each. */
#define MV_DUAL2(name, value, slope_a, slope_b)                                                                      \
    static inline real mv_##name(real za, real zb)                                                                   \
    {                                                                                                                \
        const double a = __real__ za, b = __real__ zb;                                                               \
        return mv_dual(value, slope_a, __imag__ za) + mv_dual(0.0, slope_b, __imag__ zb);                            \
    }
MV_DUAL2(copysign, copysign(a, b), signbit(a) == signbit(b) ? 1.0 : -1.0, 0.0)
MV_DUAL2(fmod, fmod(a, b), 1.0, -trunc(a / b))
MV_DUAL2(hypot, hypot(a, b), a / hypot(a, b), b / hypot(a, b))
MV_DUAL2(atan2, atan2(a, b), b / (a * a + b * b), -a / (a * a + b * b))
MV_DUAL2(pow, pow(a, b), b == 0.0 ? 0.0 : b * pow(a, b - 1), a > 0 ? log(a) * pow(a, b) : 0.0)
MV_DUAL2(min, fmin(a, b), a <= b || b != b, !(a <= b || b != b))
MV_DUAL2(max, fmax(a, b), a >= b || b != b, !(a >= b || b != b))

static inline void mv_sincos(real z, real *sine, real *cosine) { *sine = mv_sin(z), *cosine = mv_cos(z); }

#endif
