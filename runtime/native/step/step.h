/* SPDX-License-Identifier: Apache-2.0 */
/* Explicit Runge-Kutta steps with exact stops; each lane has its own step. No allocation, no shared state. */
#ifndef MEHVAR_STEP_H
#define MEHVAR_STEP_H

#include "control.h"
#include "dense.h"
#include "events.h"
#include "implicit.h"
#include "margins.h"
#include "random.h"
#include "stiffness.h"

/* Defined by the including file: the slopes k[1] ... and the end y of an explicit step. */
static inline void mv_stages(mv_loop *l, real h);

/* A step that would nearly reach the target is stretched to it, because a very short step costs as much as a long
 * one. A value from 1 to 1.1 changes less than one percent. Source and measurement as in control.h. */
#define STRETCH 1.01
/* Share of a step of rk4: an interval that is a whole number of steps up to rounding gets no extra step. Own; the
 * quotient is rounded to 2e-16, so half or twice changes nothing. */
#define SLACK 1e-12

/* Return those of `lanes` that pass over a tick or reach one, with a step to the instant `after`. */
static mask mv_ticked(mv_loop *l, mask lanes, real after)
{
    const mv_schedule *s = l->schedule;
    const mask ticked = AND(lanes, LE(l->coming, after));
    if (!mv_any(ticked)) return ticked;
    const real moving = SELECT0(ticked, SPLAT(1));
    for (int lane = 0; lane < MEHVAR_LANES; lane++) {
        if (!AT(moving, lane)) continue;
        while (l->next[lane] < s->ticks && s->t[l->next[lane]] <= AT(after, lane)) l->next[lane]++;
        AT(l->coming, lane) = l->next[lane] < s->ticks ? s->t[l->next[lane]] : MV_INFINITY;
    }
    return ticked;
}

/* Try one step of the lanes `open`; `last` marks those that reach the target with it. Return those that accepted it. */
static mask mv_trial(mv_loop *l, real target, real h, mask open, mask last, real *ratio)
{
    real *end = l->k[STAGES], last_stage[NQ];
    /* if the slope at the end is that of the next step, or leads to events */
    const mask goes_on = SAMPLED && !EVENTS ? NOT(last) : mv_all();
    if (GAMMA) mv_implicit_stages(l, h);
    else mv_stages(l, h);
    if (STIFF_TEST) mv_copy(last_stage, l->stage, NQ);
    if (WIENER) mv_diffuse(l, h);
    mask good = mv_finite(l->y, NQ);
    if (END_IN_ERROR) {
        mv_slope(l, l->t + h, l->y, end);
        good = AND(good, OR(NOT(goes_on), mv_finite(end, NQ)));
    }
    *ratio = SELECT(good, ESTIMATED ? mv_error_ratio(l, h) : SPLAT(0), SPLAT(MV_NAN));
    mask taken = AND(open, ORDER ? LE(*ratio, K(1)) : good);
    if (PROJECTED) {
        mv_project(l, l->y, l->stage);
        mv_copy(l->y, l->stage, NQ);
    }
    if ((PROJECTED || !END_IN_ERROR) && mv_any(AND(taken, goes_on))) {
        mv_slope(l, PROJECTED ? SELECT(last, target, l->t + h) : l->t + h, l->y, end);
        const mask broken = AND(AND(taken, goes_on), NOT(mv_finite(end, NQ)));
        *ratio = SELECT(broken, SPLAT(MV_NAN), *ratio);
        taken = AND(taken, NOT(broken));
    }
    const real after = SELECT(last, target, l->t + h);
    if (LIMITS) taken = mv_within_limits(l, h, after, taken);
    if (EVENTS) taken = mv_watch(l, h, open, taken);
    l->trials += SELECT0(open, SPLAT(1));
    if (PASSES) {
        real sums[DENSE + !DENSE][NQ];
        taken = AND(taken, mv_between_good(l, h, AND(taken, LT(l->coming, after)), ratio, sums));
        const mask ticked = mv_ticked(l, taken, after);
        l->trials = SELECT(ticked, SPLAT(0), l->trials);
        if (mv_any(ticked)) mv_keep_step(l, h, after, ticked, sums);
    }
    if (STIFF_TEST) mv_test_stiffness(l, h, last_stage, AND(taken, goes_on), after);
    if (LIMITS) mv_move_margins(l, taken);
    l->t = SELECT(taken, after, l->t);
    mv_blend(taken, l->q, l->y, NQ);
    mv_blend(taken, l->k[0], end, NQ);
    l->steps += SELECT0(taken, SPLAT(1));
    l->rejected += SELECT0(AND(open, NOT(taken)), SPLAT(1));
    l->error = SELECT(taken, mv_max(l->error, *ratio), l->error);
    return taken;
}

/* Prepare the first trial step from t to the target. */
static inline void mv_prepare_steps(mv_loop *l, real target)
{
    if (SAMPLED) mv_hold(&l->model, l->column + U_COLUMN);
    if (SAMPLED && ALGEBRAIC) mv_settle(l);
    if (!PASSES) l->trials = SPLAT(0);
    if (EVENTS && (SAMPLED || !l->started)) mv_take_sides(l);
    if (l->ready) return;
    mv_slope(l, l->t, l->q, l->k[0]);
    if (LIMITS && !SAMPLED && !l->started) mv_halt(l, AND(mv_going(l), NOT(mv_take_margins(l, l->alive, l->q))), MV_LIMIT);
    l->ready = !SAMPLED;
    mv_halt(l, AND(mv_going(l), NOT(mv_finite(l->k[0], NQ))), MV_NOT_FINITE);
    if (ORDER && !l->started) l->h = mv_first_step(l, target - l->t);
    l->started = 1;
}

/* Lanes that must take a step before the tick. */
static inline mask mv_behind(const mv_loop *l, real tick)
{
    return AND(mv_going(l), LT(l->t, tick));
}

/* Lanes that may take a step while others must. */
static inline mask mv_free(const mv_loop *l, real end)
{
    return PASSES ? AND(mv_behind(l, end), LT(l->waiting, K(KEPT))) : mv_behind(l, end);
}

/* Integrate all live lanes to a tick, or beyond it if steps pass over ticks, but never beyond the last one. Lanes
 * that cannot get there stay where they are; mv_sample_end retires them. */
static void mv_advance(mv_loop *l, double t_tick)
{
    const mv_schedule *s = l->schedule;
    const real tick = SPLAT(t_tick), end = SPLAT(PASSES ? s->t[s->ticks - 1] : t_tick), start = l->t;
    mv_prepare_steps(l, end);
    if (!ORDER) l->h = (end - l->t) / mv_ceil((end - l->t) / K(s->step) * K(1 - SLACK));
    for (int64_t trial = 0; mv_any(mv_behind(l, tick)); trial++) {
        const mask open = mv_free(l, end);
        const real target = end, room = target - l->t;
        mask last = LE(room, K(STRETCH) * l->h);
        real h = ORDER ? SELECT(last, room, l->h) : l->h;
        if (EVENTS) h = mv_towards_event(l, start, room, h, &last);
        if (LIMITS) {
            last = AND(last, LE(room, l->aim));
            h = mv_min(h, l->aim);
        }
        real ratio;
        const mask taken = mv_trial(l, target, h, open, last, &ratio);
        const mask led = OR(EVENTS ? LT(l->reach, SPLAT(MV_INFINITY)) : mv_none(), LIMITS ? l->again : mv_none());
        const mask refused = AND(AND(open, NOT(taken)), NOT(led));
        if (ORDER)
            mv_control(l, h, ratio, taken, refused);
        else
            mv_halt(l, refused, MV_NOT_FINITE);
        if (!ORDER && !EVENTS) l->t = SELECT(AND(taken, NOT(last)), start + K(trial + 1) * h, l->t); /* counted, not added up */
        if (EVENTS) {
            const mask happens = l->happens;
            mv_fire(l, target - l->t);
            const mask going = AND(happens, mv_going(l));
            if (LIMITS && mv_any(going)) mv_halt(l, AND(going, NOT(mv_take_margins(l, going, l->q))), MV_LIMIT);
        }
        mv_halt(l, AND(mv_behind(l, end), LE(SPLAT(s->max_steps), l->trials)), MV_TOO_MANY_STEPS);
    }
}

#endif
