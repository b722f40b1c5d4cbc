/* SPDX-License-Identifier: Apache-2.0 */
/* Explicit Runge-Kutta steps with exact stops, in every lane with a step of its own. No allocation, no shared state.
 *
 * A method is
 *   STAGES                   slopes k[0] ... k[STAGES - 1]; k[STAGES] is the one at the end of the step
 *   ORDER                    the local error goes like step^ORDER; 0 for a fixed step
 *   ESTIMATED, END_IN_ERROR  there is an error estimate; it needs the slope at the end
 *   THIRD                    there is a second estimate, of order three (dop853) */
#ifndef MEHVAR_STEP_H
#define MEHVAR_STEP_H

#include "state.h"

/* Defined by whoever includes this: the slopes k[1] ... and the end y of a step; the estimates of its error over h. */
static inline void mv_stages(mv_loop *l, real h);
static inline void mv_estimate(const mv_loop *l, real *error, real *third_error);

#define SAFETY 0.85
#define SHRINK 0.2
#define GROW 10.0
#define MOST_RESERVE (4.0 / 3)
#define STRETCH 1.01
#define SLACK 1e-12

static __attribute__((noinline)) void mv_slope(mv_loop *l, real t, const real *q, real *dq)
{
    l->evaluations++;
    if (SAMPLED) {
        mv_call_rhs(&l->model, q, l->column + U_COLUMN, dq);
        return;
    }
    mv_refer(l, t);
    mv_call_loop(&l->model, q, l->r, dq);
}

static inline real mv_larger(real a, real b) { return SELECT(LT(a, b), b, a); }

static inline real mv_tolerance(const mv_loop *l, real size) { return K(l->schedule->atol) + K(l->schedule->rtol) * size; }

static inline real mv_scaled_rms(const mv_loop *l, const real *v, const real *x)
{
    real sum = SPLAT(0);
    for (int i = 0; i < NQ; i++) {
        const real part = v[i] / mv_tolerance(l, mv_fabs(x[i]));
        sum += part * part;
    }
    return mv_sqrt(sum / K(NQ));
}

/* Starting step: Hairer, Norsett & Wanner I, section II.4. */
static real mv_first_step(mv_loop *l, real room)
{
    real *probe = l->stage, *change = l->k[1];
    const real *slope = l->k[0];
    const real size = mv_scaled_rms(l, l->q, l->q), rate = mv_scaled_rms(l, slope, l->q);
    real h = SELECT(OR(LT(size, K(1e-5)), LT(rate, K(1e-5))), SPLAT(1e-6), K(0.01) * size / rate);
    h = mv_min(h, room);
    for (int i = 0; i < NQ; i++) probe[i] = l->q[i] + h * slope[i];
    mv_slope(l, l->t + h, probe, change);
    const mask good = mv_finite(change, NQ);
    for (int i = 0; i < NQ; i++) change[i] -= slope[i];
    const real steepest = mv_max(rate, mv_scaled_rms(l, change, l->q) / h);
    const real next = mv_pow(K(0.01) / steepest, SPLAT(1.0 / ORDER));
    const real flat = mv_max(SPLAT(1e-6), h * K(1e-3));
    return SELECT(good, mv_min(K(100) * h, SELECT(LE(steepest, K(1e-15)), flat, next)), h);
}

/* Error of the step q -> y over its tolerance: the step is good when this is at most one. NaN when anything is. */
static inline real mv_error_ratio(const mv_loop *l, real h)
{
    real error[NQ], third_error[NQ], main = SPLAT(0), third = SPLAT(0);
    mv_estimate(l, error, third_error);
    for (int i = 0; i < NQ; i++) {
        const real weight = K(1) / mv_tolerance(l, mv_larger(mv_fabs(l->q[i]), mv_fabs(l->y[i])));
        error[i] *= weight;
        main += error[i] * error[i];
        if (THIRD) {
            third_error[i] *= weight;
            third += third_error[i] * third_error[i];
        }
    }
    if (!THIRD) return h * mv_sqrt(main / K(NQ));
    const mask none = AND(EQ(main, K(0)), EQ(third, K(0)));
    return SELECT(none, SPLAT(0), h * main / mv_sqrt((main + K(0.01) * third) * K(NQ)));
}

/* Step size control: Gustafsson's proportional and integral one, Hairer, Norsett & Wanner I and II, sections II.4 and
 * IV.2. The reserve of a step, ratio^(-1/(4 ORDER)), is above one when the step could have been longer; its fourth
 * power is what the step may grow by. A good step grows by three of them less that of the step before. */
static real mv_reserve(const mv_loop *l, real ratio)
{
    const real finite = SELECT(EQ(ratio - ratio, K(0)), mv_pow(ratio, SPLAT(-0.25 / ORDER)), SPLAT(0));
    return SELECT(EQ(ratio, K(0)), SPLAT(MV_INFINITY), finite);
}

static inline real mv_within_bounds(real factor) { return mv_min(SPLAT(GROW), mv_max(SPLAT(SHRINK), K(SAFETY) * factor)); }

/* One trial step of the lanes `open`; `last` are those that reach the target with it. Returns those that took it. */
static mask mv_trial(mv_loop *l, real target, real h, mask open, mask last, real *ratio)
{
    real *end = l->k[STAGES];
    const mask goes_on = SAMPLED ? NOT(last) : mv_all(); /* where the slope at the end is that of the next step */
    mv_stages(l, h);
    mask good = mv_finite(l->y, NQ);
    if (END_IN_ERROR) {
        mv_slope(l, l->t + h, l->y, end);
        good = AND(good, OR(NOT(goes_on), mv_finite(end, NQ)));
    }
    *ratio = SELECT(good, ESTIMATED ? mv_error_ratio(l, h) : SPLAT(0), SPLAT(MV_NAN));
    mask taken = AND(open, ORDER ? LE(*ratio, K(1)) : good);
    if (PROJECTED) {
        mv_call_project(&l->model, l->y, l->stage);
        mv_copy(l->y, l->stage, NQ);
    }
    if ((PROJECTED || !END_IN_ERROR) && mv_any(AND(taken, goes_on))) {
        mv_slope(l, PROJECTED ? SELECT(last, target, l->t + h) : l->t + h, l->y, end);
        const mask broken = AND(AND(taken, goes_on), NOT(mv_finite(end, NQ)));
        *ratio = SELECT(broken, SPLAT(MV_NAN), *ratio);
        taken = AND(taken, NOT(broken));
    }
    l->t = SELECT(taken, SELECT(last, target, l->t + h), l->t);
    mv_blend(taken, l->q, l->y, NQ);
    mv_blend(taken, l->k[0], end, NQ);
    l->steps += SELECT0(taken, SPLAT(1));
    l->rejected += SELECT0(AND(open, NOT(taken)), SPLAT(1));
    l->error = SELECT(taken, mv_max(l->error, *ratio), l->error);
    return taken;
}

/* The next step of the lanes that took one of length h or were refused it; `bounded` were refused the trial before. */
static inline void mv_control(mv_loop *l, real h, real ratio, mask taken, mask refused, mask bounded)
{
    const real reserve = mv_reserve(l, ratio), cube = reserve * reserve * reserve;
    const real factor = mv_min(SELECT(bounded, SPLAT(1), SPLAT(GROW)), mv_within_bounds(cube / l->reserve));
    const mask cut = LT(h, l->h); /* short by the target, which says nothing against the longer step */
    const real next = SELECT(AND(cut, LE(K(1), factor)), mv_max(l->h, h * factor), h * factor);
    const real retry = h * mv_min(SPLAT(1), mv_within_bounds(cube * reserve));
    l->h = SELECT(taken, next, SELECT(refused, retry, l->h));
    l->reserve = SELECT(AND(taken, NOT(cut)), mv_min(reserve, SPLAT(MOST_RESERVE)), l->reserve);
    const real resolution = mv_from_bits(mv_to_bits(l->t) + 1) - l->t;
    const mask small = AND(refused, LT(l->h, K(10) * resolution)), finite = EQ(ratio - ratio, K(0));
    mv_retire(l, AND(small, finite), MV_STEP_UNDERFLOW);
    mv_retire(l, AND(small, NOT(finite)), MV_NOT_FINITE);
}

/* Lanes that have moved to q end there when that is beyond a limit. A sampled loop is looked at tick by tick. */
static inline void mv_check_limits(mv_loop *l, mask moved)
{
    if (!LIMITS || SAMPLED) return;
    real x[NX], u[NU], u_cmd[NU];
    mv_refer(l, l->t);
    mv_call_observe(&l->model, l->q, l->r, x, u, u_cmd);
    mv_retire(l, AND(moved, NOT(mv_allowed(l, moved, x, u))), MV_LIMIT);
}

/* Before the first trial step from t to the target. */
static inline void mv_prepare_steps(mv_loop *l, real target)
{
    if (SAMPLED) mv_hold(&l->model, l->column + U_COLUMN);
    if (!l->ready) mv_slope(l, l->t, l->q, l->k[0]);
    l->ready = !SAMPLED;
    mv_retire(l, AND(l->alive, NOT(mv_finite(l->k[0], NQ))), MV_NOT_FINITE);
    if (!mv_any(l->alive)) return;
    if (!ORDER)
        l->h = (target - l->t) / mv_ceil((target - l->t) / K(l->schedule->step) * K(1 - SLACK));
    else if (!l->started)
        l->h = mv_first_step(l, target - l->t);
    l->started = 1;
}

/* Integrate all lanes that are alive to exactly `goal`; those that cannot get there are retired where they are. */
static void mv_advance(mv_loop *l, double goal)
{
    const real target = SPLAT(goal);
    mv_prepare_steps(l, target);
    mask open = l->alive, bounded = mv_none();
    for (int64_t trial = 0; mv_any(open); trial++) {
        if (trial == l->schedule->max_steps) {
            mv_retire(l, open, MV_TOO_MANY_STEPS);
            return;
        }
        const real room = target - l->t;
        const mask last = LE(room, K(STRETCH) * l->h);
        const real h = SELECT(last, room, l->h);
        real ratio;
        const mask taken = mv_trial(l, target, h, open, last, &ratio), refused = AND(open, NOT(taken));
        if (ORDER)
            mv_control(l, h, ratio, taken, refused, bounded);
        else
            mv_retire(l, refused, MV_NOT_FINITE);
        bounded = refused;
        mv_check_limits(l, taken);
        open = AND(l->alive, LT(l->t, target));
    }
}

#endif
