/* SPDX-License-Identifier: Apache-2.0 */
/* Functions of a board, which one file in boards/ defines. All other files are portable. */
#ifndef MEHVAR_BOARD_H
#define MEHVAR_BOARD_H

#include <stdint.h>

#include "mehvar/real.h"

#ifdef __cplusplus
extern "C" {
#endif

void mv_board_init(void);
int mv_board_read(void);                             /* next received byte, or -1 */
void mv_board_write(const uint8_t *bytes, uint32_t count);
void mv_board_wait(void);                            /* sleep until an event */
uint32_t mv_board_ms(void);                          /* time since start; call it at least every 50 ms */
uint32_t mv_board_ticks(void);                       /* counter of mv_board_ticks_per_second, for measuring */
uint32_t mv_board_ticks_per_second(void);
void mv_board_output(const mv_real *u);              /* the law's inputs, to the actuators */
void mv_board_stack(uint32_t *used, uint32_t *size); /* largest use and size, bytes; 0 if unknown */
void mv_board_reset(void);

extern const char mv_board_name[];

#ifdef __cplusplus
}
#endif

#endif
