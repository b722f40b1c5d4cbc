/* SPDX-License-Identifier: Apache-2.0 */
/* Square root for processors without the instruction, one digit at a time. */
#define MEHVAR_NO_LIBM
#include "mehvar/private/operations.h"

float sqrtf(float x);

float sqrtf(float x) { return mv_sqrt_by_digits(x); }
