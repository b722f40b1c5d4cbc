/* SPDX-License-Identifier: Apache-2.0 */
/* What is the same in all lanes of a loop, and how a lane ends. */
#ifndef MEHVAR_SCHEDULE_H
#define MEHVAR_SCHEDULE_H

#include <stdint.h>

enum mv_status { MV_DONE, MV_NOT_FINITE, MV_STEP_UNDERFLOW, MV_TOO_MANY_STEPS, MV_LIMIT, MV_EVENT, MV_CHATTERING };

typedef struct {
    const double *t;          /* the ticks: integration stops at each of them exactly */
    int64_t ticks;
    int64_t record_every;     /* ticks from one recorded sample to the next */
    int64_t hold_every;       /* ticks for which a sampled law's input is held */
    int64_t max_steps;        /* trial steps from one tick to the next */
    int32_t delay;            /* a sampled law's input acts `delay` evaluations after its own */
    double rtol, atol;
    double step;              /* largest step of rk4; unused by the adaptive methods */
} mv_schedule;

#endif
