/* SPDX-License-Identifier: Apache-2.0 */
/* The numbers of generated C: an `mv_real` is a scalar or a vector of scalars, one per lane.
 *
 * MEHVAR_LANES  1 (default), 2, 4, 8 or 16
 * MEHVAR_FLOAT  when defined, the scalar is a float instead of a double
 *
 * Both must be equal in all files of a program. Vectors need GNU C (gcc, clang) and their natural alignment. */
#ifndef MEHVAR_REAL_H
#define MEHVAR_REAL_H

#ifndef MEHVAR_LANES
#define MEHVAR_LANES 1
#endif
#if MEHVAR_LANES != 1 && MEHVAR_LANES != 2 && MEHVAR_LANES != 4 && MEHVAR_LANES != 8 && MEHVAR_LANES != 16
#error "MEHVAR_LANES must be 1, 2, 4, 8 or 16"
#endif

#ifdef MEHVAR_FLOAT
typedef float mv_scalar;
#define MV_BYTES 4
#else
typedef double mv_scalar;
#define MV_BYTES 8
#endif

#if MEHVAR_LANES == 1
typedef mv_scalar mv_real;
#elif defined __GNUC__
typedef mv_scalar mv_real __attribute__((vector_size(MEHVAR_LANES * MV_BYTES)));
#else
#error "vectors of lanes need GNU C: gcc or clang"
#endif

#endif
