/* SPDX-License-Identifier: Apache-2.0 */
/* Another server: the paper's bare packets, BOARD_RAW_IN numbers down and BOARD_NU numbers up, without frame, check or
 * sequence number. A pause within a packet of more than half a period starts the next one. The first packet starts the
 * law's memory. */
#include <string.h>

#include "app.h"
#include "board.h"
#include "server.h"

enum { RAW_PAUSE_MS = BOARD_PERIOD_MS / 2 };

static union {
    real numbers[BOARD_RAW_IN];
    uint8_t bytes[BOARD_RAW_IN * sizeof(real)];
} packet;
static uint32_t size, last_ms;
static uint8_t started, silent;

void server_init(void) { app_defaults(); }

void server_byte(uint8_t byte)
{
    real u[BOARD_NU];
    const uint32_t ms = board_ms();
    if (ms - last_ms > RAW_PAUSE_MS) size = 0;
    last_ms = ms;
    packet.bytes[size++] = byte;
    if (size < sizeof packet) return;
    size = 0;
    if (!started) app_start(packet.numbers);
    started = 1;
    silent = 0;
    app_step(packet.numbers, u);
    board_output(u);
    board_write((const uint8_t *)u, sizeof u);
}

void server_watch(uint32_t ms)
{
    static const real zero[BOARD_NU];
    if (!started || silent || ms - last_ms <= 2u * BOARD_PERIOD_MS) return;
    silent = 1;
    board_output(zero);
}
