/* SPDX-License-Identifier: Apache-2.0 */
/* Blocks in step, for a law outside of the kernel that is evaluated once per sample for all runs.
 *
 * Included by batch.c if the kernel's law copies the values of mv_own. */
#ifndef MEHVAR_LOCKSTEP_H
#define MEHVAR_LOCKSTEP_H

/* Arguments and results of the law: a row per quantity, a column per run. */
typedef struct {
    double *x, *r;             /* the state as measured, the reference */
    double *u;                 /* the input */
    double *z;                 /* the memory, before and after */
    char *places;              /* of the blocks of lanes, aligned to a real: mv_place_size bytes each */
} mv_own;

static int64_t rounded(int64_t bytes)
{
    const int64_t size = (int64_t)sizeof(real);
    return (bytes + size - 1) / size * size;
}

/* Return the bytes that a block of lanes keeps between samples. */
int64_t mv_place_size(const mv_job *job) { return rounded((int64_t)sizeof(mv_block)) + rounded(mv_work_size(job)); }

static mv_block *place_of(const mv_job *job, const mv_own *own, int64_t block)
{
    return (mv_block *)(own->places + block * mv_place_size(job));
}

static void columns_in(const mv_block *b, const double *rows, int width, real *to)
{
    for (int lane = 0; lane < MEHVAR_LANES; lane++) {
        const int64_t run = b->first + lane < b->job->runs ? b->first + lane : b->job->runs - 1;
        for (int i = 0; i < width; i++) AT(to[i], lane) = rows[i * b->job->runs + run];
    }
}

static void columns_out(const mv_block *b, const real *from, int width, double *rows)
{
    for (int lane = 0; lane < MEHVAR_LANES && b->first + lane < b->job->runs; lane++)
        for (int i = 0; i < width; i++) rows[i * b->job->runs + b->first + lane] = AT(from[i], lane);
}

/* Write the law's arguments at the next tick. */
static void see(mv_block *b, const mv_own *own)
{
    mv_loop *l = &b->loop;
    real x_seen[SEEN], e[NOISE + 1];
    mv_refer(l, SPLAT(l->schedule->t[l->tick]));
    mv_draw(l, MV_OF_MEASUREMENTS, l->tick / l->schedule->hold_every, NOISE, e);
    mv_call_measure(&l->model, l->q, e, x_seen);
    columns_out(b, x_seen, SEEN, own->x);
    columns_out(b, l->r, NR, own->r);
    columns_out(b, l->column + Z_COLUMN, NZ, own->z);
}

/* Begin the blocks first ... last - 1; `own` brings the memory before the first sample. */
void mv_begin_blocks(const mv_job *job, const mv_own *own, int64_t first, int64_t last)
{
    for (int64_t block = first; block < last; block++) {
        mv_block *b = place_of(job, own, block);
        b->job = job;
        b->first = block * MEHVAR_LANES;
        columns_in(b, own->z, NZ, b->loop.model.z_own);
        start(b, job, block * MEHVAR_LANES, (char *)b + rounded((int64_t)sizeof(mv_block)));
        see(b, own);
    }
}

/* Continue with the law's results up to the tick `until` or the end of the blocks. */
void mv_continue_blocks(const mv_job *job, const mv_own *own, int64_t until, int64_t first, int64_t last)
{
    for (int64_t block = first; block < last; block++) {
        mv_block *b = place_of(job, own, block);
        mv_loop *l = &b->loop;
        columns_in(b, own->u, NU, l->model.u_own);
        columns_in(b, own->z, NZ, l->model.z_own);
        while (mv_any(l->alive) && l->tick < until) mv_tick(l);
        if (until == job->schedule.ticks)
            finish(b);
        else if (mv_any(l->alive))
            see(b, own);
    }
}

#endif
