/* SPDX-License-Identifier: Apache-2.0 */
/* Closed loops sample by sample, a run in each lane: what loop.c does with one. Compiled after the text that Python
 * writes for a model under a law. Nothing is allocated, nothing is shared but the job. */
#include "calls.h"

#include "batch.h"
#include "batch_metrics.h"
#include "batch_step.h"

int64_t mv_job_size(void) { return (int64_t)sizeof(mv_job); }

/* Bytes of work that one thread needs; what the signals of metrics remember counts in the caller's `histories`. */
int64_t mv_work_size(const mv_job *job, int64_t signals, int64_t histories, int64_t records)
{
    const int64_t reals = (int64_t)job->delay * NU + job->metrics + histories * (records + 1);
    return reals * (int64_t)sizeof(real) + signals * (int64_t)sizeof(mv_tally) + (records + 1) * (int64_t)sizeof(double);
}

static void gather(const mv_block *b, const double *rows, int width, real *to)
{
    for (int lane = 0; lane < MEHVAR_LANES; lane++) {
        const int64_t run = b->first + lane < b->job->runs ? b->first + lane : b->job->runs - 1;
        for (int i = 0; i < width; i++) AT(to[i], lane) = rows[run * width + i];
    }
}

static void scatter(const mv_block *b, const real *from, int width, double *rows)
{
    for (int lane = 0; lane < MEHVAR_LANES && b->first + lane < b->job->runs; lane++)
        for (int i = 0; i < width; i++) rows[(b->first + lane) * width + i] = AT(from[i], lane);
}

static void divide_work(mv_block *b, char *work, int64_t records)
{
    const mv_job *job = b->job;
    const mv_signal *signal = job->signal;
    int64_t signals = 0;
    for (int m = 0; m < job->metrics; m++) signals += job->metric[m].signals;
    b->queue = (real *)work;
    b->counts = b->queue + (int64_t)job->delay * NU;
    b->tally = (mv_tally *)(b->counts + job->metrics);
    real *history = (real *)(b->tally + signals);
    mv_tally *tally = b->tally;
    for (int m = 0; m < job->metrics; m++) {
        b->counts[m] = SPLAT(0);
        for (int i = 0; i < job->metric[m].signals; i++, tally++, signal++) {
            *tally = (mv_tally){SPLAT(0), SPLAT(0), history};
            if (job->metric[m].kind == MV_SETTLING_ABOUT_END) history += records + 1;
        }
    }
    b->times = (double *)history;
    for (int64_t i = 0; i < (int64_t)job->delay * NU; i++) b->queue[i] = SPLAT(0);
}

static void start(mv_block *b, const mv_job *job, int64_t first)
{
    real valid = SPLAT(0);
    b->job = job;
    b->first = first;
    for (int lane = 0; lane < MEHVAR_LANES; lane++) {
        b->run[lane] = job->first_run + (uint64_t)(first + lane);
        AT(valid, lane) = first + lane < job->runs;
    }
    b->alive = TRUTH(valid);
    b->ready = b->started = 0;
    b->t = SPLAT(job->t[0]);
    b->h = b->status = b->error = b->steps = b->t_record = SPLAT(0);
    b->reserve = SPLAT(1);
    b->violated = SPLAT(-1);
    b->records = 0;
    for (int i = 0; i < COLUMNS; i++) {
        b->column[i] = SPLAT(0);
        b->minimum[i] = SPLAT(MV_INFINITY);
        b->maximum[i] = SPLAT(-MV_INFINITY);
    }
    for (int i = 0; i < NU; i++) b->u_cmd[i] = SPLAT(0);
    gather(b, job->p, NP, b->fixed.p);
    gather(b, job->c, NC, b->fixed.c);
    gather(b, job->s, NS, b->fixed.s);
    mv_call_reference(&b->fixed, b->t, b->r);
    mv_prepare(&b->fixed, b->r);
    real x0[NX];
    gather(b, job->x0, NX, x0);
    mv_call_start(&b->fixed, x0, b->r, b->column + Z_COLUMN);
    mv_call_to_coordinates(&b->fixed, x0, b->q);
}

/* The law's input enters the queue; the one computed `delay` evaluations ago leaves it and goes to the actuator. */
static void apply(mv_block *b, int64_t evaluation)
{
    const real *x = b->column;
    real *u = b->column + U_COLUMN, wanted[NU];
    for (int i = 0; i < NU; i++) wanted[i] = b->u_cmd[i];
    if (b->job->delay) {
        real *place = b->queue + evaluation % b->job->delay * NU;
        for (int i = 0; i < NU; i++) wanted[i] = place[i];
        for (int i = 0; i < NU; i++) place[i] = b->u_cmd[i];
    }
    mv_call_actuate(&b->fixed, x, wanted, u);
}

static void evaluate_law(mv_block *b, int64_t evaluation)
{
    real seen[NX], noise[NOISE + 1];
    mv_noise(b->job->seed, b->run, (uint64_t)evaluation, NOISE, noise);
    mv_call_measure(&b->fixed, b->column, noise, seen);
    mv_call_law(&b->fixed, seen, b->r, b->column + U_COLUMN, b->column + Z_COLUMN, b->u_cmd, b->z_next);
    apply(b, evaluation);
}

static void sample(mv_block *b, int64_t tick)
{
    mv_refer(b, SPLAT(b->job->t[tick]));
#if SAMPLED
    for (int i = 0; i < NX; i++) b->column[i] = b->q[i];
    if (tick % b->job->hold_every == 0) evaluate_law(b, tick / b->job->hold_every);
#else
    (void)evaluate_law;
    mv_call_observe(&b->fixed, b->q, b->r, b->column, b->column + U_COLUMN, b->u_cmd);
#endif
}

/* Which lanes keep the limits; a continuous loop is looked at after every step. */
static mask allowed(mv_block *b)
{
    mask within = NOT(mv_none());
#if LIMITS && SAMPLED
    real margin[LIMITS];
    mv_call_limits(&b->fixed, b->column, b->u_cmd, margin);
    for (int i = 0; i < LIMITS; i++) {
        const mask broken = AND(AND(b->alive, within), NOT(LT(K(0), margin[i])));
        b->violated = SELECT(broken, SPLAT(i), b->violated);
        within = AND(within, NOT(broken));
    }
#endif
    (void)b;
    return within;
}

static void save(const mv_block *b, int64_t row)
{
    for (int lane = 0; lane < MEHVAR_LANES && b->first + lane < b->job->runs; lane++) {
        if (!AT(b->alive, lane)) continue;
        double *to = b->job->series + ((b->first + lane) * b->job->rows + row) * COLUMNS;
        for (int i = 0; i < COLUMNS; i++) to[i] = AT(b->column[i], lane);
    }
}

static void record(mv_block *b, mask lanes, int64_t tick, int due)
{
    const double t = b->job->t[tick];
    mv_call_outputs(&b->fixed, b->column, b->column + U_COLUMN, b->r, b->column + Y_COLUMN);
#if RECORDS_COMMAND
    for (int i = 0; i < NU; i++) b->column[U_CMD_COLUMN + i] = b->u_cmd[i];
#endif
    for (int i = 0; i < COLUMNS; i++) {
        const real v = b->column[i];
        b->minimum[i] = SELECT(AND(lanes, mv_beyond(-v, -b->minimum[i])), v, b->minimum[i]);
        b->maximum[i] = SELECT(AND(lanes, mv_beyond(v, b->maximum[i])), v, b->maximum[i]);
    }
    mv_count(b, lanes, t);
    b->t_record = SELECT(lanes, SPLAT(t), b->t_record);
    if (due) b->times[b->records++] = t;
    if (b->job->rows && tick % b->job->save_every == 0 && tick / b->job->save_every < b->job->rows)
        save(b, tick / b->job->save_every);
}

static void finish(mv_block *b)
{
    const mv_job *job = b->job;
    real x[NX];
    mv_call_from_coordinates(&b->fixed, b->q, x);
    scatter(b, x, NX, job->final);
    scatter(b, b->minimum, COLUMNS, job->minimum);
    scatter(b, b->maximum, COLUMNS, job->maximum);
    scatter(b, &b->t, 1, job->t_stop);
    scatter(b, &b->error, 1, job->error);
    for (int lane = 0; lane < MEHVAR_LANES && b->first + lane < job->runs; lane++) {
        const int64_t run = b->first + lane;
        job->status[run] = (uint8_t)AT(b->status, lane);
        job->violated[run] = (int32_t)AT(b->violated, lane);
        job->steps[run] = (int64_t)AT(b->steps, lane);
        mv_metrics(b, lane, job->metric_values + run * job->metrics);
    }
}

/* Returns whether it was told to stop. */
static int integrate(mv_block *b)
{
    const mv_job *job = b->job;
    for (int64_t tick = 0; mv_any(b->alive); tick++) {
        if (*job->stop) return 1;
        sample(b, tick);
        const mask finite = AND(mv_finite(b->column, NX), AND(mv_finite(b->u_cmd, NU), mv_finite(b->column + U_COLUMN, NU)));
        const mask good = AND(finite, allowed(b)), failed = AND(b->alive, NOT(good));
        const int end = tick + 1 == job->ticks, due = end || tick % job->record_every == 0;
        if (due || mv_any(failed)) record(b, due ? b->alive : failed, tick, due);
        b->violated = SELECT(AND(b->alive, NOT(finite)), SPLAT(-1), b->violated);
        mv_retire(b, AND(b->alive, NOT(finite)), MV_NOT_FINITE);
        mv_retire(b, AND(b->alive, NOT(good)), MV_LIMIT);
        if (end) break;
#if SAMPLED
        if (tick % job->hold_every == 0) mv_blend(b->alive, b->column + Z_COLUMN, b->z_next, NZ);
#endif
        mv_advance(b, job->t[tick + 1]);
    }
    return 0;
}

/* Run the blocks first ... last - 1; `work` is mv_work_size bytes aligned to a real. Returns whether it was stopped. */
int mv_run_blocks(const mv_job *job, int64_t first, int64_t last, int64_t records, char *work)
{
    mv_block b;
    for (int64_t block = first; block < last; block++) {
        start(&b, job, block * MEHVAR_LANES);
        divide_work(&b, work, records);
        if (integrate(&b)) return 1;
        finish(&b);
    }
    return 0;
}
