/* SPDX-License-Identifier: Apache-2.0 */
/* A model in an FMU of any version of the standard: values by reference, evaluation, time events, steps.
 *
 * Included after description.h, which mehvar writes for a model and an optional law: sizes FMU_NAME, first value reference
 * FMU_V_NAME of each group, fmu_start, and calls FMU_CALL_NAME. An instance is one structure, so that its state is a copy of
 * it. */
#ifndef MEHVAR_FMU_CORE_H
#define MEHVAR_FMU_CORE_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "single.c"

#include "values.h"

#include "fmu_refusals.h"

enum fmu_status { FMU_OK, FMU_DISCARD, FMU_ERROR };
enum fmu_mode { FMU_INSTANTIATED, FMU_INITIALIZING, FMU_EVENTS, FMU_CONTINUOUS, FMU_STEPPING, FMU_TERMINATED };

#define FMU_TICKS 4097   /* largest number per period of a sampled law, plus one */
#define FMU_RELATIVE 1e-9 /* tolerance of times: far above the rounding of importers, far below any step */
#define FMU_NULL "no place for a value, or none to take it from"
#define FMU_WORK ((int64_t)(sizeof(mv_work) / sizeof(double)) + 1 + (MV_STAGES + 4) * FMU_NQ + FMU_NR + 3 * FMU_NU + \
                  2 * FMU_NZ + FMU_NX + FMU_NY + 2 * FMU_NM + 9 * FMU_NV)

typedef void fmu_logger(void *instance, const char *message);

typedef struct {
    double v[FMU_VALUES];     /* by value reference */
    double noise[FMU_NE + 1], z[FMU_NZ + 1];
    double u[FMU_NU + 1];     /* input of a sampled law's last evaluation, as applied */
    double record[1 + FMU_NX + 2 * FMU_NU + FMU_NY + FMU_NZ];
    double t[FMU_TICKS + 2]; /* the last one is the duration of a run, for stalled events */
    double work[FMU_WORK];
    mv_single single;
    double start, stop, step, next_event;
    int64_t events;           /* evaluations of a sampled law so far */
    int32_t ticks, phase;     /* ticks in a period, and which one is next */
    int32_t mode, exchange, started, stale, changed, stop_defined, terminated;
    int32_t due;              /* a sampled law is evaluated at this instant, before time advances */
    int32_t watched, reset;   /* model exchange: sides are known; an event has changed the states */
    int32_t stalled;          /* events in a row without progress in time */
    double last_event;
    double guard[FMU_NV + 1], side[FMU_NV + 1], reach[FMU_NV + 1], zero[FMU_NV + 1]; /* see events.h */
    void *environment;
    fmu_logger *log;
} fmu_instance;

static void fmu_happened(mv_journal *journal, double t, int32_t event)
{
    (void)journal, (void)t, (void)event;
}

/* Set the addresses within an instance, after its creation or copy. */
static void fmu_link(fmu_instance *i)
{
    mv_single *s = &i->single;
    mv_model *m = &s->model;
    double *place = i->record;
    s->schedule.t = i->t;
    s->happened = fmu_happened;
    fmu_parameters(m, i->v);
    m->e = i->noise;
    s->q = i->v + FMU_V_Q;
    s->z = i->z;
    s->record_t = place, place += 1;
    s->record_x = place, place += FMU_NX;
    s->record_u = place, place += FMU_NU;
    s->record_u_cmd = place, place += FMU_NU;
    s->record_y = place, place += FMU_NY;
    s->record_z = place;
    if (i->started) {
        mv_work *w = (mv_work *)i->work;
        w->single = s;
        link_loop(&w->loop, s);
        divide(&w->loop, (double *)(w + 1));
    }
}

static void fmu_reset(fmu_instance *i)
{
    mv_single *s = &i->single;
    const int exchange = i->exchange;
    void *environment = i->environment;
    fmu_logger *log = i->log;
    memset(i, 0, sizeof *i);
    i->exchange = exchange, i->environment = environment, i->log = log;
    memcpy(i->v, fmu_start, sizeof fmu_start);
    i->mode = FMU_INSTANTIATED;
    i->stale = i->due = 1;
    s->schedule = (mv_schedule){0, FMU_TICKS + 2, 1, 1, FMU_MAX_STEPS, 0, FMU_RTOL, FMU_ATOL, 0.0};
    i->t[FMU_TICKS + 1] = FMU_DURATION;
    fmu_functions(&s->model);
    fmu_link(i);
}

static fmu_instance *fmu_new(int exchange, void *environment, fmu_logger *log)
{
    fmu_instance *i = calloc(1, sizeof *i);
    if (!i) return 0;
    i->exchange = exchange, i->environment = environment, i->log = log;
    fmu_reset(i);
    return i;
}

static enum fmu_status fmu_fail(fmu_instance *i, enum fmu_status status, const char *message)
{
    if (i->log) i->log(i, message);
    return status;
}

static int fmu_due(const fmu_instance *i) { return FMU_KIND == 2 && i->due; }

static void fmu_evaluate(fmu_instance *i)
{
    if (!i->stale) return;
    i->stale = 0;
    if (i->mode <= FMU_INITIALIZING) fmu_remember(&i->single.model, i->v);
    fmu_follow(&i->single.model, i->v, i->u, fmu_due(i));
}

#if FMU_KIND == 2
/* Evaluate a sampled law at its instant, in model exchange. */
static void fmu_sample(fmu_instance *i)
{
    double *v = i->v, z_next[FMU_NZ + 1];
    fmu_command(&i->single.model, v, i->u, v + FMU_V_U, z_next);
    memcpy(v + FMU_V_Z, z_next, FMU_NZ * sizeof(double));
    memcpy(i->u, v + FMU_V_U, FMU_NU * sizeof(double));
    i->due = 0;
    i->next_event = i->start + (double)++i->events * v[FMU_V_P + FMU_PERIOD];
    i->stale = 1;
}
#endif

/* End the initialization, or refuse it as a run would: for values out of bounds and violated constraints. */
static enum fmu_status fmu_begin(fmu_instance *i)
{
    const size_t states = FMU_NQ * sizeof(double), references = FMU_NR * sizeof(double);
    const int as_scenario = !memcmp(i->v + FMU_V_Q, fmu_start + FMU_V_Q, states) &&
                            !memcmp(i->v + FMU_V_R, fmu_start + FMU_V_R, references);
    char text[FMU_TEXT];
    for (int k = 0; k < FMU_VALUES; k++)
        if (fmu_class[k] != '-' && !(i->v[k] - i->v[k] == 0))
            return fmu_fail(i, FMU_ERROR, "a parameter, input or start is not a finite number");
    if (fmu_refuses(i->v, as_scenario, text)) return fmu_fail(i, FMU_ERROR, text);
    fmu_remember(&i->single.model, i->v);
    memcpy(i->z, i->v + FMU_V_Z, FMU_NZ * sizeof(double));
    i->next_event = i->start;
    i->last_event = -MV_INFINITY;
    i->events = i->watched = i->stalled = 0;
    i->stale = 1;
    i->mode = i->exchange ? FMU_EVENTS : FMU_STEPPING;
    return FMU_OK;
}

static int fmu_beyond(const fmu_instance *i, double t)
{
    return i->stop_defined && t > i->stop + FMU_RELATIVE * (fabs(i->stop) + fabs(t - i->start));
}

/* Return the common ticks of a communication step and a period; -1 if neither is a multiple of the other. */
static int fmu_divide(fmu_instance *i, double step)
{
    int inside = 1;
    i->ticks = 1;
#if FMU_KIND == 2
    const double period = i->v[FMU_V_P + FMU_PERIOD], larger = step > period ? step : period;
    const double ratio = larger / (step > period ? period : step), n = floor(ratio + 0.5);
    if (!(n < FMU_TICKS) || fabs(ratio - n) > FMU_RELATIVE * ratio) return -1;
    if (step > period) inside = (int)n;
    else i->ticks = (int32_t)n;
    i->single.schedule.hold_every = i->ticks;
#endif
    i->step = step;
    return inside;
}

/* Integrate from t to t + h with mehvar's integrator. */
static enum fmu_status fmu_step(fmu_instance *i, double t, double h)
{
    mv_single *s = &i->single;
    mv_work *w = (mv_work *)i->work;
    if (!(h > 0) || !(h < MV_INFINITY)) return fmu_fail(i, FMU_ERROR, "the communication step must be a number > 0");
    if (fabs(t - i->v[FMU_V_T]) > FMU_RELATIVE * (fabs(t) + h))
        return fmu_fail(i, FMU_ERROR, "the communication point is not where the last step ended");
    if (fmu_beyond(i, t + h)) return fmu_fail(i, FMU_ERROR, "the step goes past the stop time");
    if (i->terminated) return fmu_fail(i, FMU_ERROR, "the run has ended");
    if (FMU_KIND == 2 && i->started && fabs(h - i->step) > FMU_RELATIVE * i->step)
        return fmu_fail(i, FMU_ERROR, "communication steps of a sampled law must all be the same");
    const int inside = fmu_divide(i, h);
    if (inside < 0)
        return fmu_fail(i, FMU_ERROR, "the step must divide the law's period, or be a multiple of it");
    if (!i->started) {
        i->t[0] = t;
        i->started = 1;
        mv_start(s, w);
    }
    if (i->changed) w->loop.ready = 0;
    i->changed = 0;
    mv_call_reference(&w->loop.model, t, w->loop.r);
    for (int k = 0; k < inside && w->loop.alive; k++) {
        i->t[i->phase] = k ? t + h * k / inside : t;
        i->t[i->phase + 1] = t + h * (k + 1) / inside;
        w->loop.tick = i->phase;
        s->records = 0;
        mv_tick(&w->loop);
        i->phase = (i->phase + 1) % i->ticks;
    }
    i->v[FMU_V_T] = w->loop.alive ? t + h : w->loop.t;
#if FMU_KIND == 2
    i->due = i->phase == 0 && w->loop.alive;
    memcpy(i->u, w->loop.column + FMU_NX, FMU_NU * sizeof(double));
    memcpy(i->v + FMU_V_U, i->u, FMU_NU * sizeof(double));
    memcpy(i->v + FMU_V_Z, w->loop.column + FMU_NX + 2 * FMU_NU + FMU_NY, FMU_NZ * sizeof(double));
#endif
    i->stale = 1;
    if (w->loop.alive) return FMU_OK;
    i->terminated = 1;
    return fmu_fail(i, FMU_DISCARD, w->loop.status == MV_LIMIT        ? "a limit of the model is reached"
                                    : w->loop.status == MV_EVENT      ? "an event of the model ends the run"
                                    : w->loop.status == MV_FAILURE    ? "an event of the model ends the run as a failure"
                                    : w->loop.status == MV_CHATTERING ? "an event happens again and again"
                                                                      : "the integration cannot go on");
}

/* Return 1 if a value may be set now: inputs always, parameters and start values until the first step. In model exchange the
 * importer owns states and time, and CasADi sets them by reference. */
static int fmu_may_set(const fmu_instance *i, size_t reference)
{
    if (reference >= FMU_VALUES) return 0;
    if (fmu_class[reference] == 'i') return 1;
    if (i->exchange && (fmu_class[reference] == 's' || fmu_class[reference] == 't')) return 1;
    return (fmu_class[reference] == 'p' || fmu_class[reference] == 's') && i->mode <= FMU_INITIALIZING;
}

static enum fmu_status fmu_set(fmu_instance *i, const unsigned *references, size_t n, const double *values)
{
    if (n && !(references && values)) return fmu_fail(i, FMU_ERROR, FMU_NULL);
    for (size_t k = 0; k < n; k++)
        if (!fmu_may_set(i, references[k]))
            return fmu_fail(i, FMU_ERROR, "a value reference is unknown, or cannot be set now");
    for (size_t k = 0; k < n; k++) i->v[references[k]] = values[k];
    i->stale = i->changed = 1;
    return FMU_OK;
}

static enum fmu_status fmu_get(fmu_instance *i, const unsigned *references, size_t n, double *values)
{
    if (n && !(references && values)) return fmu_fail(i, FMU_ERROR, FMU_NULL);
    for (size_t k = 0; k < n; k++)
        if (references[k] >= FMU_VALUES) return fmu_fail(i, FMU_ERROR, "a value reference is unknown");
    fmu_evaluate(i);
    for (size_t k = 0; k < n; k++) values[k] = i->v[references[k]];
    return FMU_OK;
}

/* Of any value of the unit, see tangents.h. */
void fmu_tangents(const double *v, const double *applied, int due, int starts, const double *along, double *change);

/* Compute derivatives of rates and outputs along a change of states, inputs and parameters. */
static enum fmu_status fmu_directional(fmu_instance *i, const unsigned *unknowns, size_t nu, const unsigned *knowns,
                                       size_t nk, const double *seed, double *sensitivity)
{
    double along[FMU_VALUES] = {0}, change[FMU_VALUES];
    if ((nu && !(unknowns && sensitivity)) || (nk && !(knowns && seed))) return fmu_fail(i, FMU_ERROR, FMU_NULL);
    for (size_t k = 0; k < nk; k++) {
        if (knowns[k] >= FMU_VALUES || !strchr("pist", fmu_class[knowns[k]]))
            return fmu_fail(i, FMU_ERROR, "directional derivatives are by states, inputs and parameters");
        along[knowns[k]] += seed[k];
    }
    for (size_t k = 0; k < nu; k++)
        if (unknowns[k] >= FMU_VALUES || !strchr("do", fmu_class[unknowns[k]]))
            return fmu_fail(i, FMU_ERROR, "directional derivatives are those of state derivatives and outputs");
    fmu_evaluate(i);
    fmu_tangents(i->v, i->u, fmu_due(i), i->mode <= FMU_INITIALIZING, along, change);
    for (size_t k = 0; k < nu; k++) sensitivity[k] = change[unknowns[k]];
    return FMU_OK;
}

/* Copy an instance's state into another instance, without the data of its environment. */
static void fmu_copy(fmu_instance *to, const fmu_instance *from)
{
    void *environment = to->environment;
    fmu_logger *log = to->log;
    *to = *from;
    to->environment = environment, to->log = log;
    fmu_link(to);
}

/* Restore a deserialized state, whose addresses are those of another process. */
static void fmu_restore(fmu_instance *i)
{
    fmu_functions(&i->single.model);
    fmu_link(i);
}

/* Return 1 if a limit is violated, which ends the run. */
static int fmu_over(fmu_instance *i)
{
    fmu_evaluate(i);
    for (int k = 0; k < FMU_NM; k++)
        if (!(i->v[FMU_V_M + k] > 0)) return 1;
    return 0;
}

#if FMU_NV > 0
#define FMU_EVENT(e, k) fmu_events[3 * (e) + (k)]

/* Determine the sides of guards; for a guard of zero, the side to which the states move. */
static void fmu_sides(fmu_instance *i, double *side)
{
    double q[FMU_NQ], ahead[FMU_NV];
    const double *const v = i->v, *const g = v + FMU_V_G;
    fmu_evaluate(i);
    for (int k = 0; k < FMU_NQ; k++) q[k] = v[FMU_V_Q + k] + PROBE * FMU_STEP * v[FMU_V_D + k];
    fmu_guards(&i->single.model, v, q, ahead);
    for (int e = 0; e < FMU_NV; e++) {
        i->reach[e] = mv_max(i->reach[e], fabs(g[e]));
        const double at = fabs(g[e]) <= i->zero[e] ? ahead[e] : g[e];
        side[e] = (at > 0) - (at < 0);
    }
}

static int fmu_crosses(const fmu_instance *i, int e, double side)
{
    const int direction = FMU_EVENT(e, 0);
    return i->side[e] != 0 && side != 0 && side != i->side[e] && (!direction || i->side[e] * direction < 0);
}

/* Return 1 if a guard crossed zero in a step of the importer. */
static int fmu_watch(fmu_instance *i)
{
    double side[FMU_NV];
    int crosses = 0;
    fmu_sides(i, side);
    for (int e = 0; e < FMU_NV; e++) {
        if (fmu_crosses(i, e, side[e])) crosses = 1;
        else if (side[e] != 0) i->side[e] = side[e];
        if (fabs(i->v[FMU_V_G + e]) > i->zero[e]) i->zero[e] = 0;
    }
    return crosses;
}

/* Apply the resets of guards that crossed zero. */
static void fmu_cross(fmu_instance *i)
{
    double side[FMU_NV], x_next[FMU_NX];
    int some = 0;
    fmu_sides(i, side);
    memcpy(i->guard, i->v + FMU_V_G, sizeof side);
    for (int e = 0; e < FMU_NV && i->watched; e++) {
        if (!fmu_crosses(i, e, side[e])) continue;
        const double number = e;
        some = 1;
        i->zero[e] = RESTING * i->reach[e];
        i->side[e] = 0;
        i->guard[e] = MV_NAN; /* unequal to every value, so that its side is determined */
        if (FMU_EVENT(e, 2)) i->terminated = 1;
        if (!FMU_EVENT(e, 1)) continue;
        fmu_evaluate(i);
        i->single.model.resets(i->v + FMU_V_X, i->v + FMU_V_U, i->single.model.p, &number, x_next);
        memcpy(i->v + FMU_V_Q, x_next, sizeof x_next);
        i->reset = i->stale = 1;
    }
    if (!some) return;
    i->stalled = i->v[FMU_V_T] - i->last_event <= STALLED * FMU_DURATION ? i->stalled + 1 : 0;
    i->last_event = i->v[FMU_V_T];
    if (i->stalled >= CHATTERING) i->terminated = 1;
}

/* Update the sides of guards after a jump; a run on the forbidden side of an event ends. */
static void fmu_take_sides(fmu_instance *i)
{
    double side[FMU_NV];
    fmu_sides(i, side);
    for (int e = 0; e < FMU_NV; e++) {
        const int direction = FMU_EVENT(e, 0);
        if (i->watched && i->v[FMU_V_G + e] == i->guard[e]) continue;
        i->side[e] = side[e];
        if (FMU_EVENT(e, 2) && direction && side[e] * direction > 0) i->terminated = 1;
    }
    i->watched = 1;
}
#else
static int fmu_watch(fmu_instance *i) { return (void)i, 0; }
static void fmu_cross(fmu_instance *i) { (void)i; }
static void fmu_take_sides(fmu_instance *i) { (void)i; }
#endif

/* Handle an event in model exchange: crossed guards, then a sample. */
static void fmu_event(fmu_instance *i)
{
    i->reset = 0;
    fmu_cross(i);
#if FMU_KIND == 2
    if (i->v[FMU_V_T] >= i->next_event - FMU_RELATIVE * (fabs(i->v[FMU_V_T]) + i->v[FMU_V_P + FMU_PERIOD])) fmu_sample(i);
#endif
    fmu_take_sides(i);
    if (fmu_over(i)) i->terminated = 1;
}

#endif
