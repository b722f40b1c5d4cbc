/* SPDX-License-Identifier: Apache-2.0 */
/* Limits: margins that are positive along a run, which ends where one is not.
 *
 * A step that ends beyond a limit is tried again to where its margin is zero if that falls evenly, until the step ends
 * past that by the tolerance at most. A margin may also touch zero within a step and rise again, as what two of three rods
 * have over the third where they fall in line; what comes behind is another motion. So a step over which the tangent of a
 * margin comes to zero, and behind which the margin rises, is tried again as far as the tangent goes, which is half way to
 * where a parabola touches: steps get shorter until one ends beyond the limit, or the margin turns before. Fixed steps
 * cannot, and end the run. A step that stays clear of the limits is not changed by any of this. */
#ifndef MEHVAR_MARGINS_H
#define MEHVAR_MARGINS_H

#include "control.h"

/* Of a run: a step may end so much time past a limit. Own: times are printed with six digits; a tenth or ten times as
 * much is a trial more or less of some ten. */
#define LIMIT_TIME 1e-9
/* Of a step: how far along the slope a margin is looked at to see whether it falls or rises. Own: far above the noise of a
 * margin, far below a turn of it. */
#define AHEAD_PART 1e-3
/* Whether margins are looked at along a slope: not where that takes the law, which is evaluated as often as needed
 * without. */
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

/* Which of `lanes` keep the limits; of the others the first that is broken is noted. */
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

/* Margins at q, to which a lane has come otherwise than by a step; returns which of `lanes` keep the limits. */
static mask mv_take_margins(mv_loop *l, mask lanes, const real *q)
{
    mv_margins(l, l->t, q, l->margin);
    return mv_allowed(l, lanes, l->margin);
}

/* Margins a little ahead of q along a slope. */
static void mv_margins_ahead(mv_loop *l, real h, const real *q, const real *slope, real *margin)
{
    real ahead[NQ];
    for (int i = 0; i < NQ; i++) ahead[i] = q[i] + K(AHEAD_PART) * h * slope[i];
    mv_margins(l, l->t, ahead, margin);
}

/* Which of `lanes` have a margin that may touch zero in the step q -> y: least the part of it where its tangent does. */
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

/* Which of `lanes` may keep the step q -> y of length h to `after`. The others are to try again as far as l->aim. */
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
    const mask again = AND(l->broken, AND(LT(tolerance, h), LT(tolerance, past * h)));
    l->held = SELECT(again, l->held * K(0.5), SPLAT(1)); /* the Illinois rule */
    l->aim = SELECT(again, mv_max(part * h, tolerance * K(0.5)), l->aim);
    l->h = SELECT(again, mv_min(l->h, l->aim), l->h); /* from where it grows: what is looked at ahead is near, too */
    l->again = again;
    return AND(lanes, NOT(again));
}

/* Lanes take a step, and end there where a limit is broken. */
static inline void mv_move_margins(mv_loop *l, mask taken)
{
    mv_blend(taken, l->margin, l->margin_end, LIMITS);
    l->aim = SELECT(taken, SPLAT(MV_INFINITY), l->aim);
    mv_halt(l, AND(taken, l->broken), MV_LIMIT);
}

#endif
