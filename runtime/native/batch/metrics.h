/* SPDX-License-Identifier: Apache-2.0 */
/* Metrics of a run, computed during the run, equal to those of runtime/run/metrics.py from a whole series. */
#ifndef MEHVAR_METRICS_H
#define MEHVAR_METRICS_H

#include "block.h"

static inline real mv_crossing(real before, real now, real t_before, real t, double band)
{
    const real part = (before - mv_copysign(SPLAT(band), before)) / (before - now);
    return SELECT(EQ(part - part, K(0)), t_before + part * (t - t_before), t);
}

/* Return the time at which the line from the last sample outside the band to the next one enters it; infinite without one. */
static inline real mv_settled(real settled, mask first, real before, real now, real t_before, real t, double band)
{
    const mask outside = NOT(LE(mv_fabs(now), K(band))), enters = AND(EQ(settled, MV_INFINITY), NOT(outside));
    if (mv_any(enters)) settled = SELECT(enters, mv_crossing(before, now, t_before, t, band), settled);
    return SELECT(outside, SPLAT(MV_INFINITY), SELECT(first, t, settled));
}

static inline mask mv_beyond(real v, real bound) { return OR(LT(bound, v), NE(v, v)); }

static inline void mv_tell(mv_tally *a, const mv_metric *m, mask lanes, mask first, real v, real t_before, real t,
                           int64_t place)
{
    real value = a->value;
    switch (m->kind) {
    case MV_SETTLING: value = mv_settled(value, first, a->previous, v, t_before, t, m->band); break;
    case MV_MAX: value = SELECT(OR(first, mv_beyond(v, value)), v, value); break;
    case MV_MIN: value = SELECT(OR(first, mv_beyond(-v, -value)), v, value); break;
    case MV_MAX_ABS: value = SELECT(mv_beyond(mv_fabs(v), value), mv_fabs(v), value); break;
    case MV_RMS: value += v * v; break;
    case MV_TRAVEL: value += SELECT(first, SPLAT(0), mv_fabs(v - a->previous)); break;
    case MV_FINAL: value = v; break;
    case MV_SETTLING_ABOUT_END: a->history[place] = SELECT(lanes, v, a->history[place]); break;
    case MV_SIGN_CHANGES: {
        const mask counts = LT(K(m->band), mv_fabs(v));
        value += NUM(AND(counts, LT(v * a->previous, K(0))));
        v = SELECT(counts, mv_sign(v), SELECT(first, SPLAT(0), a->previous));
        break;
    }
    }
    a->value = SELECT(lanes, value, a->value);
    a->previous = SELECT(lanes, v, a->previous);
}

/* Return 1 if the window of a metric contains the whole run. */
static inline int mv_whole(const mv_job *job, const mv_metric *m)
{
    return m->since <= job->schedule.t[0] && job->schedule.t[job->schedule.ticks - 1] <= m->until;
}

/* Return 1 if the extremes of columns in all records give a metric. */
static inline int mv_of_extremes(const mv_job *job, const mv_metric *m, const mv_signal *signal)
{
    if (m->kind != MV_MAX && m->kind != MV_MIN && m->kind != MV_MAX_ABS) return 0;
    for (int i = 0; i < m->signals; i++)
        if (signal[i].subtracted >= 0) return 0;
    return mv_whole(job, m);
}

static double mv_extreme(const mv_block *b, const mv_metric *m, int column, int lane)
{
    const double low = AT(b->minimum[column], lane), high = AT(b->maximum[column], lane);
    if (m->kind != MV_MAX_ABS) return m->kind == MV_MIN ? low : high;
    return __builtin_fabs(low) > __builtin_fabs(high) ? __builtin_fabs(low) : __builtin_fabs(high);
}

/* Count a record of the instant `now` in each metric whose window contains it. */
static void mv_count(mv_block *b, mask lanes, real now)
{
    const mv_signal *signal = b->job->signal;
    mv_tally *tally = b->tally;
    const mask start = EQ(b->recorded, K(0));
    b->recorded += SELECT0(lanes, SPLAT(1));
    for (int m = 0; m < b->job->metrics; m++) {
        const mv_metric *metric = b->job->metric + m;
        if (metric->kind != MV_EVENTS && !tally->of_extremes) {
            mask counted = lanes, first = start;
            if (!tally->whole) {
                counted = AND(lanes, AND(LE(K(metric->since), now), LE(now, K(metric->until))));
                first = EQ(b->counts[m], K(0));
                b->counts[m] += SELECT0(counted, SPLAT(1));
            }
            for (int i = 0; i < metric->signals; i++) {
                const real v = b->loop.column[signal[i].column];
                const real signalled = signal[i].subtracted < 0 ? v : v - b->loop.column[signal[i].subtracted];
                mv_tell(tally + i, metric, counted, first, signalled, b->t_record, now, b->records);
            }
        }
        signal += metric->signals;
        tally += metric->signals;
    }
}

/* Return a mask of lanes that ended before the end of a metric's window. */
static inline int mv_cut(const mv_block *b, const mv_metric *m, int lane)
{
    return AT(b->loop.status, lane) != MV_DONE && AT(b->loop.t, lane) < m->until;
}

/* Settling time of one lane about its last value, for a completed window. */
static double mv_settled_about_end(const mv_block *b, const mv_metric *m, const real *history, int lane, int64_t count)
{
    const double band = m->band;
    int64_t last = b->records - 1;
    while (last > 0 && b->times[last] > m->until) last--;
    const int64_t first = last - count + 1;
    const double end = AT(history[last], lane);
    int64_t i = last;
    while (i >= first && __builtin_fabs(AT(history[i], lane) - end) <= band) i--;
    if (i < first) return b->times[first];
    if (i == last) return __builtin_inf();
    const double before = AT(history[i], lane) - end, after = AT(history[i + 1], lane) - end;
    const double part = (before - __builtin_copysign(band, before)) / (before - after);
    return part - part == 0.0 ? b->times[i] + part * (b->times[i + 1] - b->times[i]) : b->times[i + 1];
}

static double mv_metric_value(const mv_block *b, const mv_metric *m, const mv_signal *signal, const mv_tally *tally,
                              int lane, int64_t count)
{
    double value = AT(tally->value, lane);
    for (int i = 0; i < m->signals; i++) {
        double v = tally->of_extremes ? mv_extreme(b, m, signal[i].column, lane) : AT(tally[i].value, lane);
        if (m->kind == MV_SETTLING_ABOUT_END) v = mv_settled_about_end(b, m, tally[i].history, lane, count);
        if (m->kind == MV_RMS || m->kind == MV_TRAVEL || m->kind == MV_SIGN_CHANGES)
            value = i ? value + v : v;
        else if (m->kind == MV_MIN)
            value = i && !(v < value || v != v) ? value : v;
        else if (m->kind != MV_FINAL)
            value = i && !(v > value || v != v) ? value : v;
    }
    return m->kind == MV_RMS ? __builtin_sqrt(value / (double)(count * m->signals)) : value;
}

/* Number of occurrences of some events in one lane. */
static double mv_events(const mv_block *b, const mv_signal *signal, int signals, int lane)
{
    double count = 0.0;
    for (int i = 0; i < signals; i++) count += AT(b->happened[signal[i].column], lane);
    return count;
}

/* Return 1 if a metric is undetermined after an early end: settling, or a value at a later instant. */
static inline int mv_open(const mv_block *b, const mv_metric *m, int lane)
{
    const int settling = m->kind == MV_SETTLING || m->kind == MV_SETTLING_ABOUT_END;
    return mv_cut(b, m, lane) && (settling || (m->kind == MV_FINAL && m->until < MV_INFINITY));
}

/* Compute the metrics of one lane; NaN if nothing was counted or the lane ended before the window. */
static void mv_metrics(const mv_block *b, int lane, double *out)
{
    const mv_tally *tally = b->tally;
    const mv_signal *signal = b->job->signal;
    for (int m = 0; m < b->job->metrics; m++) {
        const mv_metric *metric = b->job->metric + m;
        const int64_t count = (int64_t)AT(tally->whole ? b->recorded : b->counts[m], lane);
        const int open = !count || mv_open(b, metric, lane);
        out[m] = open ? __builtin_nan("") : mv_metric_value(b, metric, signal, tally, lane, count);
        if (metric->kind == MV_EVENTS) out[m] = mv_events(b, signal, metric->signals, lane);
        signal += metric->signals;
        tally += metric->signals;
    }
}

#endif
