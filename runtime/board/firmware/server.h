/* SPDX-License-Identifier: Apache-2.0 */
/* Answers the host's frames and watches that they keep coming. */
#ifndef SERVER_H
#define SERVER_H

#include <stdint.h>

enum {
    SERVER_HELLO = 1,
    SERVER_RESET = 2,
    SERVER_STEP = 3,
    SERVER_GET = 4,
    SERVER_SET = 5,
    SERVER_STATS = 6,
    SERVER_SELFTEST = 7,
    SERVER_REBOOT = 8,
    SERVER_NAK = 0x7f,
    SERVER_REPLY = 0x80 /* added to the type of a request */
};

enum { SERVER_UNKNOWN_TYPE = 1, SERVER_WRONG_SIZE = 2, SERVER_NO_MEMORY = 3 }; /* payload of a NAK */

/* flags of a reply; all but the last belong to a step */
enum {
    SERVER_LOST = 1,      /* the link was silent for two samples: the inputs were set to zero */
    SERVER_DUPLICATE = 2, /* the answer of before; nothing was evaluated */
    SERVER_GAP = 4,       /* a sequence number was left out */
    SERVER_NONFINITE = 8, /* a number was not finite: the inputs are zero */
    SERVER_FRESH = 16     /* no memory, as after a start of the program: a step was not evaluated, the inputs are zero */
};

void server_init(void);
void server_byte(uint8_t byte);
void server_watch(uint32_t ms);

#endif
