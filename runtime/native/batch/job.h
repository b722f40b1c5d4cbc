/* SPDX-License-Identifier: Apache-2.0 */
/* Runs of a batch and addresses of their results. Arrays have one row per run. */
#ifndef MEHVAR_JOB_H
#define MEHVAR_JOB_H

#include "schedule.h"

enum mv_kind {
    MV_SETTLING, MV_SETTLING_ABOUT_END, MV_MAX, MV_MIN, MV_MAX_ABS, MV_RMS, MV_TRAVEL, MV_SIGN_CHANGES, MV_FINAL,
    MV_EVENTS
};

/* a metric has signals: columns of the record, or differences of two columns */
typedef struct {
    int32_t kind, signals;
    double band, since, until;
} mv_metric;

typedef struct {
    int32_t column, subtracted; /* -1: nothing is subtracted; of MV_EVENTS the column is an event */
} mv_signal;

typedef struct {
    mv_schedule schedule;
    int64_t runs;
    uint64_t seed;
    int64_t save_every, rows; /* ticks from one row of the series to the next; no rows for no series */
    int64_t metrics;
    const double *p, *c, *s, *x0;
    const uint64_t *number;   /* of each run, which its noise depends on */
    const mv_metric *metric;
    const mv_signal *signal;
    double *final, *minimum, *maximum, *metric_values, *t_stop, *t_stiff, *error, *series;
    int64_t *steps, *events; /* number of occurrences of each event */
    int32_t *violated;
    uint8_t *status;
    const volatile int32_t *stop;
} mv_job;

#endif
