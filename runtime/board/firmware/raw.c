/* SPDX-License-Identifier: Apache-2.0 */
/* Server for the paper's bare packets: MV_BOARD_RAW_IN numbers down and MV_BOARD_NU numbers up, without frame, checksum or
 * sequence number. A pause of more than half a period within a packet starts the next one. The first packet initialises the
 * law's memory. */
#include <string.h>

#include "mehvar/private/app.h"
#include "mehvar/board.h"
#include "mehvar/private/link.h"
#include "mehvar/server.h"

enum { RAW_PAUSE_MS = MV_BOARD_PERIOD_MS / 2 };

static union {
    real numbers[MV_BOARD_RAW_IN];
    uint8_t bytes[MV_BOARD_RAW_IN * sizeof(real)];
} packet;
static uint32_t size, last_ms, step_ms;
static uint8_t started, silent;

void mv_server_init(void) { mv_app_defaults(); }

void mv_server_byte(uint8_t byte)
{
    real u[MV_BOARD_NU];
    const uint32_t ms = mv_board_ms();
    if (ms - last_ms > RAW_PAUSE_MS) size = 0;
    last_ms = ms;
    packet.bytes[size++] = byte;
    if (size < sizeof packet) return;
    size = 0;
    mv_link_words(packet.bytes, MV_BOARD_RAW_IN);
    if (!started) mv_app_start(packet.numbers);
    started = 1;
    silent = 0;
    step_ms = ms;
    mv_app_step(packet.numbers, u);
    mv_board_output(u);
    mv_link_words((uint8_t *)u, MV_BOARD_NU);
    mv_board_write((const uint8_t *)u, sizeof u);
}

void mv_server_watch(uint32_t ms)
{
    static const real zero[MV_BOARD_NU];
    if (!started || silent || ms - step_ms <= 2u * MV_BOARD_PERIOD_MS) return;
    silent = 1;
    mv_board_output(zero);
}
