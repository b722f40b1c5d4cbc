/* SPDX-License-Identifier: Apache-2.0 */
/* For free-standing builds without a C library; mem.c has the functions. */
#ifndef STRING_H
#define STRING_H

#include <stddef.h>

void *memcpy(void *restrict to, const void *restrict from, size_t count);
void *memset(void *to, int byte, size_t count);

#endif
