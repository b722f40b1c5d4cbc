/* SPDX-License-Identifier: Apache-2.0 */
/* Definitions that the laws of all packages share; each has a header of its own with its state, its parameters and its functions. */
#ifndef MEHVAR_LAW_H
#define MEHVAR_LAW_H

#include <stdint.h>

#include "mehvar/real.h"

/* verdict on a block of parameters; a positive one is 1 + the place in the table of the first that is out of range */
enum {
    MV_LAW_ACCEPTED = 0,
    MV_LAW_OTHER_LAYOUT = -1, /* written for another law, or another version of it */
    MV_LAW_DAMAGED = -2       /* the checksum is wrong, a range is empty, or the reaction is none of those below */
};

/* reaction to a measurement or reference that is out of its range */
enum {
    MV_LAW_REPORT = 0,   /* take it as it is */
    MV_LAW_SATURATE = 1, /* take the nearest value in the range */
    MV_LAW_HOLD = 2      /* take the last value that was in the range; also in place of infinities and NaN */
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
