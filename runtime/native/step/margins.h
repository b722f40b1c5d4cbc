/* SPDX-License-Identifier: Apache-2.0 */
/* Limits: margins must be positive along a run. The run ends where a margin is not positive.
 *
 * If a step ends beyond a limit, it is repeated up to the zero of the margin, which is found by secants, until the
 * step ends past the limit by at most the tolerance. A secant misjudges a margin that is flat beyond its zero; so if
 * the margin is not positive one tolerance before the end either, half of the step is tried. A margin may also touch
 * zero within a step and rise again: for example, the sum of two rods less the third, when they become collinear; the
 * motion behind it is another one. So if the tangent of a margin reaches zero within a step and the margin rises
 * behind it, the step is repeated up to that point, which is half way to the point where a parabola touches. Steps
 * become shorter until one ends beyond the limit or the margin turns earlier. Fixed steps cannot be shortened; they
 * end the run. These checks do not change steps that stay away from the limits. */
#ifndef MEHVAR_MARGINS_H
#define MEHVAR_MARGINS_H

#include "control.h"

/* Largest time past a limit, as a share of the run. Own: times are printed with six digits; a tenth or ten times as
 * much adds or saves one trial of about ten. */
#define LIMIT_TIME 1e-9
/* Part of the step along the slope at which a margin is evaluated, to see if it falls or rises. Own: far above the
 * noise of a margin, and far below its turns. */
#define AHEAD_PART 1e-3
/* True if margins are evaluated along a slope. This is not done if it would need extra evaluations of the law. */
#define TOUCHES (SAMPLED || STATE_LIMITS)

static inline void mv_margins(mv_loop *l, real t, const real *q, real *margin)
{
    real x[NX], u[NU], u_cmd[NU];
    if (TOUCHES) {
        mv_call_limits(&l->model, q, l->u_cmd, margin);
        return;
    }
    mv_refer(l, t);
    mv_call_observe(&l->model, q, l->r, x, u, u_cmd);
    mv_call_limits(&l->model, x, u, margin);
}

/* Return those of `lanes` that keep the limits; store the first broken limit of the others. */
static inline mask mv_allowed(mv_loop *l, mask lanes, const real *margin)
{
    mask within = mv_all();
    for (int i = 0; i < LIMITS; i++) {
        const mask broken = AND(AND(lanes, within), NOT(LT(K(0), margin[i])));
        l->violated = SELECT(broken, SPLAT(i), l->violated);
        within = AND(within, NOT(broken));
    }
    return within;
}

/* Evaluate margins at q, where a lane has come without a step; return those of `lanes` that keep the limits. */
static mask mv_take_margins(mv_loop *l, mask lanes, const real *q)
{
    mv_margins(l, l->t, q, l->margin);
    return mv_allowed(l, lanes, l->margin);
}

/* Evaluate margins slightly ahead of q along a slope. */
static void mv_margins_ahead(mv_loop *l, real h, const real *q, const real *slope, real *margin)
{
    real ahead[NQ];
    for (int i = 0; i < NQ; i++) ahead[i] = q[i] + K(AHEAD_PART) * h * slope[i];
    mv_margins(l, l->t, ahead, margin);
}

/* Return those of `lanes` with a margin that may touch zero in the step q -> y; `least` is the part of the step at
 * which its tangent is zero. */
static mask mv_touches(mv_loop *l, real h, real after, mask lanes, real *least)
{
    real ahead[LIMITS + 1];
    mask touched = mv_none();
    if (!TOUCHES) return touched;
    mv_margins_ahead(l, h, l->q, l->k[0], ahead);
    for (int i = 0; i < LIMITS; i++) {
        const real part = K(AHEAD_PART) * l->margin[i] / (l->margin[i] - ahead[i]);
        mask falls = AND(lanes, AND(LE(K(0), part), LE(part, SPLAT(1))));
        if (!mv_any(falls)) continue;
        real behind[LIMITS + 1];
        mv_slope(l, after, l->y, l->stage);
        mv_margins_ahead(l, h, l->y, l->stage, behind);
        falls = AND(falls, LT(l->margin_end[i], behind[i]));
        l->violated = SELECT(AND(falls, LT(part, *least)), SPLAT(i), l->violated);
        *least = SELECT(falls, mv_min(part, *least), *least);
        touched = OR(touched, falls);
    }
    return touched;
}

/* Return those of `lanes` that are beyond a limit already at the time `before` the end of the step q -> y. */
static mask mv_broken_before(mv_loop *l, real after, real before, mask lanes)
{
    real earlier[NQ], margin[LIMITS + 1];
    mask beyond = mv_none();
    if (!mv_any(lanes)) return beyond;
    mv_slope(l, after, l->y, l->stage);
    for (int i = 0; i < NQ; i++) earlier[i] = l->y[i] - before * l->stage[i];
    mv_margins(l, after - before, earlier, margin);
    for (int i = 0; i < LIMITS; i++) beyond = OR(beyond, AND(lanes, NOT(LT(K(0), margin[i]))));
    return beyond;
}

/* Return those of `lanes` that may accept the step q -> y of length h to `after`. The others repeat it up to l->aim. */
static mask mv_within_limits(mv_loop *l, real h, real after, mask lanes)
{
    l->again = mv_none();
    if (!mv_any(lanes)) return lanes;
    real part = SPLAT(1), past = SPLAT(0), least = SPLAT(MV_INFINITY);
    mv_margins(l, after, l->y, l->margin_end);
    const mask good = mv_allowed(l, lanes, l->margin_end), crossed = AND(lanes, NOT(good));
    for (int i = 0; i < LIMITS; i++) {
        const real now = l->margin[i], end = l->margin_end[i], held = now * l->held;
        const mask broken = AND(crossed, NOT(LT(K(0), end)));
        part = SELECT(broken, mv_min(part, held / (held - end)), part);
        past = SELECT(broken, mv_max(past, end / (end - now)), past);
    }
    const mask touched = mv_touches(l, h, after, AND(lanes, good), &least);
    part = SELECT(touched, least, part);
    past = SELECT(touched, SPLAT(1), past);
    l->broken = OR(crossed, touched);
    if (!ORDER) return lanes;
    const real tolerance = SPLAT(LIMIT_TIME * l->schedule->t[l->schedule->ticks - 1]);
    const mask far = AND(l->broken, AND(LT(tolerance, h), LT(tolerance, past * h)));
    const mask late = mv_broken_before(l, after, tolerance, AND(AND(crossed, NOT(far)), LT(tolerance, h)));
    const mask again = OR(far, late);
    part = SELECT(late, SPLAT(0.5), part);
    l->held = SELECT(again, l->held * K(0.5), SPLAT(1)); /* the Illinois rule */
    l->aim = SELECT(again, mv_max(part * h, tolerance * K(0.5)), l->aim);
    l->h = SELECT(again, mv_min(l->h, l->aim), l->h); /* the next look ahead is near, too */
    l->again = again;
    return AND(lanes, NOT(again));
}

/* Accept a step of lanes; end lanes that have broken a limit. */
static inline void mv_move_margins(mv_loop *l, mask taken)
{
    mv_blend(taken, l->margin, l->margin_end, LIMITS);
    l->aim = SELECT(taken, SPLAT(MV_INFINITY), l->aim);
    mv_halt(l, AND(taken, l->broken), MV_LIMIT);
}

#endif
