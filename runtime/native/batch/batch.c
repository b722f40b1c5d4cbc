/* SPDX-License-Identifier: Apache-2.0 */
/* Many closed loops, one block of lanes after the other. Nothing is allocated, and only the job is shared. */
#include "kernel.h"

#include "block.h"
#include "metrics.h"

int64_t mv_job_size(void) { return (int64_t)sizeof(mv_job); }

/* largest number of records of a run, and one more at an early end */
static int64_t most_records(const mv_schedule *s) { return (s->ticks - 2) / s->record_every + 3; }

/* Return the bytes of work memory of one thread. */
int64_t mv_work_size(const mv_job *job)
{
    const int64_t records = most_records(&job->schedule);
    int64_t reals = mv_queued(&job->schedule) * NU + KEPT * KEPT_SIZE + job->metrics, signals = 0;
    for (int m = 0; m < job->metrics; m++) {
        signals += job->metric[m].signals;
        if (job->metric[m].kind == MV_SETTLING_ABOUT_END) reals += job->metric[m].signals * records;
    }
    return reals * (int64_t)sizeof(real) + signals * (int64_t)sizeof(mv_tally) + records * (int64_t)sizeof(double);
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

static void divide_work(mv_block *b, char *work)
{
    const mv_job *job = b->job;
    int64_t signals = 0;
    for (int m = 0; m < job->metrics; m++) signals += job->metric[m].signals;
    b->loop.queue = (real *)work;
    real *const kept = b->loop.queue + mv_queued(&job->schedule) * NU;
    b->loop.kept = (scalar *)kept;
    b->counts = kept + KEPT * KEPT_SIZE;
    b->tally = (mv_tally *)(b->counts + job->metrics);
    real *history = (real *)(b->tally + signals);
    mv_tally *tally = b->tally;
    const mv_signal *signal = job->signal;
    for (int m = 0; m < job->metrics; m++) {
        const int whole = mv_whole(job, job->metric + m), of_extremes = mv_of_extremes(job, job->metric + m, signal);
        b->counts[m] = SPLAT(0);
        for (int i = 0; i < job->metric[m].signals; i++) {
            *tally++ = (mv_tally){SPLAT(0), SPLAT(0), history, whole, of_extremes};
            if (job->metric[m].kind == MV_SETTLING_ABOUT_END) history += most_records(&job->schedule);
        }
        signal += job->metric[m].signals;
    }
    b->times = (double *)history;
}

/* Load the parameters of the lanes and compute values that depend only on them. */
static void set_parameters(mv_block *b, mv_model *m)
{
    gather(b, b->job->p, NP, m->p);
    gather(b, b->job->c, NC, m->c);
    gather(b, b->job->s, NS, m->s);
    real r[NR + 1];
    mv_call_reference(m, SPLAT(b->job->schedule.t[0]), r);
    mv_prepare(m, r);
}

static void start(mv_block *b, const mv_job *job, int64_t first, char *work)
{
    mv_loop *l = &b->loop;
    real lanes = SPLAT(0), x0[NX];
    b->job = job;
    b->first = first;
    b->records = 0;
    b->t_record = b->recorded = SPLAT(0);
    for (int e = 0; e < EVENTS; e++) b->happened[e] = SPLAT(0);
    for (int i = 0; i < COLUMNS; i++) {
        b->minimum[i] = SPLAT(MV_INFINITY);
        b->maximum[i] = SPLAT(-MV_INFINITY);
    }
    for (int lane = 0; lane < MEHVAR_LANES; lane++) {
        b->run[lane] = job->number[first + lane < job->runs ? first + lane : job->runs - 1];
        AT(lanes, lane) = first + lane < job->runs;
    }
    divide_work(b, work);
    set_parameters(b, &l->model);
    l->schedule = &job->schedule;
    mv_begin(l, TRUTH(lanes));
    gather(b, job->x0, NX, x0);
    mv_call_start(&l->model, x0, l->r, l->column + Z_COLUMN);
    mv_call_to_coordinates(&l->model, x0, l->q);
    if (!SAMPLED) mv_copy(mv_integrated(l, l->q), l->column + Z_COLUMN, NZ);
}

static void mv_draw(const mv_loop *l, enum mv_stream stream, int64_t index, int size, real *e)
{
    const mv_block *b = (const mv_block *)l;
    mv_noise(b->job->seed, b->run, stream, (uint64_t)index, size, e);
}

static void mv_happen(mv_loop *l, mask lanes, int event)
{
    ((mv_block *)l)->happened[event] += SELECT0(lanes, SPLAT(1));
}

static void save(const mv_block *b, mask lanes, int64_t tick)
{
    const int64_t row = tick / b->job->save_every;
    if (row >= b->job->rows || tick % b->job->save_every) return;
    const real saved = SELECT0(lanes, SPLAT(1));
    for (int lane = 0; lane < MEHVAR_LANES && b->first + lane < b->job->runs; lane++) {
        if (!AT(saved, lane)) continue;
        double *to = b->job->series + ((b->first + lane) * b->job->rows + row) * COLUMNS;
        for (int i = 0; i < COLUMNS; i++) to[i] = AT(b->loop.column[i], lane);
    }
}

/* Count a row of the instant t in `lanes`. */
static void sum_up(mv_block *b, mask lanes, real t)
{
    const mv_loop *l = &b->loop;
    for (int i = 0; i < COLUMNS; i++) {
        const real v = l->column[i];
        const mask no_number = NE(v, v);
        b->minimum[i] = SELECT(AND(lanes, OR(LT(v, b->minimum[i]), no_number)), v, b->minimum[i]);
        b->maximum[i] = SELECT(AND(lanes, OR(LT(b->maximum[i], v), no_number)), v, b->maximum[i]);
    }
    mv_count(b, lanes, t);
    b->t_record = SELECT(lanes, t, b->t_record);
}

static void mv_record(mv_loop *l, mask lanes, int due)
{
    mv_block *b = (mv_block *)l;
    const double t = l->schedule->t[l->tick];
    sum_up(b, lanes, SPLAT(t));
    if (due) b->times[b->records++] = t;
    save(b, l->alive, l->tick);
}

static void mv_record_end(mv_loop *l, mask lanes)
{
    mv_block *b = (mv_block *)l;
    sum_up(b, lanes, l->t);
    save(b, AND(lanes, EQ(l->t, SPLAT(l->schedule->t[l->tick + 1]))), l->tick + 1);
}

static void finish(mv_block *b)
{
    const mv_job *job = b->job;
    const mv_loop *l = &b->loop;
    real x[NX];
    mv_call_from_coordinates(&l->model, l->q, x);
    scatter(b, x, NX, job->final);
    scatter(b, b->minimum, COLUMNS, job->minimum);
    scatter(b, b->maximum, COLUMNS, job->maximum);
    scatter(b, &l->t, 1, job->t_stop);
    scatter(b, &l->t_stiff, 1, job->t_stiff);
    scatter(b, &l->error, 1, job->error);
    for (int lane = 0; lane < MEHVAR_LANES && b->first + lane < job->runs; lane++) {
        const int64_t run = b->first + lane;
        job->status[run] = (uint8_t)AT(l->status, lane);
        job->violated[run] = (int32_t)AT(l->violated, lane);
        job->steps[run] = (int64_t)AT(l->steps, lane);
        for (int e = 0; e < EVENTS; e++) job->events[run * EVENTS + e] = (int64_t)AT(b->happened[e], lane);
        mv_metrics(b, lane, job->metric_values + run * job->metrics);
    }
}

/* Run the blocks first ... last - 1; `work` is mv_work_size bytes aligned to a real. Returns 1 if it was stopped. */
int mv_run_blocks(const mv_job *job, int64_t first, int64_t last, char *work)
{
    mv_block b;
    for (int64_t block = first; block < last; block++) {
        start(&b, job, block * MEHVAR_LANES, work);
        while (mv_any(b.loop.alive) && b.loop.tick < job->schedule.ticks) {
            if (*job->stop) return 1;
            mv_tick(&b.loop);
        }
        finish(&b);
    }
    return 0;
}

#ifdef LOCKSTEP
#include "lockstep.h"
#endif
