/* SPDX-License-Identifier: Apache-2.0 */
/* The law with its memory and parameters, and the checks around it. */
#ifndef MEHVAR_PRIVATE_APP_H
#define MEHVAR_PRIVATE_APP_H

#include <stdint.h>

#include "mehvar/private/board_law.h"

enum { MV_APP_MEMORY = 0, MV_APP_P = 1, MV_APP_C = 2, MV_APP_S = 3, MV_APP_GROUPS = 4 };

typedef struct {
    uint32_t samples, crc, ticks; /* done; CRC-32 of all inputs; the slowest step */
    real x[MV_BOARD_NX], u[MV_BOARD_NU];
} mv_app_test;

/* Put the compiled-in parameters back and forget the memory. */
void mv_app_defaults(void);

/* Start the memory from a first measurement. The framed link does without: the host sets the memory. */
void mv_app_start(const real in[MV_BOARD_IN]);

/* Evaluate the law: `in` is what is measured, reference and applied input as the names of board_model.h say. Returns whether all
 * numbers were finite; when one was not, the inputs are zero and the memory is what it was, or what the law makes of a
 * lost measurement. */
int mv_app_step(real in[MV_BOARD_IN], real u[MV_BOARD_NU]);

/* A group of numbers and how many they are; null when there is no such group. */
real *mv_app_group(uint32_t group, uint32_t *count);

/* Whether numbers of a frame are finite; they need not be aligned. */
int mv_app_finite(const uint8_t *bytes, uint32_t count);

/* Whether finite numbers of a frame may become a group: parameters that are compiled into the law are what they are. */
int mv_app_settable(uint32_t group, const uint8_t *bytes);

/* Law and plant in closed loop on the target, from the scenario's start and the memory as it is. A byte on the line ends
 * it; `samples` of the result says how many were done. */
void mv_app_selftest(uint32_t samples, mv_app_test *result);

#endif
