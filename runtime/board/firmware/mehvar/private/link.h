/* SPDX-License-Identifier: Apache-2.0 */
/* Frames on a stream of bytes: 0x00 COBS(type u8 | flags u8 | seq u16 | payload | crc u16) 0x00, little-endian.
 * The CRC is CCITT-FALSE (0x1021, start 0xFFFF) over type to payload. */
#ifndef MEHVAR_PRIVATE_LINK_H
#define MEHVAR_PRIVATE_LINK_H

#include <stdint.h>

#include "mehvar/private/board_law.h"

enum { MV_LINK_HEADER = 4, MV_LINK_CRC = 2, MV_LINK_SMALLEST = MV_LINK_HEADER + MV_LINK_CRC };
enum { MV_LINK_MAX = MV_LINK_SMALLEST + MV_BOARD_PAYLOAD };

typedef struct {
    uint32_t frames, crc, length, cobs; /* received whole, and what was wrong with the others */
    uint16_t size;                      /* bytes in `bytes` so far */
    uint8_t left, code;                 /* of the COBS block being read: bytes to come, first byte */
    uint8_t overlong;
    union {
        uint8_t bytes[MV_LINK_MAX];
        uint32_t aligned;
    } frame;
} mv_link_state;

/* Take a byte; returns the size of the payload when it ends a frame, else -1. */
int mv_link_receive(mv_link_state *link, uint8_t byte);

/* Send header and payload from link->frame: the receiver starts anew, as a link carries one direction at a time. */
void mv_link_send(mv_link_state *link, uint32_t payload);

uint16_t mv_link_crc16(const uint8_t *bytes, uint32_t count);

#endif
