/* SPDX-License-Identifier: Apache-2.0 */
/* Explicit Runge-Kutta steps with exact stops, in every lane with a step of its own. No allocation, no shared state. */
#ifndef MEHVAR_STEP_H
#define MEHVAR_STEP_H

#include "control.h"

/* Defined by whoever includes this: the slopes k[1] ... and the end y of a step. */
static inline void mv_stages(mv_loop *l, real h);

/* A step that would nearly reach the target is stretched to it, as a sliver costs as much as a step. From 1 to 1.1:
 * less than one percent. Source and measurement as in control.h. */
#define STRETCH 1.01
/* Of one step of rk4: an interval that is a whole number of steps but for its rounding gets no step more. Own; the
 * quotient is rounded to 2e-16, so that a half or twice changes nothing. */
#define SLACK 1e-12

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
    const real target = SPLAT(goal), start = l->t;
    mv_prepare_steps(l, target);
    mask open = l->alive, bounded = mv_none();
    for (int64_t trial = 0; mv_any(open); trial++) {
        if (trial == l->schedule->max_steps) {
            mv_retire(l, open, MV_TOO_MANY_STEPS);
            return;
        }
        const real room = target - l->t;
        const mask last = LE(room, K(STRETCH) * l->h);
        const real h = ORDER ? SELECT(last, room, l->h) : l->h;
        real ratio;
        const mask taken = mv_trial(l, target, h, open, last, &ratio), refused = AND(open, NOT(taken));
        if (ORDER)
            mv_control(l, h, ratio, taken, refused, bounded);
        else
            mv_retire(l, refused, MV_NOT_FINITE);
        bounded = refused;
        if (!ORDER) l->t = SELECT(AND(taken, NOT(last)), start + K(trial + 1) * h, l->t); /* counted, not added up */
        mv_check_limits(l, taken);
        open = AND(l->alive, LT(l->t, target));
    }
}

#endif
