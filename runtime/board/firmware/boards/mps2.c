/* SPDX-License-Identifier: Apache-2.0 */
/* ARM's MPS2 boards AN385 (Cortex-M3), AN386 (M4F) and AN500 (M7): 25 MHz, CMSDK UART 0. */
#include "mehvar/board.h"
#include "mehvar/private/cortexm.h"

#define UART_DATA REGISTER(0x40004000u)
#define UART_STATE REGISTER(0x40004004u)
#define UART_CTRL REGISTER(0x40004008u)
#define UART_INTCLEAR REGISTER(0x4000400Cu)
#define UART_BAUDDIV REGISTER(0x40004010u)

enum { HERTZ = 25000000, BAUD = 115200, RECEIVE_INTERRUPT = 0, PATIENCE = 100000 };

const char mv_board_name[] = "mps2";

void mv_board_init(void)
{
    UART_BAUDDIV = (HERTZ + BAUD / 2) / BAUD;
    UART_CTRL = 1u | 2u | 8u; /* transmit, receive, wake by a received byte */
    cortexm_wake_by(RECEIVE_INTERRUPT);
    cortexm_clock(HERTZ);
}

int mv_board_read(void)
{
    if (!(UART_STATE & 2u)) return -1;
    UART_INTCLEAR = 2u; /* before the byte is taken: the next one may come at once */
    return (int)(UART_DATA & 0xFFu);
}

void mv_board_write(const uint8_t *bytes, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        for (uint32_t n = 0; (UART_STATE & 1u) && n < PATIENCE; n++) {}
        UART_DATA = bytes[i];
    }
}

uint32_t mv_board_ms(void) { return cortexm_ms(); }

void mv_board_output(const mv_real *u) { (void)u; }
