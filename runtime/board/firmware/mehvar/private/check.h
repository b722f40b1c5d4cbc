/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of numbers that come from sensors, lines and tables. */
#ifndef MEHVAR_PRIVATE_CHECK_H
#define MEHVAR_PRIVATE_CHECK_H

#include "mehvar/private/operations.h"

/* Added to the bits of a number without its sign: reaches the sign bit if and only if it is infinite or NaN. */
#define MV_EXPONENT_UNIT ((mv_bits)1 << MV_DIGITS)

/* Return 1 if all are finite. */
static int mv_finite_all(const real *v, uint32_t n)
{
    mv_bits above = 0;
    for (uint32_t i = 0; i < n; i++) above |= (mv_to_bits(v[i]) & ~MV_SIGN_BITS) + MV_EXPONENT_UNIT;
    return !(above & MV_SIGN_BITS);
}

#endif
