/* SPDX-License-Identifier: Apache-2.0 */
/* All functions that generated C may call, for a number or a vector. They need no C library, except those of libm.h, of
 * which free-standing builds have only mv_fmod. */
#ifndef MEHVAR_PRIVATE_ARITHMETIC_H
#define MEHVAR_PRIVATE_ARITHMETIC_H

#include "exp.h"
#include "operations.h"
#include "trig.h"
#if __STDC_HOSTED__
#include "libm.h"
#endif
#if !__STDC_HOSTED__ || defined MEHVAR_NO_LIBM
#include "fmod.h"
#endif

#endif
