/* SPDX-License-Identifier: Apache-2.0 */
/* A board without hardware: bytes in, bytes out, a clock that the test moves, outputs that it reads. */
#include <string.h>

#include "mehvar/board.h"
#include "mehvar/private/link.h"
#include "mehvar/server.h"

const char mv_board_name[] = "test";

static uint8_t sent[8 * MV_LINK_MAX];
static uint32_t sent_size, ms;
static mv_real actuators[MV_BOARD_NU];

void mv_board_init(void) {}
int mv_board_read(void) { return -1; }
void mv_board_wait(void) {}
uint32_t mv_board_ms(void) { return ms; }
uint32_t mv_board_ticks(void) { return ms; }
uint32_t mv_board_ticks_per_second(void) { return 1000; }
void mv_board_reset(void) { mv_server_init(); }
void mv_board_output(const mv_real *u) { memcpy(actuators, u, sizeof actuators); }

void mv_board_stack(uint32_t *used, uint32_t *size)
{
    *used = 0;
    *size = 0;
}

void mv_board_write(const uint8_t *bytes, uint32_t count)
{
    if (sent_size + count > sizeof sent) sent_size = 0;
    memcpy(sent + sent_size, bytes, count);
    sent_size += count;
}

static void pass(uint32_t time)
{
    for (uint32_t left = time; left > 0;) {
        const uint32_t part = left < 10 ? left : 10; /* the main loop turns at least that often */
        ms += part;
        left -= part;
        mv_server_watch(ms);
    }
}
