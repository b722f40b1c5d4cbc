/* SPDX-License-Identifier: Apache-2.0 */
/* A block of runs, one per lane, and its job.
 *
 * Included after kernel.h, which Python writes for a model, law and method: code and sizes of the model, constants of a
 * run, calls, and sums of the method over its nonzero coefficients. */
#ifndef MEHVAR_BLOCK_H
#define MEHVAR_BLOCK_H

#include "job.h"
#include "noise.h"

#define REALS(a, n) real a[(n) + 1]
#define ROWS(a, m, n) real a[(m) + !(m)][n]

typedef struct {
    real p[NP + 1], c[NC + 1], s[NS + 1];
    CONSTANTS
} mv_model;

#include "loop.h"

static inline void mv_prepare(mv_model *m, const real *r) { CALL_PREPARE; }
static inline void mv_call_start(const mv_model *m, const real *x, const real *r, real *z) { CALL_START; }
static inline void mv_call_to_coordinates(const mv_model *m, const real *x, real *q) { CALL_TO_COORDINATES; }
static inline void mv_call_from_coordinates(const mv_model *m, const real *q, real *x) { CALL_FROM_COORDINATES; }

#define STAGE(j, c, sum)                                                                                             \
    for (int i = 0; i < NQ; i++) l->stage[i] = l->q[i] + h * (sum);                                                  \
    mv_slope(l, l->t + K(c) * h, l->stage, l->k[j]);

static inline void mv_stages(mv_loop *l, real h)
{
    real (*const k)[NQ] = l->k;
    STAGE_SUMS
    for (int i = 0; i < NQ; i++) l->y[i] = l->q[i] + h * (END_SUM);
}

static inline void mv_estimate(const mv_loop *l, real *error, real *third_error)
{
    const real (*const k)[NQ] = l->k;
    for (int i = 0; i < NQ; i++) error[i] = ERROR_SUM;
    for (int i = 0; THIRD && i < NQ; i++) third_error[i] = THIRD_ERROR_SUM;
}

static inline void mv_dense_slopes(mv_loop *l, real h)
{
    real (*const k)[NQ] = l->k;
    DENSE_STAGES
}

#define TERM(j, sum)                                                                                                 \
    for (int i = 0; i < NQ; i++) sums[j][i] = sum;

static inline void mv_dense_sums(const mv_loop *l, real (*sums)[NQ])
{
    const real (*const k)[NQ] = l->k;
    DENSE_SUMS
}

/* state of a metric for one signal */
typedef struct {
    real value, previous;
    real *history;   /* of MV_SETTLING_ABOUT_END: every counted sample */
    int whole;       /* 1 if every record counts */
    int of_extremes; /* 1 if the extremes of its column in all records tell it */
} mv_tally;

typedef struct {
    mv_loop loop;
    const mv_job *job;
    int64_t first;
    uint64_t run[MEHVAR_LANES];
    real minimum[COLUMNS], maximum[COLUMNS];
    mv_tally *tally;
    real recorded;             /* number of a lane's records */
    real *counts;              /* of the records in the window of each metric that is a part of the run */
    double *times;             /* instants of the records */
    int64_t records;
    real t_record;             /* instant of a lane's last record */
    real happened[EVENTS + 1]; /* number of occurrences of each event */
} mv_block;

#endif
