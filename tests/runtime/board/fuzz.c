/* SPDX-License-Identifier: Apache-2.0 */
/* Throws frames at the server: whole ones, damaged ones, noise. Usage: fuzz SEED FRAMES; prints what became of them.
 * Whatever comes, what the actuators hold must be finite. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mehvar/board.h"
#include "mehvar/private/link.h"
#include "mehvar/server.h"

const char mv_board_name[] = "fuzz";

static uint64_t state;
static uint32_t ms, answers;
static int zeros;

void mv_board_init(void) {}
int mv_board_read(void) { return -1; }
void mv_board_wait(void) {}
uint32_t mv_board_ms(void) { return ms; }
uint32_t mv_board_ticks(void) { return ms; }
uint32_t mv_board_ticks_per_second(void) { return 1000; }
void mv_board_reset(void) { mv_server_init(); }

void mv_board_stack(uint32_t *used, uint32_t *size)
{
    *used = 0;
    *size = 0;
}

void mv_board_write(const uint8_t *bytes, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) zeros += bytes[i] == 0;
    answers = (uint32_t)zeros / 2;
}

void mv_board_output(const mv_real *u)
{
    for (int i = 0; i < MV_BOARD_NU; i++)
        if (!isfinite(u[i])) {
            printf("input %d is not finite\n", i);
            abort();
        }
}

static uint32_t next(void)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (uint32_t)(state >> 16);
}

static uint32_t below(uint32_t n) { return next() % n; }

/* body, then its CRC: right, as a rule */
static uint32_t body(uint8_t *to)
{
    static const uint8_t types[] = {1, 2, 3, 3, 3, 3, 4, 5, 5, 6, 7, 8};
    enum { STEP = 4 * MV_BOARD_IN };
    static const uint32_t sizes[] = {0, 0, STEP, STEP, STEP, STEP, 1, 0, 0, 0, 4, 0};
    static const uint32_t groups[] = {MV_BOARD_NZ, MV_BOARD_NP, MV_BOARD_NC, MV_BOARD_NS};
    const uint32_t kind = below(sizeof types), which = below(4);
    uint32_t size = sizes[kind];
    to[0] = below(20) ? types[kind] : (uint8_t)next();
    to[1] = (uint8_t)next();
    to[2] = (uint8_t)below(4);
    to[3] = 0;
    if (types[kind] == 5) size = 1 + 4 * groups[which];
    if (below(20) == 0) size = below(MV_LINK_MAX + 40);
    for (uint32_t i = 0; i < size; i++) to[4 + i] = (uint8_t)next();
    for (uint32_t i = 0; i + 4 <= size && below(4); i += 4) {
        const float value = (float)below(2000) * 1e-3f - 1.0f;
        memcpy(to + 4 + i + (types[kind] == 5), &value, sizeof value);
    }
    if (types[kind] == 4 || types[kind] == 5) to[4] = (uint8_t)(below(10) ? which : next());
    if (types[kind] == 7 && size == 4) {
        const uint32_t samples = below(3);
        memcpy(to + 4, &samples, sizeof samples);
    }
    const uint16_t crc = (uint16_t)(mv_link_crc16(to, 4 + size) ^ (below(30) ? 0 : next()));
    to[4 + size] = (uint8_t)crc;
    to[5 + size] = (uint8_t)(crc >> 8);
    return 6 + size;
}

static uint32_t stuffed(const uint8_t *from, uint32_t size, uint8_t *to)
{
    uint32_t n = 0, code = n++;
    to[code] = 1;
    for (uint32_t i = 0; i < size; i++) {
        if (from[i] != 0) {
            to[n++] = from[i];
            to[code]++;
        }
        if (from[i] == 0 || to[code] == 0xFF) {
            code = n++;
            to[code] = 1;
        }
    }
    return n;
}

static uint32_t damaged(uint8_t *bytes, uint32_t size)
{
    const uint32_t at = below(size);
    switch (below(4)) {
    case 0: bytes[at] ^= (uint8_t)(1u << below(8)); return size;
    case 1: memmove(bytes + at, bytes + at + 1, size - at - 1); return size - 1;
    case 2: memmove(bytes + at + 1, bytes + at, size - at); bytes[at] = (uint8_t)next(); return size + 1;
    default: return at;
    }
}

int main(int argc, char **argv)
{
    static uint8_t plain[2 * MV_LINK_MAX], line[4 * MV_LINK_MAX];
    const long frames = argc > 2 ? atol(argv[2]) : 0;
    state = argc > 1 ? strtoull(argv[1], 0, 10) * 2654435761u + 1 : 1;
    mv_server_init();
    for (long k = 0; k < frames; k++) {
        uint32_t size = stuffed(plain, body(plain), line);
        if (below(3) == 0) size = damaged(line, size);
        if (below(50) == 0)
            for (size = below(3 * MV_LINK_MAX), ms += 100; size > 0; size--) mv_server_byte((uint8_t)next());
        for (uint32_t i = 0; i < size; i++) mv_server_byte(line[i]);
        mv_server_byte(0);
        ms += below(1500);
        mv_server_watch(ms);
    }
    printf("%ld frames sent, %u answers\n", frames, answers);
    return 0;
}
