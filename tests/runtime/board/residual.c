/* SPDX-License-Identifier: Apache-2.0 */
/* Which damage a frame's check does not notice. Usage: residual SEED FRAMES; prints, for each kind of damage, how many
 * damaged frames were taken for whole ones, and how many of these are not what was sent. */
#include <stdio.h>
#include <stdlib.h>

#include "process.h"

enum { KINDS = 11, STEP_BYTES = 4 * MV_BOARD_IN };

static uint64_t state;

static uint32_t next(void)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (uint32_t)(state >> 16);
}

static uint32_t below(uint32_t n) { return next() % n; }

static uint32_t damaged(uint8_t *line, uint32_t size, int kind)
{
    const uint32_t at = below(size - 8);
    uint8_t other;
    if (kind < 6) { /* one to six bits, anywhere */
        for (int i = 0; i <= kind; i++) line[below(size)] ^= (uint8_t)(1u << below(8));
        return size;
    }
    switch (kind) {
    case 6: /* a burst of two to eight bytes */
        for (uint32_t i = 0, n = 2 + below(7); i < n; i++) line[at + i] = (uint8_t)next();
        return size;
    case 7: /* a byte lost */
        memmove(line + at, line + at + 1, size - at - 1);
        return size - 1;
    case 8: /* a byte too many */
        memmove(line + at + 1, line + at, size - at);
        line[at] = (uint8_t)next();
        return size + 1;
    case 9: /* two neighbours swapped */
        other = line[at];
        line[at] = line[at + 1];
        line[at + 1] = other;
        return size;
    default: /* the end lost */
        return at + 1;
    }
}

int main(int argc, char **argv)
{
    static const char *const names[KINDS] = {"1 bit", "2 bits", "3 bits", "4 bits", "5 bits", "6 bits",
                                             "burst", "lost", "inserted", "swapped", "cut"};
    static mv_link_state to_send, to_read;
    const long frames = argc > 2 ? atol(argv[2]) : 0;
    long taken[KINDS] = {0}, wrong[KINDS] = {0};
    state = argc > 1 ? strtoull(argv[1], 0, 10) * 2654435761u + 1 : 1;
    for (long k = 0; k < frames; k++) {
        uint8_t body[MV_LINK_HEADER + STEP_BYTES], line[2 * sizeof body];
        const int kind = (int)(k % KINDS);
        body[0] = MV_SERVER_STEP;
        body[1] = 0;
        for (uint32_t i = 2; i < sizeof body; i++) body[i] = below(4) ? (uint8_t)next() : 0;
        memcpy(to_send.frame.bytes, body, sizeof body);
        sent_size = 0;
        mv_link_send(&to_send, STEP_BYTES);
        memcpy(line, sent, sent_size);
        const uint32_t size = damaged(line, sent_size, kind);
        mv_link_receive(&to_read, 0);
        for (uint32_t i = 0; i <= size; i++) {
            const int payload = mv_link_receive(&to_read, i < size ? line[i] : 0);
            if (payload < 0) continue;
            taken[kind]++;
            wrong[kind] += payload != STEP_BYTES || memcmp(to_read.frame.bytes, body, sizeof body) != 0;
        }
    }
    for (int kind = 0; kind < KINDS; kind++)
        printf("%s: %ld of %ld taken, %ld wrong\n", names[kind], taken[kind], frames / KINDS, wrong[kind]);
    return 0;
}
