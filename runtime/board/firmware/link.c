/* SPDX-License-Identifier: Apache-2.0 */
#include "mehvar/private/link.h"

#include "mehvar/board.h"

/* CRC by half bytes: the table takes 64 bytes, one for whole bytes 1 kB of flash. */
static uint32_t crc_of(uint32_t crc, const uint8_t *bytes, uint32_t count)
{
    static const uint32_t table[16] = {
        0x00000000u, 0x105EC76Fu, 0x20BD8EDEu, 0x30E349B1u, 0x417B1DBCu, 0x5125DAD3u, 0x61C69362u, 0x7198540Du,
        0x82F63B78u, 0x92A8FC17u, 0xA24BB5A6u, 0xB21572C9u, 0xC38D26C4u, 0xD3D3E1ABu, 0xE330A81Au, 0xF36E6F75u,
    };
    for (uint32_t i = 0; i < count; i++) {
        crc ^= bytes[i];
        crc = (crc >> 4) ^ table[crc & 15u];
        crc = (crc >> 4) ^ table[crc & 15u];
    }
    return crc;
}

static void put32(uint8_t *to, uint32_t value)
{
    for (int i = 0; i < 4; i++) to[i] = (uint8_t)(value >> 8 * i);
}

static uint32_t get32(const uint8_t *from)
{
    return from[0] | (uint32_t)from[1] << 8 | (uint32_t)from[2] << 16 | (uint32_t)from[3] << 24;
}

uint32_t mv_link_crc(const uint8_t *bytes, uint32_t count)
{
    uint8_t size[4];
    put32(size, count - MV_LINK_HEADER);
    return ~crc_of(crc_of(0xFFFFFFFFu, size, sizeof size), bytes, count);
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
    const uint32_t body = size - MV_LINK_CRC;
    if (mv_link_crc(link->frame.bytes, body) != get32(link->frame.bytes + body)) {
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
    if (link->code != 0 && link->code != 0xFF) append(link, 0); /* the zero at the end of the previous block */
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
    put32(bytes + body, mv_link_crc(bytes, body));
    mv_board_write(&zero, 1);
    send_encoded(bytes, body + MV_LINK_CRC);
    mv_board_write(&zero, 1);
    restart(link);
}
