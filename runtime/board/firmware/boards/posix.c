/* SPDX-License-Identifier: Apache-2.0 */
/* Software in the loop: the same program as a process, its line on standard input and output. */
#define _POSIX_C_SOURCE 200809L
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "mehvar/board.h"

enum { BUFFER = 4096, WAIT_MS = 10 };

const char mv_board_name[] = "posix";

static uint8_t in[BUFFER], out[BUFFER];
static size_t in_size, in_at, out_size;

static void flush(void)
{
    for (size_t sent = 0; sent < out_size;) {
        const ssize_t n = write(STDOUT_FILENO, out + sent, out_size - sent);
        if (n <= 0) exit(EXIT_FAILURE);
        sent += (size_t)n;
    }
    out_size = 0;
}

void mv_board_init(void) {}

int mv_board_read(void)
{
    return in_at < in_size ? in[in_at++] : -1;
}

void mv_board_write(const uint8_t *bytes, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        if (out_size == BUFFER) flush();
        out[out_size++] = bytes[i];
    }
}

void mv_board_wait(void)
{
    struct pollfd line = {.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
    flush();
    if (poll(&line, 1, WAIT_MS) <= 0) return;
    const ssize_t n = read(STDIN_FILENO, in, BUFFER);
    if (n <= 0) exit(EXIT_SUCCESS);
    in_size = (size_t)n;
    in_at = 0;
}

static uint64_t nanoseconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

uint32_t mv_board_ms(void) { return (uint32_t)(nanoseconds() / 1000000u); }
uint32_t mv_board_ticks(void) { return (uint32_t)nanoseconds(); }
uint32_t mv_board_ticks_per_second(void) { return 1000000000u; }
void mv_board_output(const mv_real *u) { (void)u; }

void mv_board_stack(uint32_t *used, uint32_t *size)
{
    *used = 0;
    *size = 0;
}

void mv_board_reset(void)
{
    flush();
    execl("/proc/self/exe", "firmware", (char *)0);
    exit(EXIT_FAILURE);
}
