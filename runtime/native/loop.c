/* SPDX-License-Identifier: Apache-2.0 */
/* One closed loop, sample by sample. The caller owns every array and may stop between two calls of mv_run. */
#include <math.h>
#include <string.h>

#include "integrator.h"

typedef void (*fn_1_1)(const double *, double *);
typedef void (*fn_3_1)(const double *, const double *, const double *, double *);
typedef void (*fn_4_1)(const double *, const double *, const double *, const double *, double *);
typedef void (*fn_4_2)(const double *, const double *, const double *, const double *, double *, double *);
typedef void (*fn_4_3)(const double *, const double *, const double *, const double *, double *, double *, double *);
typedef void (*fn_6_2)(const double *, const double *, const double *, const double *, const double *, const double *,
                       double *, double *);

typedef struct {
    mv_stepper stepper;
    /* sizes: coordinates, state, input, memory, outputs, limits, noise */
    int32_t nq, nx, nu, nz, ny, nm, ne;
    int32_t reference_constant;
    int32_t sampled;          /* law evaluated every hold_every ticks, input held in between */
    int32_t delay;            /* input applied `delay` evaluations after it was computed */
    int32_t violated;         /* index of the limit that ended the run */
    int64_t hold_every, record_every;
    int64_t ticks;            /* length of t */
    int64_t tick, records;    /* done so far */

    fn_3_1 rhs;               /* x, u, p -> dx */
    fn_4_1 outputs;           /* x, u, r, p -> y */
    fn_3_1 limits;            /* x, u, p -> margin; null without limits */
    fn_3_1 reference;         /* t, p, s -> r */
    fn_4_1 law;               /* x, r, p, c -> u */
    fn_6_2 law_memory;        /* x, r, v, z, p, c -> u, z_next; null without memory */
    fn_4_1 loop;              /* q, r, p, c -> dq */
    fn_4_2 observe;           /* q, r, p, c -> x, u; null with an actuator */
    fn_4_3 observe_command;   /* q, r, p, c -> x, u, u_cmd; null without an actuator */
    fn_3_1 actuate;           /* x, u_cmd, p -> u; null without an actuator */
    fn_3_1 measure;           /* x, e, p -> what the law sees of x; null when it sees x */
    fn_1_1 project;           /* q -> q; null without a manifold */

    const double *p, *c, *s, *t;
    const double *noise;      /* ne numbers for each evaluation of the law */
    double *q, *q_next, *x, *seen, *u, *u_cmd, *delayed, *r, *z, *z_next, *margin;
    double *queue;            /* the `delay` inputs computed last, oldest first */
    double *rec_t, *rec_x, *rec_u, *rec_u_cmd, *rec_y, *rec_z;
} mv_loop;

int64_t mv_loop_size(void) { return (int64_t)sizeof(mv_loop); }

static int finite_all(const double *v, int n)
{
    for (int i = 0; i < n; i++)
        if (!isfinite(v[i])) return 0;
    return 1;
}

static void copy(double *to, const double *from, int64_t n) { memcpy(to, from, (size_t)n * sizeof(double)); }

static void continuous_rhs(double t, const double *q, double *dq, void *context)
{
    mv_loop *l = context;
    if (!l->reference_constant) l->reference(&t, l->p, l->s, l->r);
    l->loop(q, l->r, l->p, l->c, dq);
}

static void held_rhs(double t, const double *x, double *dx, void *context)
{
    mv_loop *l = context;
    (void)t;
    l->rhs(x, l->u, l->p, dx);
}

static void observe(mv_loop *l, const double *q)
{
    if (l->observe_command) {
        l->observe_command(q, l->r, l->p, l->c, l->x, l->u, l->u_cmd);
        return;
    }
    l->observe(q, l->r, l->p, l->c, l->x, l->u);
    copy(l->u_cmd, l->u, l->nu);
}

static int within_limits(mv_loop *l, const double *x, const double *u)
{
    if (!l->limits) return 1;
    l->limits(x, u, l->p, l->margin);
    for (int i = 0; i < l->nm; i++)
        if (!(l->margin[i] > 0.0)) {
            l->violated = i;
            return 0;
        }
    return 1;
}

static enum mv_verdict accept(double *q, void *context)
{
    mv_loop *l = context;
    if (l->project) {
        l->project(q, l->q_next);
        copy(q, l->q_next, l->nq);
    }
    /* a sampled loop is looked at tick by tick */
    if (l->limits && !l->sampled) {
        if (!l->reference_constant) l->reference(&l->stepper.t, l->p, l->s, l->r);
        observe(l, q);
        if (!within_limits(l, l->x, l->u)) return MV_STOP;
    }
    return l->project ? MV_MOVED : MV_GO_ON;
}

/* The law's input enters the queue; the oldest one leaves it and goes to the actuator. */
static void apply(mv_loop *l)
{
    const double *wanted = l->u_cmd;
    if (l->delay > 0) {
        const int64_t rest = (int64_t)(l->delay - 1) * l->nu;
        copy(l->delayed, l->queue, l->nu);
        memmove(l->queue, l->queue + l->nu, (size_t)rest * sizeof(double));
        copy(l->queue + rest, l->u_cmd, l->nu);
        wanted = l->delayed;
    }
    if (l->actuate)
        l->actuate(l->x, wanted, l->p, l->u);
    else
        copy(l->u, wanted, l->nu);
}

static void sample(mv_loop *l)
{
    const double t = l->t[l->tick];
    l->reference(&t, l->p, l->s, l->r);
    if (!l->sampled) {
        observe(l, l->q);
        return;
    }
    copy(l->x, l->q, l->nx);
    if (l->tick % l->hold_every != 0) return;
    const double *seen = l->x;
    if (l->measure) {
        l->measure(l->x, l->noise + l->tick / l->hold_every * l->ne, l->p, l->seen);
        seen = l->seen;
    }
    if (l->law_memory)
        l->law_memory(seen, l->r, l->u, l->z, l->p, l->c, l->u_cmd, l->z_next);
    else
        l->law(seen, l->r, l->p, l->c, l->u_cmd);
    apply(l);
}

static void record(mv_loop *l)
{
    const int64_t k = l->records++;
    l->rec_t[k] = l->t[l->tick];
    copy(l->rec_x + k * l->nx, l->x, l->nx);
    copy(l->rec_u + k * l->nu, l->u, l->nu);
    copy(l->rec_u_cmd + k * l->nu, l->u_cmd, l->nu);
    copy(l->rec_z + k * l->nz, l->z, l->nz);
    l->outputs(l->x, l->u, l->r, l->p, l->rec_y + k * l->ny);
}

/* Go on until `until` ticks are done, at most l->ticks; returns an mv_status. */
int mv_run(mv_loop *l, int64_t until)
{
    const mv_rhs f = l->sampled ? held_rhs : continuous_rhs;
    for (; l->tick < until; l->tick++) {
        sample(l);
        const int due = l->sampled && l->tick % l->hold_every == 0;
        const int allowed = !l->sampled || within_limits(l, l->x, l->u_cmd);
        const int healthy = finite_all(l->x, l->nx) && finite_all(l->u_cmd, l->nu) && finite_all(l->u, l->nu);
        if (l->tick % l->record_every == 0 || l->tick + 1 == l->ticks || !healthy || !allowed) record(l);
        if (!healthy) return MV_NOT_FINITE;
        if (!allowed) return MV_LIMIT;
        if (due && l->law_memory) copy(l->z, l->z_next, l->nz);
        if (l->tick + 1 == l->ticks) continue;
        const int status = mv_advance(&l->stepper, l->q, l->t[l->tick + 1], f, accept, l);
        if (status != MV_DONE) return status;
    }
    return MV_DONE;
}
