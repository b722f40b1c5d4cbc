/* SPDX-License-Identifier: Apache-2.0 */
/* Server that answers the host's frames and monitors their arrival: version 2 of the protocol, docs/reference/board-link.md. */
#ifndef MEHVAR_SERVER_H
#define MEHVAR_SERVER_H

#include <stdint.h>

enum {
    MV_SERVER_HELLO = 1,
    MV_SERVER_RESET = 2,
    MV_SERVER_STEP = 3,
    MV_SERVER_GET = 4,
    MV_SERVER_SET = 5,
    MV_SERVER_STATS = 6,
    MV_SERVER_SELFTEST = 7,
    MV_SERVER_REBOOT = 8,
    MV_SERVER_NAK = 0x7f,
    MV_SERVER_REPLY = 0x80 /* added to the type of a request */
};

/* payload of a NAK; after OUT_OF_TURN, the number of the last request, u32 */
enum {
    MV_SERVER_UNKNOWN_TYPE = 1,
    MV_SERVER_WRONG_SIZE = 2,
    MV_SERVER_NO_MEMORY = 3,
    MV_SERVER_NO_SESSION = 4,  /* the board has started since, or serves another host */
    MV_SERVER_OUT_OF_TURN = 5, /* neither the next request nor a repeated last one */
    MV_SERVER_NOT_FINITE = 6,
    MV_SERVER_BUSY = 7,        /* another host's law is running */
    MV_SERVER_CONSTANT = 8     /* the parameter is a constant of the law's code */
};

/* flags of a reply */
enum {
    MV_SERVER_LOST = 1,      /* no step for two samples: the inputs were set to zero */
    MV_SERVER_DUPLICATE = 2, /* repeated answer without evaluation */
    MV_SERVER_ABORTED = 4,   /* a byte on the line ended the self-test */
    MV_SERVER_NONFINITE = 8, /* a number was not finite: the inputs are zero */
    MV_SERVER_FRESH = 16     /* no memory, as after a start: a step was not evaluated, the inputs are zero */
};

#ifdef __cplusplus
extern "C" {
#endif

void mv_server_init(void);
void mv_server_byte(uint8_t byte);
void mv_server_watch(uint32_t ms);

#ifdef __cplusplus
}
#endif

#endif
