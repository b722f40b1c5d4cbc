/* SPDX-License-Identifier: Apache-2.0 */
/* The law with its memory and parameters, and the checks around it. */
#ifndef MEHVAR_PRIVATE_APP_H
#define MEHVAR_PRIVATE_APP_H

#include <stdint.h>

#include "mehvar/private/board_law.h"

enum { MV_APP_MEMORY = 0, MV_APP_P = 1, MV_APP_C = 2, MV_APP_S = 3, MV_APP_GROUPS = 4 };

typedef struct {
    uint32_t samples, crc, ticks; /* finished samples; CRC-32 of all inputs; slowest step */
    real x[MV_BOARD_NX], u[MV_BOARD_NU];
} mv_app_test;

/* Restore the compiled-in parameters and clear the memory. */
void mv_app_defaults(void);

/* Initialise the memory from a first measurement; over the framed link the host sets the memory instead. */
void mv_app_start(const real in[MV_BOARD_IN]);

/* Evaluate the law; `in` has measurements, reference and applied input as named in board_model.h. Returns 1 if all numbers
 * were finite. Otherwise the inputs are zero, and the memory is unchanged or what the law sets for a lost measurement. */
int mv_app_step(real in[MV_BOARD_IN], real u[MV_BOARD_NU]);

/* Return a group of numbers and its size; null for an unknown group. */
real *mv_app_group(uint32_t group, uint32_t *count);

/* Return 1 if the numbers of a frame, possibly unaligned, are finite. */
int mv_app_finite(const uint8_t *bytes, uint32_t count);

/* Return 1 if finite numbers of a frame may replace a group; compiled-in constants must be equal. */
int mv_app_settable(uint32_t group, const uint8_t *bytes);

/* Run law and plant in closed loop on the target, from the scenario's start and the present memory. A byte on the line ends
 * the run; `samples` of the result counts finished samples. */
void mv_app_selftest(uint32_t samples, mv_app_test *result);

#endif
