/* SPDX-License-Identifier: Apache-2.0 */
/* What a board must offer: one file in boards/ for each. Everything else is portable. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

#include "mehvar_math.h"

void board_init(void);
int board_read(void);                                     /* next received byte, or -1 */
void board_write(const uint8_t *bytes, uint32_t count);
void board_wait(void);                                    /* sleep until something may have happened */
uint32_t board_ms(void);                                  /* time since start; call it at least every 50 ms */
uint32_t board_ticks(void);                               /* counter of board_ticks_per_second, for measuring */
uint32_t board_ticks_per_second(void);
void board_output(const real *u);                         /* the law's inputs, to the actuators */
void board_stack(uint32_t *used, uint32_t *size);         /* high water and size, bytes; 0 when not known */
void board_reset(void);

extern const char board_name[];

#endif
