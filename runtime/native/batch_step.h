/* SPDX-License-Identifier: Apache-2.0 */
/* Explicit Runge-Kutta steps, in every lane with a step of its own: what mv_advance of integrator.c does with one run,
 * to the last bit where products and sums are not contracted. */
#ifndef MEHVAR_BATCH_STEP_H
#define MEHVAR_BATCH_STEP_H

#include "batch.h"

static inline void mv_refer(mv_block *b, real t)
{
#if REFERENCE_CONSTANT
    (void)b;
    (void)t;
#else
    mv_call_reference(&b->fixed, t, b->r);
#endif
}

#define SAFETY 0.85
#define SHRINK 0.2
#define GROW 10.0
#define MOST_RESERVE (4.0 / 3)

static __attribute__((noinline)) void mv_slope(mv_block *b, real t, const real *q, real *dq)
{
#if SAMPLED
    (void)t;
    mv_call_rhs(&b->fixed, q, b->column + U_COLUMN, dq);
#else
    mv_refer(b, t);
    mv_call_loop(&b->fixed, q, b->r, dq);
#endif
}

#include "stages.h"

static inline real mv_larger(real a, real b) { return SELECT(LT(a, b), b, a); }

static inline real mv_scaled_rms(const mv_block *b, const real *v, const real *x)
{
    real sum = SPLAT(0);
    for (int i = 0; i < NQ; i++) {
        const real part = v[i] / (K(b->job->atol) + K(b->job->rtol) * mv_fabs(x[i]));
        sum += part * part;
    }
    return mv_sqrt(sum / K(NQ));
}

#if ORDER
/* Starting step: Hairer, Norsett & Wanner I, section II.4. */
static real mv_first_step(mv_block *b, real room)
{
    real *probe = b->stage, *change = b->k[1];
    const real *slope = b->k[0];
    const real size = mv_scaled_rms(b, b->q, b->q), rate = mv_scaled_rms(b, slope, b->q);
    real h = SELECT(OR(LT(size, K(1e-5)), LT(rate, K(1e-5))), SPLAT(1e-6), K(0.01) * size / rate);
    h = mv_min(h, room);
    for (int i = 0; i < NQ; i++) probe[i] = b->q[i] + h * slope[i];
    mv_slope(b, b->t + h, probe, change);
    const mask good = mv_finite(change, NQ);
    for (int i = 0; i < NQ; i++) change[i] -= slope[i];
    const real steepest = mv_max(rate, mv_scaled_rms(b, change, b->q) / h);
    const real next = mv_pow(K(0.01) / steepest, SPLAT(1.0 / ORDER));
    const real flat = mv_max(SPLAT(1e-6), h * K(1e-3));
    return SELECT(good, mv_min(K(100) * h, SELECT(LE(steepest, K(1e-15)), flat, next)), h);
}

static real mv_reserve(real ratio)
{
    const real finite = SELECT(EQ(ratio - ratio, K(0)), mv_pow(ratio, SPLAT(-0.25 / ORDER)), SPLAT(0));
    return SELECT(EQ(ratio, K(0)), SPLAT(MV_INFINITY), finite);
}

static inline real mv_within_bounds(real factor) { return mv_min(SPLAT(GROW), mv_max(SPLAT(SHRINK), K(SAFETY) * factor)); }
#endif

/* Error of the step q -> y over its tolerance. */
static inline real mv_error_ratio(const mv_block *b, real h)
{
    real main = SPLAT(0), third = SPLAT(0);
    for (int i = 0; i < NQ; i++) {
        const real size = mv_larger(mv_fabs(b->q[i]), mv_fabs(b->y[i]));
        const real weight = K(1) / (K(b->job->atol) + K(b->job->rtol) * size);
        const real part = mv_error(b->k, i) * weight;
        main += part * part;
#if THIRD
        const real other = mv_third_error(b->k, i) * weight;
        third += other * other;
#endif
    }
    (void)third;
#if THIRD
    const mask none = AND(EQ(main, K(0)), EQ(third, K(0)));
    return SELECT(none, SPLAT(0), h * main / mv_sqrt((main + K(0.01) * third) * K(NQ)));
#else
    return h * mv_sqrt(main / K(NQ));
#endif
}

/* Lanes that have moved to q are put back on their manifold, and out of the way when beyond a limit. */
static inline void mv_check_limits(mv_block *b, mask moved)
{
#if LIMITS && !SAMPLED
    real x[NX], u[NU], u_cmd[NU], margin[LIMITS];
    mv_refer(b, b->t);
    mv_call_observe(&b->fixed, b->q, b->r, x, u, u_cmd);
    mv_call_limits(&b->fixed, x, u, margin);
    mask within = NOT(mv_none());
    for (int i = 0; i < LIMITS; i++) {
        const mask broken = AND(AND(moved, within), NOT(LT(K(0), margin[i])));
        b->violated = SELECT(broken, SPLAT(i), b->violated);
        within = AND(within, NOT(broken));
    }
    mv_retire(b, AND(moved, NOT(within)), MV_LIMIT);
#else
    (void)b;
    (void)moved;
#endif
}

/* One trial step of the lanes `open`; `last` are those that reach the target with it. Returns those that took it. */
static mask mv_trial(mv_block *b, real target, real h, mask open, mask last, real *ratio)
{
    real *end = b->k[STAGES];
    const mask wanted = SAMPLED ? NOT(last) : NOT(mv_none());
    mv_stages(b, h);
    mask good = mv_finite(b->y, NQ);
#if END_IN_ERROR
    mv_slope(b, b->t + h, b->y, end);
    *ratio = mv_error_ratio(b, h);
    good = AND(good, OR(NOT(wanted), mv_finite(end, NQ)));
#else
    *ratio = mv_error_ratio(b, h);
#endif
#if PROJECTED
    mv_call_project(&b->fixed, b->y, b->stage);
    for (int i = 0; i < NQ; i++) b->y[i] = b->stage[i];
#endif
#if PROJECTED || !END_IN_ERROR
    if (mv_any(AND(open, wanted))) {
        mv_slope(b, PROJECTED ? SELECT(last, target, b->t + h) : b->t + h, b->y, end);
        good = AND(good, OR(NOT(wanted), mv_finite(end, NQ)));
    }
#endif
    *ratio = SELECT(good, *ratio, SPLAT(MV_NAN));
    const mask taken = AND(open, ORDER ? LE(*ratio, K(1)) : good);
    b->t = SELECT(taken, SELECT(last, target, b->t + h), b->t);
    mv_blend(taken, b->q, b->y, NQ);
    mv_blend(taken, b->k[0], end, NQ);
    b->steps += SELECT0(taken, SPLAT(1));
    b->error = SELECT(taken, mv_max(b->error, *ratio), b->error);
    return taken;
}

/* Integrate all lanes that are alive to exactly `goal`; those that cannot get there are retired where they are. */
static void mv_advance(mv_block *b, double goal)
{
    const real target = SPLAT(goal);
#if SAMPLED
    mv_hold(&b->fixed, b->column + U_COLUMN);
#endif
    if (!b->ready) mv_slope(b, b->t, b->q, b->k[0]);
    b->ready = !SAMPLED;
    mv_retire(b, AND(b->alive, NOT(mv_finite(b->k[0], NQ))), MV_NOT_FINITE);
#if !ORDER
    b->h = (target - b->t) / mv_ceil((target - b->t) / K(b->job->step) * K(1 - 1e-12));
#else
    if (!b->started) b->h = mv_first_step(b, target - b->t);
    b->started = 1;
    mask bounded = mv_none(); /* the previous trial of this step failed: do not grow */
#endif
    mask open = AND(b->alive, LT(b->t, target));
    for (int64_t trial = 0; mv_any(open); trial++) {
        if (trial == b->job->max_steps) {
            mv_retire(b, open, MV_TOO_MANY_STEPS);
            return;
        }
        const real room = target - b->t;
        const mask last = LE(room, K(1.01) * b->h);
        const real h = SELECT(last, room, b->h);
        real ratio;
        const mask taken = mv_trial(b, target, h, open, last, &ratio);
        const mask refused = AND(open, NOT(taken));
#if !ORDER
        mv_retire(b, refused, MV_NOT_FINITE);
#else
        const real reserve = mv_reserve(ratio), cube = reserve * reserve * reserve;
        const real factor = mv_min(SELECT(bounded, SPLAT(1), SPLAT(GROW)), mv_within_bounds(cube / b->reserve));
        const mask cut = LT(h, b->h); /* short by the target, which says nothing against the longer step */
        const real next = SELECT(AND(cut, LE(K(1), factor)), mv_max(b->h, h * factor), h * factor);
        const real retry = h * mv_min(SPLAT(1), mv_within_bounds(cube * reserve));
        b->h = SELECT(taken, next, SELECT(refused, retry, b->h));
        b->reserve = SELECT(AND(taken, NOT(cut)), mv_min(reserve, SPLAT(MOST_RESERVE)), b->reserve);
        bounded = refused;
        const real resolution = mv_from_bits(mv_to_bits(b->t) + 1) - b->t;
        const mask small = AND(refused, LT(b->h, K(10) * resolution));
        const mask finite = EQ(ratio - ratio, K(0));
        mv_retire(b, AND(small, finite), MV_STEP_UNDERFLOW);
        mv_retire(b, AND(small, NOT(finite)), MV_NOT_FINITE);
#endif
        mv_check_limits(b, taken);
        open = AND(b->alive, LT(b->t, target));
    }
}

#endif
