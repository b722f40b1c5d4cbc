/* SPDX-License-Identifier: Apache-2.0 */
/* The functions that only boards use, to be compared with the C library's. */
#include <math.h>

#define sqrtf board_sqrtf
#include "sqrtf.c"
#undef sqrtf
#include "mehvar/private/fmod.h"

void square_roots(long n, const float *x, float *ours, float *theirs)
{
    for (long i = 0; i < n; i++) ours[i] = board_sqrtf(x[i]), theirs[i] = sqrtf(x[i]);
}

void remainders(long n, const float *x, const float *y, float *ours, float *theirs)
{
    for (long i = 0; i < n; i++) ours[i] = mv_fmod(x[i], y[i]), theirs[i] = fmodf(x[i], y[i]);
}
