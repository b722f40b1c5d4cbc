/* SPDX-License-Identifier: Apache-2.0 */
/* How long a step may be: the first one, the error of one over its tolerance, and the one after it. */
#ifndef MEHVAR_CONTROL_H
#define MEHVAR_CONTROL_H

#include "state.h"

/* Defined by whoever includes this: estimates of the error of a step, over h. */
static inline void mv_estimate(const mv_loop *l, real *error, real *third_error);

/* Source: the codes dopri5 and dop853 of Hairer, Norsett & Wanner, unless it says "own". What halving and doubling does
 * was measured in evaluations of the slope; docs/explanation/numerics.md has the loops and the numbers. */

/* Of the step that would just be good; own, between their 0.8 and 0.9. A half costs 1.4 to 2.5 times the evaluations;
 * 0.95 saves 2 to 15 % of them, and the error is up to six times as large. */
#define SAFETY 0.85
/* The least and the most that one trial changes the step by. A half and twice: less than one percent. */
#define SHRINK 0.2
#define GROW 10.0
/* The most of a step's reserve that counts against the next: a step with hardly an error, which has a reserve without
 * bound, must not hold back what follows. Own. Twice as much: less than one percent; 1 instead: up to a tenth less,
 * with an error up to seven times as large; a half: every third trial is refused. */
#define MOST_RESERVE (4.0 / 3)
/* Steps end at this many times the spacing of the doubles at t: below, t + h is wrong by a twentieth of h. Own. */
#define LEAST_SPACINGS 10
/* Weight of the square of dop853's third-order estimate in the error; a half and twice: less than one percent. */
#define THIRD_WEIGHT 0.01

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

/* Starting step: the algorithm of Hairer, Norsett & Wanner I, section II.4, with its numbers. An Euler step that
 * changes x by a hundredth of itself shows how the slope changes; the step is then one whose error is a hundredth of the
 * tolerance if the local error goes like that change. The other numbers are for x, slope or change near zero. A half or
 * twice of either hundredth: less than one percent of the evaluations of a run. */
#define FIRST_CHANGE 0.01
static real mv_first_step(mv_loop *l, real room)
{
    real *probe = l->stage, *change = l->k[1];
    const real *slope = l->k[0];
    const real size = mv_scaled_rms(l, l->q, l->q), rate = mv_scaled_rms(l, slope, l->q);
    real h = SELECT(OR(LT(size, K(1e-5)), LT(rate, K(1e-5))), SPLAT(1e-6), K(FIRST_CHANGE) * size / rate);
    h = mv_min(h, room);
    for (int i = 0; i < NQ; i++) probe[i] = l->q[i] + h * slope[i];
    mv_slope(l, l->t + h, probe, change);
    const mask good = mv_finite(change, NQ);
    for (int i = 0; i < NQ; i++) change[i] -= slope[i];
    const real steepest = mv_max(rate, mv_scaled_rms(l, change, l->q) / h);
    const real next = mv_pow(K(FIRST_CHANGE) / steepest, SPLAT(1.0 / ORDER));
    const real flat = mv_max(SPLAT(1e-6), h * K(1e-3));
    return SELECT(good, mv_min(K(100) * h, SELECT(LE(steepest, K(1e-15)), flat, next)), h);
}

/* Error of the step q -> y over its tolerance: the step is good when this is at most one. NaN when anything is. */
static inline real mv_error_ratio(const mv_loop *l, real h)
{
    real error[NQ], third_error[NQ], main = SPLAT(0), third = SPLAT(0);
    if (GAMMA) {
        for (int i = 0; i < NQ; i++) error[i] = l->k[STAGES - 1][i] / h;
    } else {
        mv_estimate(l, error, third_error);
    }
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
    return SELECT(none, SPLAT(0), h * main / mv_sqrt((main + K(THIRD_WEIGHT) * third) * K(NQ)));
}

/* Step size control: the proportional and integral one of Gustafsson, ACM Trans. Math. Softw. 17 (1991) 533; Hairer,
 * Norsett & Wanner II, section IV.2. The reserve of a step, ratio^(-1/(4 ORDER)), is above one when the step could have
 * been longer; its fourth power is what the step may grow by. A good step grows by three of them less that of the step
 * before: exponents 0.75 and 0.25 over the order. A refused one shrinks by all four. */
static real mv_reserve(const mv_loop *l, real ratio)
{
    const real finite = SELECT(EQ(ratio - ratio, K(0)), mv_pow(ratio, SPLAT(-0.25 / ORDER)), SPLAT(0));
    return SELECT(EQ(ratio, K(0)), SPLAT(MV_INFINITY), finite);
}

static inline real mv_within_bounds(real factor) { return mv_min(SPLAT(GROW), mv_max(SPLAT(SHRINK), K(SAFETY) * factor)); }

/* Lanes that nothing has ended. */
static inline mask mv_going(const mv_loop *l) { return AND(l->alive, EQ(l->status, SPLAT(MV_DONE))); }

/* Let lanes take no further step: they end where they are, with this status, once the ticks before that are done. */
static inline void mv_halt(mv_loop *l, mask m, enum mv_status status) { l->status = SELECT(m, SPLAT(status), l->status); }

/* The next step of the lanes that took one of length h or were refused it. */
static inline void mv_control(mv_loop *l, real h, real ratio, mask taken, mask refused)
{
    const real reserve = mv_reserve(l, ratio), cube = reserve * reserve * reserve;
    const real factor = mv_min(SELECT(l->bounded, SPLAT(1), SPLAT(GROW)), mv_within_bounds(cube / l->reserve));
    const mask cut = LT(h, l->h); /* short by the target, which says nothing against the longer step */
    const real next = SELECT(AND(cut, LE(K(1), factor)), mv_max(l->h, h * factor), h * factor);
    const real retry = h * mv_min(SPLAT(1), mv_within_bounds(cube * reserve));
    l->h = SELECT(taken, next, SELECT(refused, retry, l->h));
    l->reserve = SELECT(AND(taken, NOT(cut)), mv_min(reserve, SPLAT(MOST_RESERVE)), l->reserve);
    const real resolution = mv_from_bits(mv_to_bits(l->t) + 1) - l->t;
    const mask small = AND(refused, LT(l->h, K(LEAST_SPACINGS) * resolution)), finite = EQ(ratio - ratio, K(0));
    mv_halt(l, AND(small, finite), MV_STEP_UNDERFLOW);
    mv_halt(l, AND(small, NOT(finite)), MV_NOT_FINITE);
    l->bounded = OR(refused, AND(l->bounded, NOT(taken)));
}

#endif
