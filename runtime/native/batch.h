/* SPDX-License-Identifier: Apache-2.0 */
/* A block of runs, one in each lane, and the job that it is part of.
 *
 * Included after the text that Python writes for a model under a law: the model's functions, sizes such as NQ, the
 * constants of a run, and mv_call_NAME for every function that the loop calls. */
#ifndef MEHVAR_BATCH_H
#define MEHVAR_BATCH_H

#include <stdint.h>

#include "mehvar/private/arithmetic.h"
#include "noise.h"

enum mv_status { MV_DONE, MV_NOT_FINITE, MV_STEP_UNDERFLOW, MV_TOO_MANY_STEPS, MV_LIMIT };
enum mv_kind {
    MV_SETTLING, MV_SETTLING_ABOUT_END, MV_LARGEST, MV_SMALLEST, MV_LARGEST_MAGNITUDE, MV_RMS, MV_TRAVEL,
    MV_SIGN_CHANGES, MV_FINAL
};

/* a metric is made of signals: columns of the record, or differences of two */
typedef struct {
    int32_t kind, signals;
    double band, since, until;
} mv_metric;

typedef struct {
    int32_t column, subtracted; /* -1: nothing is subtracted */
} mv_signal;

/* Arrays have one row per run. */
typedef struct {
    int64_t runs;
    uint64_t seed, first_run;
    int64_t ticks, hold_every, record_every, max_steps;
    int64_t save_every, rows; /* ticks from one row of the series to the next; no rows for no series */
    int32_t delay, metrics;
    double rtol, atol, step;
    const double *t;
    const double *p, *c, *s, *x0;
    const mv_metric *metric;
    const mv_signal *signal;
    double *final, *minimum, *maximum, *metric_values, *t_stop, *error, *series;
    int64_t *steps;
    int32_t *violated;
    uint8_t *status;
    const volatile int32_t *stop;
} mv_job;

/* what a metric remembers of one signal */
typedef struct {
    real value, previous;
    real *history; /* of MV_SETTLING_ABOUT_END: every counted sample */
} mv_tally;

typedef struct {
    const mv_job *job;
    mv_constants fixed;
    int64_t first;
    uint64_t run[MEHVAR_LANES];
    mask alive;
    int ready, started; /* k[0] is the slope at (t, q); h has been chosen */
    real t, h, reserve, status, violated, error, steps;
    real q[NQ], k[STAGES + 1][NQ], y[NQ], stage[NQ];
    real r[NR + 1], z_next[NZ + 1];
    real u_cmd[NU];
    real column[COLUMNS];
    real minimum[COLUMNS], maximum[COLUMNS];
    real *queue;               /* the inputs computed last, a ring */
    mv_tally *tally;
    real *counts;              /* counted samples of each metric */
    double *times;             /* instants of the records */
    int64_t records;
    real t_record;             /* instant of a lane's last record */
} mv_block;

#if MEHVAR_LANES == 1
#define AT(v, lane) (v)
#else
#define AT(v, lane) ((v)[lane])
#endif

static inline int mv_any(mask m)
{
    int found = 0;
    for (int lane = 0; lane < MEHVAR_LANES; lane++) found |= AT(m, lane) != 0;
    return found;
}

static inline mask mv_none(void) { return LT(SPLAT(0), SPLAT(0)); }

static inline mask mv_finite(const real *v, int n)
{
    real zero = SPLAT(0);
    for (int i = 0; i < n; i++) zero += v[i] - v[i];
    return EQ(zero, SPLAT(0));
}

static inline void mv_blend(mask m, real *to, const real *from, int n)
{
    for (int i = 0; i < n; i++) to[i] = SELECT(m, from[i], to[i]);
}

static inline void mv_retire(mv_block *b, mask m, enum mv_status status)
{
    b->status = SELECT(m, SPLAT(status), b->status);
    b->alive = AND(b->alive, NOT(m));
}

#endif
