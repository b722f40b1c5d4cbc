/* SPDX-License-Identifier: Apache-2.0 */
/* A closed loop in each lane: in a single run there is one, in a batch there are as many as a vector has numbers.
 *
 * Included after a model under a law, which is
 *   mv_model and CALL_NAME           see calls.h
 *   NQ, NX, NU, NZ, NY, NR           numbers of coordinates, states, inputs, memory, outputs and references
 *   LIMITS, NOISE, SEEN              of the model's limits, of the noise of one measurement, and of what is measured
 *   STATE_LIMITS                     limits read no input, and the coordinates are the state
 *   SAMPLED                          the law is evaluated every so many ticks and its input held in between; the
 *                                    memory of any other law is the last NZ of the NQ coordinates
 *   REFERENCE_CONSTANT, PROJECTED    the reference does not depend on time; every step is put back on a manifold
 *   ALGEBRAIC                        there are algebraic states, whose slope is to be zero instead of their rate
 *   RECORDS_COMMAND                  the record holds what the law asks for beside what acts
 *   DELAYED                          inputs of the plant have delays of their own
 *   WIENER, JUMP, STRONG             number of Wiener processes; 0 or, with a random step, 1 and the number of its
 *                                    noise; whether the method is of strong order one, see random.h
 *   STAGES, ORDER                    of the method: slopes k[0] ... k[STAGES - 1], and k[STAGES] at the end of a step;
 *                                    the local error goes like step^ORDER, 0 for a fixed step
 *   ESTIMATED, END_IN_ERROR, THIRD   there is an error estimate; it needs the slope at the end; there is one of order
 *                                    three beside it (dop853)
 *   GAMMA, IMPLICIT_A(s, j) ...      of a linearly implicit method, see implicit.h; 0 of an explicit one
 *   EVENTS, EVENT(e, k)              of the model's events; of each its direction, whether it resets, an mv_ends
 *   STIFF_TEST                       a run ends where it is stiff to the method, dop853, see stiffness.h
 *   DENSE, SLOPES                    sums of the method's dense output, and how many slopes are in them; see dense.h
 *   REALS(a, n), ROWS(a, m, n)       declare a field for n numbers, and for m times n
 * In a batch they are constants, so that the compiler drops what a loop has no use for; in a single run they are read
 * from `l`, and one library serves all models. */
#ifndef MEHVAR_STATE_H
#define MEHVAR_STATE_H

#include "calls.h"
#include "schedule.h"

#define U_COLUMN NX
#define U_CMD_COLUMN (NX + NU)
#define Y_COLUMN (U_CMD_COLUMN + (RECORDS_COMMAND ? NU : 0))
#define Z_COLUMN (Y_COLUMN + NY)
#define COLUMNS (Z_COLUMN + NZ)

/* True if steps pass over ticks, where nothing changes but the record. With events, steps end at ticks, so that
 * guards are checked as often as a user samples. */
#define PASSES (DENSE && !SAMPLED && REFERENCE_CONSTANT && !EVENTS)
#define MOST_SLOPES (SLOPES > STAGES + 1 ? SLOPES : STAGES + 1)
#define ROWS_KEPT (PASSES ? (GAMMA ? 3 : 5) + DENSE : 0) /* of a step, see dense.h */
#define KEPT_SIZE (PASSES ? ROWS_KEPT * NQ + 3 : 0) /* numbers */
/* Bytes of a lane for steps with which it is ahead of the ticks, while other lanes with shorter steps catch up. Own.
 * In a block of eight lanes, runs of the triangle under `path` with gains from 0.3 to 0.7 take 10 660 slopes with this
 * value and 12 440 with half of it; alone a run takes 10 270. Twice as much is no faster. */
#define AHEAD (1 << 18)
#define MOST_KEPT (AHEAD / ((KEPT_SIZE + 1) * (int64_t)sizeof(scalar)) + 1)
#define KEPT (MEHVAR_LANES == 1 ? 1 : MOST_KEPT)

#if MEHVAR_LANES == 1
#define AT(v, lane) (v)
#else
#define AT(v, lane) ((v)[lane])
#endif

typedef struct {
    const mv_schedule *schedule;
    mv_model model;
    int64_t tick;              /* the next one */
    int64_t evaluations;       /* of the slope, in all lanes at once */
    int64_t diffused;          /* steps with process noise, which are the same in all lanes */
    mask alive;
    mask bounded;              /* the last trial was refused */
    int32_t ready, started;    /* k[0] is the slope at (t, q); h has been chosen */
    int64_t next[MEHVAR_LANES]; /* the first tick after t, */
    real coming;               /* and its instant; infinite after the last one */
    real t;                    /* of q; beyond `tick` where steps pass over ticks */
    real h;                    /* step proposed by the error control */
    real reserve;              /* of the last accepted step, see control.h */
    real error;                /* the largest estimate over its tolerance */
    real steps, rejected;
    real trials;               /* trial steps since the last tick */
    real stiff, smooth, t_stiff; /* stiff steps, steps since the last of them, and the time of the verdict; or NaN */
    real status, violated;     /* an mv_status, of a lane that is alive how it will end; index of the limit, or -1 */
    REALS(q, NQ);
    ROWS(k, MOST_SLOPES, NQ);  /* slopes at the stages, at the end of the step, and at stages of dense output */
    REALS(w, GAMMA ? NQ * NQ : 0); /* Jacobian, then the factors of its matrix */
    REALS(w_r, GAMMA ? NQ * NR : 0); /* Jacobian with respect to the references */
    REALS(mass, ALGEBRAIC ? NQ : 0); /* one, and zero of algebraic states */
    real begin, span, end;     /* of the step that has the last tick: instants, and the length of it */
    ROWS(dense, ROWS_KEPT, NQ);
    int64_t made[MEHVAR_LANES]; /* steps kept so far, */
    real waiting;              /* of which so many have ticks to come, in a ring: */
    scalar *kept;              /* for each lane, KEPT times instants and rows as in `dense` */
    REALS(margin, LIMITS);     /* at (t, q), see margins.h */
    REALS(margin_end, LIMITS); /* at the end of the trial */
    mask broken, again;        /* the trial breaks a limit; it is tried again */
    real aim;                  /* largest length of the next trial, up to a limit */
    real held;                 /* of the margin, by which a trial to a limit goes */
    REALS(guard, EVENTS);      /* at (t, q), see events.h */
    REALS(guard_end, EVENTS);  /* at the end of the trial */
    REALS(side, EVENTS);
    REALS(ahead, EVENTS);      /* the side at the end of the trial */
    REALS(resting, EVENTS);    /* the guard is zero at t */
    REALS(begins, EVENTS);     /* it was zero at the start */
    REALS(fires, EVENTS);      /* the event happens at the end of the trial */
    REALS(reaches, EVENTS);    /* the largest size of the guard in the trial */
    REALS(zero, EVENTS);       /* size below which the guard is zero after an event */
    REALS(noise, EVENTS);      /* below, a resting guard has no side: zero unless its state or itself is too coarse */
    mask happens;              /* some event happens at t */
    real reach;                /* largest length of the next trial, up to an event */
    real coarse;               /* doubled by each step to an event that did not reach it, see mv_located */
    real t_event, stalled;     /* time of the last event; number of events in a row without progress */
    REALS(y, NQ);
    REALS(stage, NQ);
    REALS(r, NR);
    REALS(u_cmd, NU);          /* command of the law */
    REALS(z_next, NZ);
    REALS(column, COLUMNS);    /* x, u, u_cmd if recorded, y, z: a row of the result */
    real *queue;               /* the inputs asked for in the last evaluations, rings: see mv_queued */
} mv_loop;

static inline mask mv_all(void) { return LT(SPLAT(0), SPLAT(1)); }

static inline mask mv_none(void) { return LT(SPLAT(0), SPLAT(0)); }

static inline int mv_any(mask m)
{
#if MEHVAR_LANES == 1
    return m;
#else
    mv_word any = 0; /* the words of a mask are ones or zeros: none is looked at on its own */
    for (int lane = 0; lane < MEHVAR_LANES; lane++) any |= (mv_word)m[lane];
    return any != 0;
#endif
}

static inline mask mv_finite(const real *v, int n)
{
    real zero = SPLAT(0);
    for (int i = 0; i < n; i++) zero += v[i] - v[i];
    return EQ(zero, SPLAT(0));
}

static inline void mv_blend(mask m, real *to, const real *from, int n)
{
    for (int i = 0; i < n; i++) to[i] = SELECT(m, from[i], to[i]);
}

static inline void mv_retire(mv_loop *l, mask m, enum mv_status status)
{
    l->status = SELECT(m, SPLAT(status), l->status);
    l->alive = AND(l->alive, NOT(m));
}

/* Memory of a continuous law, among the coordinates. */
static inline real *mv_integrated(const mv_loop *l, real *q) { (void)l; return q + (NQ - NZ); }

/* Project coordinates onto the manifold of the plant. */
static inline void mv_project(mv_loop *l, real *q, real *q_next)
{
    mv_call_project(&l->model, q, q_next);
    if (!SAMPLED) mv_copy(mv_integrated(l, q_next), mv_integrated(l, q), NZ);
}

static inline void mv_refer(mv_loop *l, real t)
{
    if (!REFERENCE_CONSTANT) mv_call_reference(&l->model, t, l->r);
}

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

#endif
