/* SPDX-License-Identifier: Apache-2.0 */
/* Events: steps end where a guard crosses zero, and resets change the state there.
 *
 * An accepted step is examined by the cubic through its ends with their slopes. If a guard crosses zero in its
 * direction on this cubic, the step is repeated up to the crossing, until the step itself ends past the crossing by
 * at most the tolerance. So the state at the event is the method's own; the cubic only leads to it. The cubic is
 * exact to second order at its ends, so two or three trials suffice. If the state or the guard is too coarse for the
 * tolerance, the trials become longer until one crosses.
 *
 * The side of a guard is its sign. It changes only by motion. If a guard is zero at the beginning of a step, after
 * an event or at the start of a run, it rests. A resting guard is divided by the elapsed time; the quotient has no
 * root at the beginning. The guard takes the side of its rate as soon as it exceeds its noise; the noise counts if
 * it kept an event from being located as accurately as others.
 *
 * An event with one direction that ends runs has a forbidden side: the side to which the event leads. If a lane gets
 * to this side without crossing (at the start, by a reset or by a jump of the input), it ends there too. */
#ifndef MEHVAR_EVENTS_H
#define MEHVAR_EVENTS_H

#include "control.h"

/* Defined by the including file: the effects of an event in some lanes. */
static void mv_happen(mv_loop *l, mask lanes, int event);

/* Tolerance of an event's location as a share of the step, in addition to two spacings of time. Own. In this part of
 * a step the state changes by less than the digits of its change over the step. Ten times as much would still be
 * small enough; a tenth is the rounding of the cubic. */
#define LOCATED 1e-13
/* Smallest spacing of time, as a share of the run. At the start of a run the spacing of doubles is 5e-324 s; no
 * method can divide by it. Own: far below the spacing at the end. */
#define LEAST 1e-20
/* Number of equidistant points at which a step is examined. Two crossings between two points are missed. Own. */
#define LOOKS 4
/* Share of a step over which the rate of a resting guard is taken: half of the digits of a double, as TIME_STEP. */
#define PROBE 1.5e-8
/* Share of a guard's size below which the guard is zero after an event. Own: far from the location tolerance 1e-13
 * and from meaningful values. */
#define RESTING 1e-9
/* Rate of a guard at a crossing, relative to its mean rate in a step; for a parabola from zero to zero the ratio is
 * four. Own. A guard counts as zero if it is below its change, at this rate, during the location tolerance. A guard
 * that is this near to its crossing crosses together with another one. A quarter of the value would lose the
 * smallest hops. */
#define STEEPEST 16
/* STALLED: two events that are closer than this share of the run make no progress. CHATTERING: the number of such
 * events in a row that end the run. Own. Impacts of a ball come closer until PROBE cannot separate them at about
 * 1e-14 s. With these values the run ends earlier if the ball keeps three hundredths of its speed; with a tenth of
 * STALLED, if it keeps ten hundredths; with twice CHATTERING, a fifth. */
#define STALLED 1e-9
#define CHATTERING 4
/* Initial value of `coarse`. A step to a root of the cubic sometimes misses the crossing; so as many misses are
 * allowed as this value has bits. Own: two or three are needed. Half or twice changes the last digits of the time of
 * one event in thousands. */
#define SURE 0.125
/* Distance before the end of a search at which the guard must not have crossed, as a share of the tolerance. Own: a
 * little less than the half that ends a search. */
#define CONFIRMED 0.45
/* Largest number of bisections or secant steps of a search, which needs about eight. */
#define SEARCHES 60

static inline void mv_guards(mv_loop *l, real t, const real *q, real *g)
{
    if (SAMPLED) {
        mv_call_guards(&l->model, q, l->column + U_COLUMN, g);
        return;
    }
    mv_refer(l, t);
    mv_call_loop_guards(&l->model, q, l->r, g);
}

/* Guards at a part of the step q -> y; resting guards are divided by that part. */
static void mv_guards_within(mv_loop *l, real h, real part, real *g)
{
    const real *const f0 = l->k[0], *const f1 = l->k[STAGES], rest = K(1) - part;
    for (int i = 0; i < NQ; i++) {
        const real change = l->y[i] - l->q[i];
        const real bend = rest * (h * f0[i] - change) + part * (change - h * f1[i]);
        l->stage[i] = rest * l->q[i] + part * l->y[i] + part * rest * bend;
    }
    mv_guards(l, l->t + part * h, l->stage, g);
    for (int e = 0; e < EVENTS; e++) g[e] = SELECT(LT(K(0), l->resting[e]), g[e] / part, g[e]);
}

static inline real mv_side(real g) { return SELECT(EQ(g, K(0)), SPLAT(0), mv_copysign(SPLAT(1), g)); }

/* Return how far past a crossing a step of length h may end. If this distance changes state or guard by less than a
 * spacing of doubles, steps to the crossing end before it again and again. Each of these steps doubles `coarse`, so
 * the event is found after a number of steps equal to the missing bits. Its error is the resolution of state and
 * guard. */
static inline real mv_located(const mv_loop *l, real h)
{
    const real least = SPLAT(LEAST * l->schedule->t[l->schedule->ticks - 1]);
    const real spacing = mv_max(mv_from_bits(mv_to_bits(l->t) + 1) - l->t, least);
    return mv_max(SPLAT(1), l->coarse) * (K(LOCATED) * h + K(2) * spacing);
}

static inline mask mv_counts(const mv_loop *l, int event, real side)
{
    const int direction = EVENT(event, 0);
    (void)l;
    return direction ? LT(side * K(direction), K(0)) : NE(side, K(0));
}

/* Return the part of the step at which a guard, `first` at `low` and `last` at `high`, has crossed: the upper end of
 * the last bracket. A secant misjudges a guard that is flat at its zero; so where a secant shows that the upper end is
 * near, a point before it must confirm this, or the interval is halved from then on. */
static real mv_search(mv_loop *l, real h, int event, mask lanes, real low, real high, real first, real last, real tolerance)
{
    const real side = mv_side(first);
    real g[EVENTS + 1], again = SPLAT(0);
    mask open = lanes, near = mv_none(), flat = mv_none();
    for (int k = 0; k < SEARCHES && mv_any(open); k++) {
        const real width = high - low, secant = high - width * last / (last - first) + tolerance * K(0.25);
        const mask inside = AND(AND(LT(low, secant), LT(secant, high)), NOT(flat));
        const real middle = low + K(0.5) * width, next = k < SEARCHES / 2 ? SELECT(inside, secant, middle) : middle;
        const real part = SELECT(near, high - K(CONFIRMED) * tolerance, next);
        mv_guards_within(l, h, part, g);
        const mask past = AND(open, NE(mv_side(g[event]), side)), before = AND(open, NOT(past));
        first = SELECT(AND(past, LT(K(0), again)), first * K(0.5), first); /* the Illinois rule */
        last = SELECT(AND(before, LT(again, K(0))), last * K(0.5), last);
        again = SELECT(past, SPLAT(1), SELECT(before, SPLAT(-1), again));
        high = SELECT(past, part, high);
        last = SELECT(past, g[event], last);
        low = SELECT(before, part, low);
        first = SELECT(before, g[event], first);
        const real overshoot = mv_fabs(last * (high - low) / (last - first));
        open = AND(open, LT(tolerance * K(0.5), high - low));
        flat = OR(flat, AND(near, past));
        near = AND(AND(past, NOT(flat)), LE(overshoot, tolerance * K(0.5)));
    }
    return high;
}

/* Return the side of a guard with the value `g` at a part of the step: zero while it rests within its noise. */
static inline real mv_side_from(const mv_loop *l, int event, real side, real part, real g)
{
    const mask still = AND(EQ(side, K(0)), LT(K(0), l->resting[event]));
    return SELECT(AND(still, LE(mv_fabs(g * part), l->noise[event])), SPLAT(0), mv_side(g));
}

/* Evaluate resting guards shortly after the beginning of the step, or later while they do not exceed their noise. */
static void mv_probe(mv_loop *l, real h, mask lanes, real *g)
{
    real later[EVENTS + 1];
    mask open[EVENTS + 1];
    mv_guards_within(l, h, SPLAT(PROBE), g);
    for (int e = 0; e < EVENTS; e++) open[e] = AND(AND(lanes, LT(K(0), l->resting[e])), NE(g[e], K(0)));
    for (double part = PROBE; part * LOOKS < 1; part *= 4) {
        mask some = mv_none();
        for (int e = 0; e < EVENTS; e++) {
            open[e] = AND(open[e], EQ(mv_side_from(l, e, SPLAT(0), SPLAT(part), g[e]), K(0)));
            some = OR(some, open[e]);
        }
        if (!mv_any(some)) return;
        mv_guards_within(l, h, SPLAT(part * 4), later);
        for (int e = 0; e < EVENTS; e++) g[e] = SELECT(open[e], later[e], g[e]);
    }
    for (int e = 0; e < EVENTS; e++) g[e] = SELECT(open[e], SPLAT(0), g[e]);
}

/* Return those of `lanes` with a crossing in the step q -> y, and its part of the step. Store in l->fires the guards
 * that cross there, in l->ahead the sides of the others at the end of the step, in l->guard_end the guards at the
 * end, and in l->reaches their largest size. */
static mask mv_root(mv_loop *l, real h, mask lanes, real tolerance, real *part)
{
    real g[EVENTS + 1], before[EVENTS + 1], low = SPLAT(0), high = SPLAT(1), first[EVENTS + 1], last[EVENTS + 1];
    mask crossed = mv_none(), at_once = mv_none();
    int rests = 0;
    for (int e = 0; e < EVENTS; e++) rests |= mv_any(AND(lanes, LT(K(0), l->resting[e])));
    if (rests) mv_probe(l, h, lanes, g);
    for (int e = 0; e < EVENTS; e++) {
        const mask resting = rests ? LT(K(0), l->resting[e]) : mv_none();
        const real side = l->side[e], goes = rests ? mv_side(g[e]) : side;
        const mask turned = AND(AND(lanes, resting), AND(NE(side, K(0)), AND(NE(goes, K(0)), NE(goes, side))));
        const mask now = AND(turned, mv_counts(l, e, side));
        at_once = OR(at_once, now);
        l->fires[e] = SELECT0(now, SPLAT(1));
        l->ahead[e] = SELECT(AND(AND(resting, NE(goes, K(0))), NOT(now)), goes, side);
        l->reaches[e] = mv_fabs(l->guard[e]);
        before[e] = rests ? SELECT(resting, g[e], l->guard[e]) : l->guard[e];
        first[e] = last[e] = before[e];
    }
    crossed = at_once;
    for (int look = 1; look <= LOOKS; look++) {
        mask here = mv_none();
        mv_guards_within(l, h, SPLAT((double)look / LOOKS), g);
        for (int e = 0; e < EVENTS; e++) {
            const real side = l->ahead[e], now = mv_side_from(l, e, side, SPLAT((double)look / LOOKS), g[e]);
            l->reaches[e] = mv_max(l->reaches[e], mv_fabs(g[e]));
            const mask open = AND(lanes, NOT(crossed)), rests_on = AND(LT(K(0), l->resting[e]), EQ(now, K(0)));
            const mask flips = AND(AND(open, NOT(rests_on)), AND(NE(side, K(0)), NE(now, side)));
            const mask counts = AND(flips, mv_counts(l, e, side));
            here = OR(here, counts);
            l->fires[e] = SELECT(counts, SPLAT(1), l->fires[e]);
            first[e] = SELECT(open, before[e], first[e]);
            last[e] = SELECT(open, g[e], last[e]);
            const real other = SELECT(EQ(now, K(0)), SPLAT(0) - side, now);
            l->ahead[e] = SELECT(AND(flips, NOT(counts)), other, SELECT(AND(open, EQ(side, K(0))), now, side));
            before[e] = g[e];
        }
        low = SELECT(here, SPLAT((double)(look - 1) / LOOKS), low);
        high = SELECT(here, SPLAT((double)look / LOOKS), high);
        crossed = OR(crossed, here);
    }
    mv_copy(l->guard_end, g, EVENTS); /* divided by one for resting guards */
    *part = SELECT(at_once, SPLAT(0), high);
    for (int e = 0; e < EVENTS; e++) {
        const mask searched = AND(AND(crossed, NOT(at_once)), LT(K(0), l->fires[e]));
        if (!mv_any(searched)) continue;
        const real root = mv_search(l, h, e, searched, low, high, first[e], last[e], tolerance / h);
        *part = SELECT(searched, mv_min(*part, root), *part);
    }
    return crossed;
}

/* Of the lanes `open` that tried a step of length h and may accept it, return those without an event before its end.
 * The others repeat the step up to l->reach. l->fires has the events at the end. */
static mask mv_watch(mv_loop *l, real h, mask open, mask lanes)
{
    const real tolerance = mv_located(l, h);
    real part;
    const mask crossed = mv_root(l, h, lanes, tolerance, &part);
    const mask early = AND(crossed, LT(tolerance, h - part * h)), aimed = LT(l->reach, SPLAT(MV_INFINITY));
    const mask moves = AND(lanes, NOT(early)), misses = AND(aimed, NOT(crossed));
    const mask rough = LT(K(1), l->coarse);
    l->coarse = SELECT(moves, SELECT(misses, l->coarse * K(2), SPLAT(SURE)), l->coarse);
    const real least = mv_located(l, mv_max(part, SPLAT(PROBE)) * h), reach = mv_max(part * h + K(0.5) * least, least);
    l->reach = SELECT(early, reach, SELECT(open, SPLAT(MV_INFINITY), l->reach));
    mv_halt(l, AND(lanes, NOT(mv_finite(l->guard_end, EVENTS))), MV_NOT_FINITE);
    const mask happens = AND(crossed, NOT(early));
    for (int e = 0; e < EVENTS; e++) {
        const real side = l->ahead[e], now = mv_fabs(l->guard_end[e]), past = mv_min(K(STEEPEST) * tolerance / h, SPLAT(1));
        const mask stays = AND(EQ(l->resting[e], K(0)), EQ(side, l->side[e]));
        const mask near = AND(stays, LE(now, past * (mv_fabs(l->guard[e]) - now)));
        const mask fires = AND(happens, OR(LT(K(0), l->fires[e]), AND(near, mv_counts(l, e, side))));
        l->fires[e] = SELECT0(fires, SPLAT(1));
        const mask still = AND(AND(LT(K(0), l->resting[e]), EQ(side, K(0))), NOT(fires));
        l->zero[e] = SELECT(fires, mv_max(l->reaches[e] * (K(RESTING) + past), now), K(RESTING) * now);
        l->noise[e] = SELECT(AND(moves, NOT(still)), SELECT0(AND(fires, rough), l->zero[e]), l->noise[e]);
        l->side[e] = SELECT(moves, SELECT(fires, SPLAT(0), side), l->side[e]);
        l->guard[e] = SELECT(moves, l->guard_end[e], l->guard[e]);
        l->resting[e] = SELECT(moves, SELECT0(OR(still, EQ(l->guard_end[e], K(0))), SPLAT(1)), l->resting[e]);
    }
    l->happens = happens;
    return AND(lanes, NOT(early));
}

/* End `lanes` by an event that happens there. `begins` marks lanes at their start, where only an event declared as
 * success is no failure. */
static void mv_end_by(mv_loop *l, mask lanes, int event, int begins)
{
    const int ends = EVENT(event, 2), fails = ends == MV_FAILS || (begins && ends == MV_ENDS);
    if (fails) mv_halt(l, lanes, MV_FAILURE);
    else if (ends) mv_halt(l, AND(lanes, NE(l->status, SPLAT(MV_FAILURE))), MV_EVENT);
}

/* End those of `lanes` that are on the forbidden side of an event. */
static void mv_end_past(mv_loop *l, mask lanes, int event, int begins)
{
    const int direction = EVENT(event, 0);
    if (!EVENT(event, 2) || !direction) return;
    const mask past = AND(lanes, LT(K(0), l->side[event] * K(direction)));
    if (!mv_any(past)) return;
    mv_happen(l, past, event);
    mv_end_by(l, past, event, begins);
}

/* Evaluate guards, and set sides that changed without motion: before the first step, and after a jump of the input. */
static void mv_take_sides(mv_loop *l)
{
    real g[EVENTS + 1];
    mv_guards(l, l->t, l->q, g);
    for (int e = 0; e < EVENTS; e++) {
        const mask same = l->started ? EQ(g[e], l->guard[e]) : mv_none();
        l->side[e] = SELECT(same, l->side[e], mv_side(g[e]));
        l->resting[e] = SELECT(same, l->resting[e], SELECT0(EQ(g[e], K(0)), SPLAT(1)));
        l->noise[e] = SELECT0(AND(same, NE(g[e], K(0))), l->noise[e]);
        l->guard[e] = g[e];
        if (l->started) continue;
        l->begins[e] = l->resting[e];
        if (EVENT(e, 2) && EVENT(e, 0))
            l->side[e] = SELECT(EQ(g[e], K(0)), SPLAT(-EVENT(e, 0)), l->side[e]); /* may happen at once */
    }
    mv_halt(l, AND(l->alive, NOT(mv_finite(g, EVENTS))), MV_NOT_FINITE);
    const mask going = mv_going(l);
    for (int e = 0; e < EVENTS; e++) mv_end_past(l, going, e, !l->started);
}

static mask mv_reset(mv_loop *l)
{
    real x[NX], u[NU], u_cmd[NU], x_next[NX];
    mask reset = mv_none();
    for (int e = 0; e < EVENTS; e++) {
        const mask lanes = AND(l->happens, LT(K(0), l->fires[e]));
        if (!mv_any(lanes)) continue;
        const mask soon = LE(l->t, K(STALLED * l->schedule->t[l->schedule->ticks - 1]));
        const mask begins = EVENT(e, 2) && EVENT(e, 0) ? AND(lanes, AND(soon, LT(K(0), l->begins[e]))) : mv_none();
        l->t = SELECT(begins, SPLAT(0), l->t);
        mv_happen(l, lanes, e);
        mv_end_by(l, begins, e, 1);
        mv_end_by(l, AND(lanes, NOT(begins)), e, 0);
        if (!EVENT(e, 1)) continue;
        if (SAMPLED) {
            mv_copy(x, l->q, NX);
            mv_copy(u, l->column + U_COLUMN, NU);
        } else {
            mv_refer(l, l->t);
            mv_call_observe(&l->model, l->q, l->r, x, u, u_cmd);
        }
        mv_call_resets(&l->model, x, u, SPLAT(e), x_next);
        mv_blend(lanes, l->q, x_next, NQ < NX ? NQ : NX); /* equal numbers: charts have no resets */
        reset = OR(reset, lanes);
    }
    return reset;
}

/* Return the length of the next trial: h, or less if the last trial showed an event. Fixed steps end at the same
 * instants as without events, at whole steps from `start`; a lane returns to these. `last` marks lanes that reach
 * the target, which is `room` away. */
static real mv_towards_event(const mv_loop *l, real start, real room, real h, mask *last)
{
    if (!ORDER) {
        const real whole = mv_floor((l->t - start) / l->h + K(RESTING)) + SPLAT(1);
        h = SELECT(*last, room, start + whole * l->h - l->t);
    }
    const mask shown = LT(l->reach, SPLAT(MV_INFINITY));
    *last = OR(AND(shown, LE(room, l->reach)), AND(NOT(shown), *last));
    return SELECT(shown, mv_min(room, l->reach), h);
}

/* Apply the events at the ends of steps, and restart after them; `room` is left before the next stop. */
static void mv_fire(mv_loop *l, real room)
{
    const mask happens = l->happens;
    if (!mv_any(happens)) return;
    const mask reset = mv_reset(l), going = AND(happens, mv_going(l));
    l->happens = mv_none();
    real g[EVENTS + 1];
    mv_guards(l, l->t, l->q, g);
    for (int e = 0; e < EVENTS; e++) {
        const mask other = AND(happens, OR(NE(g[e], l->guard[e]), LT(K(0), l->fires[e])));
        const mask resting = LE(mv_fabs(g[e]), l->zero[e]);
        l->side[e] = SELECT(AND(other, NOT(resting)), mv_side(g[e]), l->side[e]);
        l->resting[e] = SELECT(other, SELECT0(resting, SPLAT(1)), l->resting[e]);
        l->guard[e] = SELECT(happens, g[e], l->guard[e]);
        mv_end_past(l, AND(going, AND(other, NOT(resting))), e, 0);
    }
    if (mv_any(reset)) {
        mv_slope(l, l->t, l->q, l->y);
        mv_blend(reset, l->k[0], l->y, NQ);
        mv_halt(l, AND(reset, NOT(mv_finite(l->k[0], NQ))), MV_NOT_FINITE);
        if (ORDER) l->h = SELECT(AND(reset, LT(K(0), room)), mv_first_step(l, room), l->h);
    }
    l->reserve = SELECT(happens, SPLAT(1), l->reserve);
    const mask stalled = AND(happens, LE(l->t - l->t_event, K(STALLED * l->schedule->t[l->schedule->ticks - 1])));
    l->stalled = SELECT(stalled, l->stalled + SPLAT(1), SELECT(happens, SPLAT(0), l->stalled));
    l->t_event = SELECT(happens, l->t, l->t_event);
    mv_halt(l, AND(happens, LE(SPLAT(CHATTERING), l->stalled)), MV_CHATTERING);
}

#endif
