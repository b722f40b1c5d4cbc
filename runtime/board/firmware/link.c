/* SPDX-License-Identifier: Apache-2.0 */
#include "mehvar/private/link.h"

#include "mehvar/board.h"

uint16_t mv_link_crc16(const uint8_t *bytes, uint32_t count)
{
    uint32_t crc = 0xFFFFu;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t x = (crc >> 8) ^ bytes[i];
        x ^= x >> 4;
        crc = ((crc << 8) ^ (x << 12) ^ (x << 5) ^ x) & 0xFFFFu;
    }
    return (uint16_t)crc;
}

static void restart(mv_link_state *link)
{
    link->size = 0;
    link->left = 0;
    link->code = 0;
    link->overlong = 0;
}

static void append(mv_link_state *link, uint8_t byte)
{
    if (link->size < MV_LINK_MAX)
        link->frame.bytes[link->size++] = byte;
    else
        link->overlong = 1;
}

static int finish(mv_link_state *link)
{
    const uint32_t size = link->size;
    const int empty = link->code == 0, whole = link->left == 0, overlong = link->overlong;
    restart(link);
    if (empty) return -1;
    if (!whole) {
        link->cobs++;
        return -1;
    }
    if (overlong || size < MV_LINK_SMALLEST) {
        link->length++;
        return -1;
    }
    const uint8_t *end = link->frame.bytes + size - MV_LINK_CRC;
    if (mv_link_crc16(link->frame.bytes, size - MV_LINK_CRC) != (uint16_t)(end[0] | (uint32_t)end[1] << 8)) {
        link->crc++;
        return -1;
    }
    link->frames++;
    return (int)(size - MV_LINK_SMALLEST);
}

int mv_link_receive(mv_link_state *link, uint8_t byte)
{
    if (byte == 0) return finish(link);
    if (link->left > 0) {
        append(link, byte);
        link->left--;
        return -1;
    }
    if (link->code != 0 && link->code != 0xFF) append(link, 0); /* the zero that ended the block before */
    link->code = byte;
    link->left = (uint8_t)(byte - 1);
    return -1;
}

static void send_encoded(const uint8_t *bytes, uint32_t count)
{
    uint32_t start = 0;
    for (;;) {
        uint32_t end = start;
        while (end < count && bytes[end] != 0 && end - start < 254) end++;
        const uint8_t code = (uint8_t)(end - start + 1);
        mv_board_write(&code, 1);
        mv_board_write(bytes + start, end - start);
        if (end == count) return;
        start = code == 0xFF ? end : end + 1; /* a block of 254 stands for no zero, not even for one that follows */
    }
}

void mv_link_send(mv_link_state *link, uint32_t payload)
{
    static const uint8_t zero = 0;
    uint8_t *bytes = link->frame.bytes;
    const uint32_t body = MV_LINK_HEADER + payload;
    const uint16_t crc = mv_link_crc16(bytes, body);
    bytes[body] = (uint8_t)crc;
    bytes[body + 1] = (uint8_t)(crc >> 8);
    mv_board_write(&zero, 1);
    send_encoded(bytes, body + MV_LINK_CRC);
    mv_board_write(&zero, 1);
    restart(link);
}
