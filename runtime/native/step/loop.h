/* SPDX-License-Identifier: Apache-2.0 */
/* Closed loops tick by tick. */
#ifndef MEHVAR_LOOP_H
#define MEHVAR_LOOP_H

#include "step.h"

/* Defined by the including file: the use of a row of results, at a tick or at the instants at which lanes end. */
static void mv_record(mv_loop *l, mask lanes, int due);
static void mv_record_end(mv_loop *l, mask lanes);

/* Prepare the loop before the first tick; schedule, model and queue are set. */
static void mv_begin(mv_loop *l, mask alive)
{
    l->alive = alive;
    l->tick = l->evaluations = l->diffused = 0;
    l->bounded = mv_none();
    l->ready = l->started = 0;
    l->t = l->begin = l->end = SPLAT(l->schedule->t[0]);
    l->span = SPLAT(1);
    for (int lane = 0; lane < MEHVAR_LANES; lane++) l->next[lane] = 1, l->made[lane] = 0;
    l->coming = SPLAT(l->schedule->ticks > 1 ? l->schedule->t[1] : MV_INFINITY);
    l->waiting = l->h = l->error = l->steps = l->rejected = l->trials = l->status = SPLAT(0);
    l->reserve = SPLAT(1);
    l->violated = SPLAT(-1);
    l->stiff = l->smooth = SPLAT(0);
    l->t_stiff = SPLAT(MV_NAN);
    l->reach = SPLAT(MV_INFINITY);
    l->t_event = SPLAT(-MV_INFINITY);
    l->stalled = SPLAT(0);
    l->coarse = SPLAT(SURE);
    l->happens = l->broken = l->again = mv_none();
    l->aim = SPLAT(MV_INFINITY);
    l->held = SPLAT(1);
    for (int i = 0; i < COLUMNS; i++) l->column[i] = SPLAT(0);
    for (int i = 0; i < NU; i++) l->u_cmd[i] = SPLAT(0);
    for (int64_t i = 0; i < mv_queued(l->schedule) * NU; i++) l->queue[i] = SPLAT(0);
    mv_call_reference(&l->model, l->t, l->r);
    if (ALGEBRAIC) mv_call_mass(&l->model, l->mass);
}

/* Each input acts with the delay that the plant states, in evaluations after its command; it is zero before. */
static void mv_transport(mv_loop *l, int64_t evaluation, real *command)
{
    const int64_t depth = l->schedule->longest + 1;
    real *const ring = l->queue + l->schedule->delay * NU;
    real late[NU];
    mv_call_input_delays(&l->model, late);
    mv_copy(ring + evaluation % depth * NU, command, NU);
    for (int i = 0; i < NU; i++)
        for (int lane = 0; lane < MEHVAR_LANES; lane++)
            AT(command[i], lane) = AT(ring[(evaluation + depth - (int64_t)AT(late[i], lane)) % depth * NU + i], lane);
}

/* Append the law's input to the queue; the input of `delay` evaluations ago leaves it for the actuator. */
static void mv_apply(mv_loop *l, int64_t evaluation)
{
    const int32_t delay = l->schedule->delay;
    real command[NU];
    mv_copy(command, l->u_cmd, NU);
    if (delay) {
        real *place = l->queue + evaluation % delay * NU;
        mv_copy(command, place, NU);
        mv_copy(place, l->u_cmd, NU);
    }
    if (DELAYED && l->schedule->longest) mv_transport(l, evaluation, command);
    mv_call_actuate(&l->model, l->column, command, l->column + U_COLUMN);
}

static void mv_evaluate_law(mv_loop *l, int64_t evaluation)
{
    real x_seen[SEEN], e[NOISE + 1];
    mv_draw(l, MV_OF_MEASUREMENTS, evaluation, NOISE, e);
    mv_call_measure(&l->model, l->column, e, x_seen);
    mv_call_law(&l->model, x_seen, l->r, l->column + U_COLUMN, l->column + Z_COLUMN, l->u_cmd, l->z_next);
    mv_apply(l, evaluation);
}

static void mv_sample(mv_loop *l)
{
    const int64_t hold_every = l->schedule->hold_every;
    mv_refer(l, SPLAT(l->schedule->t[l->tick]));
    if (!SAMPLED) {
        if (PASSES) mv_between(l, l->schedule->t[l->tick], l->y);
        real *const q = PASSES ? l->y : l->q;
        mv_call_observe(&l->model, q, l->r, l->column, l->column + U_COLUMN, l->u_cmd);
        mv_copy(l->column + Z_COLUMN, mv_integrated(l, q), NZ);
        return;
    }
    mv_copy(l->column, l->q, NX);
    if (l->tick % hold_every == 0) mv_evaluate_law(l, l->tick / hold_every);
}

/* End lanes at the tick, although their steps may have gone beyond it. */
static void mv_end_at_tick(mv_loop *l, mask m, enum mv_status status)
{
    if (PASSES) {
        l->t = SELECT(m, SPLAT(l->schedule->t[l->tick]), l->t);
        mv_blend(m, l->q, l->y, NQ);
    }
    mv_retire(l, m, status);
}

/* Return the lanes that keep the limits at the tick. A continuous loop is checked after every step, and here if a
 * step has passed over the tick. */
static mask mv_good_at_tick(mv_loop *l)
{
    if (!LIMITS) return mv_all();
    if (SAMPLED) return mv_take_margins(l, l->alive, l->column);
    if (!PASSES) return mv_all();
    const mask over = AND(l->alive, LT(SPLAT(l->schedule->t[l->tick]), l->t));
    real margin[LIMITS + 1];
    mv_call_limits(&l->model, l->column, l->column + U_COLUMN, margin);
    return NOT(AND(over, NOT(mv_allowed(l, over, margin))));
}

static inline mask mv_finite_row(const mv_loop *l)
{
    return AND(mv_finite(l->column, NX), AND(mv_finite(l->u_cmd, NU), mv_finite(l->column + U_COLUMN, NU)));
}

static void mv_complete_row(mv_loop *l)
{
    mv_call_outputs(&l->model, l->column, l->column + U_COLUMN, l->r, l->column + Y_COLUMN);
    if (RECORDS_COMMAND) mv_copy(l->column + U_CMD_COLUMN, l->u_cmd, NU);
}

/* Record the lanes that end at or before the next tick, unless this is a sample or their numbers are not finite. */
static void mv_sample_end(mv_loop *l)
{
    const real coming = SPLAT(l->schedule->t[l->tick + 1]);
    const mask ended = AND(l->alive, AND(NE(l->status, SPLAT(MV_DONE)), LE(l->t, coming)));
    const int due = l->tick % l->schedule->record_every == 0; /* the tick, and with it who has not left it */
    const mask left = AND(ended, due ? LT(SPLAT(l->schedule->t[l->tick]), l->t) : mv_all());
    l->alive = AND(l->alive, NOT(ended));
    if (!mv_any(left)) return;
    mv_refer(l, l->t);
    if (SAMPLED) {
        mv_copy(l->column, l->q, NX);
    } else {
        mv_call_observe(&l->model, l->q, l->r, l->column, l->column + U_COLUMN, l->u_cmd);
        mv_copy(l->column + Z_COLUMN, mv_integrated(l, l->q), NZ);
    }
    mv_complete_row(l);
    mv_record_end(l, AND(left, mv_finite_row(l)));
}

static void mv_tick(mv_loop *l)
{
    const mv_schedule *s = l->schedule;
    const int last = l->tick + 1 == s->ticks, due = last || l->tick % s->record_every == 0;
    mv_sample(l);
    const mask finite = mv_finite_row(l);
    const mask good = AND(finite, mv_good_at_tick(l));
    const mask failed = AND(l->alive, NOT(good));
    const int fails = mv_any(failed);
    if (due || fails) {
        mv_complete_row(l);
        mv_record(l, due ? l->alive : failed, due);
    }
    if (fails) {
        l->violated = SELECT(AND(l->alive, NOT(finite)), SPLAT(-1), l->violated);
        mv_end_at_tick(l, AND(l->alive, NOT(finite)), MV_NOT_FINITE);
        mv_end_at_tick(l, AND(l->alive, NOT(good)), MV_LIMIT);
    }
    if (!last && mv_any(l->alive)) {
        if (SAMPLED && l->tick % s->hold_every == 0) mv_blend(l->alive, l->column + Z_COLUMN, l->z_next, NZ);
        mv_advance(l, s->t[l->tick + 1]);
        mv_sample_end(l);
        if (SAMPLED && JUMP && (l->tick + 1) % s->hold_every == 0) mv_jump(l, (l->tick + 1) / s->hold_every);
    }
    l->tick++;
}

#endif
