/* SPDX-License-Identifier: Apache-2.0 */
/* All that generated C may call, for one number or a vector of them (see mehvar_real.h). Needs no C library, except
 * for the functions of mehvar_libm.h, of which free-standing builds have none but mv_fmod. */
#ifndef MEHVAR_MATH_H
#define MEHVAR_MATH_H

#include "mehvar_exp.h"
#include "mehvar_real.h"
#include "mehvar_trig.h"
#if __STDC_HOSTED__
#include "mehvar_libm.h"
#else
#include "mehvar_fmod.h"
#endif

#endif
