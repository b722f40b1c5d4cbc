/* SPDX-License-Identifier: Apache-2.0 */
/* The law with its memory and parameters, and the checks around it. */
#ifndef APP_H
#define APP_H

#include <stdint.h>

#include "board_model.h"

enum { APP_MEMORY = 0, APP_P = 1, APP_C = 2, APP_S = 3, APP_GROUPS = 4 };

typedef struct {
    uint32_t samples, crc, ticks; /* done; CRC-32 of all inputs; the slowest step */
    real x[BOARD_NX], u[BOARD_NU];
} app_test;

/* Put the compiled-in parameters back and forget the memory. */
void app_defaults(void);

/* Start the memory from a first measurement. The framed link does without: the host sets the memory. */
void app_start(const real in[BOARD_IN]);

/* Evaluate the law: `in` is state, reference and applied input as the names of board_model.h say. Returns whether all
 * numbers were finite; when one was not, the inputs are zero and the memory is what it was, or what the law makes of a
 * lost measurement. */
int app_step(real in[BOARD_IN], real u[BOARD_NU]);

/* A group of numbers and how many they are; null when there is no such group. */
real *app_group(uint32_t group, uint32_t *count);

/* Law and plant in closed loop on the target, from the scenario's start and the memory as it is. */
void app_selftest(uint32_t samples, app_test *result);

#endif
