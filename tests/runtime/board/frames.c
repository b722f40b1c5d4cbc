/* SPDX-License-Identifier: Apache-2.0 */
/* The firmware's ends of the line as functions: what it sends for a frame, and what it makes of bytes. */
#include <string.h>

#include "mehvar/board.h"
#include "mehvar/private/link.h"

static mv_link_state line;
static uint8_t *sent;
static long size;

void mv_board_write(const uint8_t *bytes, uint32_t count)
{
    memcpy(sent + size, bytes, count);
    size += count;
}

/* Send header and payload; returns the bytes on the line. */
long send_frame(const uint8_t *body, long payload, uint8_t *to)
{
    sent = to;
    size = 0;
    memcpy(line.frame.bytes, body, MV_LINK_HEADER + (size_t)payload);
    mv_link_send(&line, (uint32_t)payload);
    return size;
}

/* Take bytes; returns the size of the payload of the last whole frame, whose header and payload are copied, or -1. */
long receive_bytes(const uint8_t *bytes, long count, uint8_t *to)
{
    long payload = -1;
    for (long i = 0; i < count; i++) {
        const int n = mv_link_receive(&line, bytes[i]);
        if (n < 0) continue;
        payload = n;
        memcpy(to, line.frame.bytes, MV_LINK_HEADER + (size_t)n);
    }
    return payload;
}

long largest_payload(void) { return MV_BOARD_PAYLOAD; }
