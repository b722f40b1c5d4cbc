/* SPDX-License-Identifier: Apache-2.0 */
/* Common definitions of the laws of all packages. Each law has its own header with state, parameters and functions. */
#ifndef MEHVAR_LAW_H
#define MEHVAR_LAW_H

#include <stdint.h>

#include "mehvar/real.h"

/* verdict on a block of parameters; a positive one is 1 + the index of the first parameter out of range */
enum {
    MV_LAW_ACCEPTED = 0,
    MV_LAW_OTHER_LAYOUT = -1, /* block of another law or version */
    MV_LAW_DAMAGED = -2       /* wrong checksum, empty range, or unknown reaction */
};

/* reaction to a measurement or reference out of its range */
enum {
    MV_LAW_REPORT = 0,   /* use it */
    MV_LAW_SATURATE = 1, /* use the nearest value in the range */
    MV_LAW_HOLD = 2      /* use the last value in the range, also for infinities and NaN */
};

/* flags of a step; none: all went well */
enum {
    MV_LAW_RANGE = 1,      /* an input was out of its range */
    MV_LAW_NOT_FINITE = 2, /* an input or a result was infinite or NaN */
    MV_LAW_SAFE = 4        /* the command is zero: no parameters, no usable input, or no finite result */
};

/* a parameter that the law reads; both bounds are allowed */
typedef struct {
    const char *name, *unit;
    mv_real value, least, most;
} mv_law_parameter;

#endif
