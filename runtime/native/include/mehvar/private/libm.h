/* SPDX-License-Identifier: Apache-2.0 */
/* Rarely used functions of the C library, called lane by lane. Only for hosted builds; the last digits depend on the library
 * but not on the number of lanes. */
#ifndef MEHVAR_PRIVATE_LIBM_H
#define MEHVAR_PRIVATE_LIBM_H

#include <math.h>

#include "operations.h"

#ifdef MEHVAR_FLOAT
#define MV_LIBM(function) function##f
#else
#define MV_LIBM(function) function
#endif

#if MEHVAR_LANES == 1
#define MV_EACH_LANE(x, call) (x = call)
#define MV_LANE(x) (x)
#else
#define MV_EACH_LANE(x, call) for (int lane = 0; lane < MEHVAR_LANES; lane++) x[lane] = call
#define MV_LANE(x) (x)[lane]
#endif

#define MV_DEFINE_LIBM(function)                                                                                     \
    static inline real mv_##function(real x)                                                                         \
    {                                                                                                                \
        MV_EACH_LANE(x, MV_LIBM(function)(MV_LANE(x)));                                                              \
        return x;                                                                                                    \
    }
MV_DEFINE_LIBM(sinh)
MV_DEFINE_LIBM(cosh)
MV_DEFINE_LIBM(tanh)
MV_DEFINE_LIBM(asinh)
MV_DEFINE_LIBM(acosh)
MV_DEFINE_LIBM(atanh)
MV_DEFINE_LIBM(expm1)
MV_DEFINE_LIBM(log1p)
MV_DEFINE_LIBM(erf)

#ifndef MEHVAR_NO_LIBM
static inline real mv_fmod(real x, real y)
{
    MV_EACH_LANE(x, MV_LIBM(fmod)(MV_LANE(x), MV_LANE(y)));
    return x;
}
#endif

#endif
