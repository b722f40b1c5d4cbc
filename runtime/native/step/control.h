/* SPDX-License-Identifier: Apache-2.0 */
/* Step size control: the first step, the error of a step over its tolerance, and the size of the next step. */
#ifndef MEHVAR_CONTROL_H
#define MEHVAR_CONTROL_H

#include "state.h"

/* Defined by the including file: estimates of the error of a step, divided by h. */
static inline void mv_estimate(const mv_loop *l, real *error, real *third_error);

/* The constants come from the codes dopri5 and dop853 of Hairer, Norsett & Wanner, except where a comment says
 * "own". We measured the effect of half and twice a constant in evaluations of the slope;
 * docs/explanation/numerics.md has the loops and the numbers. */

/* Safety factor: the ratio of a new step to the step whose error would equal the tolerance. Own, between their 0.8
 * and 0.9. With half the value a run takes 1.4 to 2.5 times the evaluations; with 0.95 it saves 2 to 15 %, but the
 * error is up to six times as large. */
#define SAFETY 0.85
/* Smallest and largest ratio of two trial steps. Half or twice changes less than one percent. */
#define SHRINK 0.2
#define GROW 10.0
/* Largest reserve of a step that counts in the control of the next one. A step with hardly any error has an
 * unbounded reserve, which must not hold back the following steps. Own. Twice the value changes less than one
 * percent; 1 saves up to a tenth, with an error up to seven times as large; with a half every third trial is
 * rejected. */
#define MOST_RESERVE (4.0 / 3)
/* Smallest step, in spacings of doubles at t. In shorter steps, rounding of t + h changes h by a twentieth. Own. */
#define LEAST_SPACINGS 10
/* Weight of the square of dop853's third-order estimate in the error. Half or twice changes less than one percent. */
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

/* Starting step by the algorithm of Hairer, Norsett & Wanner I, section II.4, with its constants. An Euler step that
 * changes x by a hundredth shows how the slope changes. If the local error grows like this change, the error of the
 * chosen step is a hundredth of the tolerance. The other constants are for x, slope or change near zero. Half or
 * twice either hundredth changes less than one percent of the evaluations of a run. */
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

/* Error of the step q -> y over its tolerance: the step is accepted if this is at most one. NaN if any number is
 * NaN. */
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

/* Proportional and integral control by Gustafsson, ACM Trans. Math. Softw. 17 (1991) 533; Hairer, Norsett & Wanner
 * II, section IV.2. The reserve of a step is ratio^(-1/(4 ORDER)); it is above one if the step could have been
 * longer. By its fourth power the step may grow. After an accepted step, the step grows by the third power of the
 * reserve, divided by the reserve of the step before: exponents 0.75 and 0.25 over the order. A rejected step
 * shrinks by the fourth power. */
static real mv_reserve(const mv_loop *l, real ratio)
{
    const real finite = SELECT(EQ(ratio - ratio, K(0)), mv_pow(ratio, SPLAT(-0.25 / ORDER)), SPLAT(0));
    return SELECT(EQ(ratio, K(0)), SPLAT(MV_INFINITY), finite);
}

static inline real mv_within_bounds(real factor) { return mv_min(SPLAT(GROW), mv_max(SPLAT(SHRINK), K(SAFETY) * factor)); }

/* Lanes that have not ended. */
static inline mask mv_going(const mv_loop *l) { return AND(l->alive, EQ(l->status, SPLAT(MV_DONE))); }

/* Stop lanes: they end where they are, with this status, once the earlier ticks are done. */
static inline void mv_halt(mv_loop *l, mask m, enum mv_status status) { l->status = SELECT(m, SPLAT(status), l->status); }

/* Next step of lanes whose step of length h was accepted or rejected. */
static inline void mv_control(mv_loop *l, real h, real ratio, mask taken, mask refused)
{
    const real reserve = mv_reserve(l, ratio), cube = reserve * reserve * reserve;
    const real factor = mv_min(SELECT(l->bounded, SPLAT(1), SPLAT(GROW)), mv_within_bounds(cube / l->reserve));
    const mask cut = LT(h, l->h); /* shortened by the target, which is no reason against longer steps */
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
