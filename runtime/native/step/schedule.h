/* SPDX-License-Identifier: Apache-2.0 */
/* Data common to all lanes of a loop, and the ways in which a lane ends. */
#ifndef MEHVAR_SCHEDULE_H
#define MEHVAR_SCHEDULE_H

#include <stdint.h>

enum mv_status {
    MV_DONE,
    MV_NOT_FINITE,
    MV_STEP_UNDERFLOW,
    MV_TOO_MANY_STEPS,
    MV_LIMIT,
    MV_EVENT = 6, /* in stores 5 is a run that never began */
    MV_CHATTERING,
    MV_FAILURE, /* an event that is declared as failure, or that was already past at the start */
};

/* Effect of an event on the run: none, or a kind of end. */
enum mv_ends { MV_GOES_ON, MV_ENDS, MV_FAILS, MV_SUCCEEDS };

typedef struct {
    const double *t;          /* the ticks: integration stops at each of them exactly */
    int64_t ticks;
    int64_t record_every;     /* ticks from one recorded sample to the next */
    int64_t hold_every;       /* ticks for which a sampled law's input is held */
    int64_t max_steps;        /* trial steps from one tick to the next */
    int32_t delay;            /* a sampled law's input acts `delay` evaluations after its own */
    double rtol, atol;
    double step;              /* largest step of rk4; unused by the adaptive methods */
    int32_t longest;          /* the greatest of the plant's own delays, in all runs */
} mv_schedule;

/* Number of evaluations whose inputs are stored: a ring for `delay`, and one for the delays of the plant. */
static inline int64_t mv_queued(const mv_schedule *s) { return s->delay + (s->longest ? s->longest + 1 : 0); }

#endif
