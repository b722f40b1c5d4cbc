/* SPDX-License-Identifier: Apache-2.0 */
/* Frames on a stream of bytes, little-endian:
 *     0x00 COBS(type u8 | flags u8 | session u16 | number u32 | payload | crc u32) 0x00
 * The CRC is CRC-32C (Castagnoli, 0x1EDC6F41, reflected, start and end 0xFFFFFFFF) over the size of the payload, u32, and
 * over type to payload. It detects any five wrong bits in up to 655 bytes; the CRC-32 of Ethernet does so only up to
 * 371 bytes (Koopman, 32-bit cyclic redundancy codes for Internet applications, DSN 2002, table 1). */
#ifndef MEHVAR_PRIVATE_LINK_H
#define MEHVAR_PRIVATE_LINK_H

#include <stdint.h>

#include "mehvar/private/board_law.h"

enum { MV_LINK_HEADER = 8, MV_LINK_CRC = 4, MV_LINK_SMALLEST = MV_LINK_HEADER + MV_LINK_CRC };
enum { MV_LINK_MAX = MV_LINK_SMALLEST + MV_BOARD_PAYLOAD };

typedef struct {
    uint32_t frames, crc, length, cobs; /* received frames, and errors by kind */
    uint16_t size;                      /* bytes in `bytes` so far */
    uint8_t left, code;                 /* of the present COBS block: missing bytes, first byte */
    uint8_t overlong;
    union {
        uint8_t bytes[MV_LINK_MAX];
        uint32_t aligned;
    } frame;
} mv_link_state;

/* Convert words between line and processor byte order; both are equal on little-endian processors. */
static inline void mv_link_words(uint8_t *bytes, uint32_t count)
{
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    for (; count > 0; count--, bytes += 4) {
        const uint8_t first = bytes[0], second = bytes[1];
        bytes[0] = bytes[3], bytes[1] = bytes[2], bytes[2] = second, bytes[3] = first;
    }
#else
    (void)bytes, (void)count;
#endif
}

/* Receive a byte; return the size of the payload if it ends a frame, else -1. */
int mv_link_receive(mv_link_state *link, uint8_t byte);

/* Send header and payload from link->frame, and reset the receiver: a link carries one direction at a time. */
void mv_link_send(mv_link_state *link, uint32_t payload);

/* The CRC of a frame without its last four bytes. */
uint32_t mv_link_crc(const uint8_t *bytes, uint32_t count);

#endif
