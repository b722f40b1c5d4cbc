/* SPDX-License-Identifier: Apache-2.0 */
/* All that generated C may call, for one number or a vector of them. Needs no C library, except for the functions of libm.h,
 * of which free-standing builds have none but mv_fmod. */
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
