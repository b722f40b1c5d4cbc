/* SPDX-License-Identifier: Apache-2.0 */
/* Answers the host's frames and watches that they keep coming. */
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

enum { MV_SERVER_UNKNOWN_TYPE = 1, MV_SERVER_WRONG_SIZE = 2, MV_SERVER_NO_MEMORY = 3 }; /* payload of a NAK */

/* flags of a reply; all but the last belong to a step */
enum {
    MV_SERVER_LOST = 1,      /* the link was silent for two samples: the inputs were set to zero */
    MV_SERVER_DUPLICATE = 2, /* the answer of before; nothing was evaluated */
    MV_SERVER_GAP = 4,       /* a sequence number was left out */
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
