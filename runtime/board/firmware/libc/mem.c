/* SPDX-License-Identifier: Apache-2.0 */
/* Functions that compilers call even in free-standing code. */
#include <stdint.h>

#include "string.h"

void *memcpy(void *restrict to, const void *restrict from, size_t count)
{
    uint8_t *t = to;
    const uint8_t *f = from;
    if ((((uintptr_t)t | (uintptr_t)f) & 3u) == 0)
        for (; count >= 4; count -= 4, t += 4, f += 4) *(uint32_t *)(void *)t = *(const uint32_t *)(const void *)f;
    for (; count > 0; count--) *t++ = *f++;
    return to;
}

void *memset(void *to, int byte, size_t count)
{
    uint8_t *t = to;
    for (; count > 0; count--) *t++ = (uint8_t)byte;
    return to;
}
