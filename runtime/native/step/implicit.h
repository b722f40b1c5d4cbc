/* SPDX-License-Identifier: Apache-2.0 */
/* Linearly implicit (Rosenbrock) steps: each stage solves one linear system, and all of a step have one matrix.
 *
 * With W = 1/(h gamma) - J, J the Jacobian where the step begins, the stages are
 *   W u_i = f(t + c_i h, q + sum_j a_ij u_j) + sum_j g_ij u_j / h + d_i h df/dt
 * and q + sum_j a_sj u_j + u_s is the end, u_s the estimate of its error. Before 1/h stands M, one but for algebraic
 * states, where it is zero: their f is zero at the end. Source: Hairer & Wanner, Solving Ordinary Differential Equations
 * II, 2nd ed., sections IV.7 and VI.3. */
#ifndef MEHVAR_IMPLICIT_H
#define MEHVAR_IMPLICIT_H

#include "control.h"

/* Pivots stand on the diagonal, in its order, so that lanes need no rows of their own. Those of h gamma W are one where
 * h is small, whatever the units of the coordinates; where one is smaller than this the step is tried again, shorter.
 * Own, not measured: a pivot this small makes rounding a thousand times larger, in the correction that J makes. Those of
 * algebraic states have any size, at any h: they must not be zero. */
#define LEAST_PIVOT 1e-3

/* Of the instant, for a difference of slopes in time: the root of the spacing of doubles, half of whose digits it keeps. */
#define TIME_STEP 1.5e-8

/* The Jacobian at (t, q). An entry that has no value, as on a kink, is taken for zero: the step is then of a low order,
 * which its error shows, and a short one passes. */
static inline void mv_jacobian(mv_loop *l)
{
    mv_refer(l, l->t);
    if (SAMPLED)
        mv_call_rhs_jac(&l->model, l->q, l->column + U_COLUMN, l->w);
    else
        mv_call_loop_jac(&l->model, l->q, l->r, l->w, l->w_r);
    for (int i = 0; i < NQ * NQ; i++) l->w[i] = SELECT0(EQ(l->w[i] - l->w[i], SPLAT(0)), l->w[i]);
}

/* A number that stands before the rate of state i: nothing, if that is algebraic. */
static inline real mv_under_mass(const mv_loop *l, int i, real number)
{
    return ALGEBRAIC ? l->mass[i] * number : number;
}

/* Put the factors of W in the place of J, with reciprocals on the diagonal. Returns the lanes that have them. */
static mask mv_factor(mv_loop *l, real h)
{
    real *const w = l->w;
    const real diagonal = K(1) / (h * K(GAMMA));
    mask good = mv_all();
    for (int i = 0; i < NQ * NQ; i++) w[i] = (i % (NQ + 1) ? SPLAT(0) : mv_under_mass(l, i / NQ, diagonal)) - w[i];
    for (int k = 0; k < NQ; k++) {
        good = AND(good, LE(K(LEAST_PIVOT) * mv_under_mass(l, k, diagonal), mv_fabs(w[k * NQ + k])));
        if (ALGEBRAIC) good = AND(good, NE(w[k * NQ + k], SPLAT(0)));
        w[k * NQ + k] = K(1) / w[k * NQ + k];
        for (int i = k + 1; i < NQ; i++) {
            if (!mv_any(NE(w[i * NQ + k], SPLAT(0)))) continue;
            w[i * NQ + k] *= w[k * NQ + k];
            for (int j = k + 1; j < NQ; j++) w[i * NQ + j] -= w[i * NQ + k] * w[k * NQ + j];
        }
    }
    return good;
}

static void mv_solve(const mv_loop *l, real *u)
{
    const real *const w = l->w;
    for (int i = 1; i < NQ; i++)
        for (int j = 0; j < i; j++) u[i] -= w[i * NQ + j] * u[j];
    for (int i = NQ - 1; i >= 0; i--) {
        for (int j = i + 1; j < NQ; j++) u[i] -= w[i * NQ + j] * u[j];
        u[i] *= w[i * NQ + i];
    }
}

/* Newton's method for algebraic states, when a law's input jumps: it ends where a correction is a tenth of the tolerance,
 * as the next would be its square, or after so many, as at the start of a run: far starts and double roots gain a bit a
 * step. What is left then the error control sees. */
#define NEWTON_STEPS 50
#define SETTLED 0.1

/* Let algebraic states be what their equations say; the others stay. In W their rows are then those of one. */
static void mv_settle(mv_loop *l)
{
    real *const u = l->k[1];
    mask open = l->alive;
    for (int step = 0; step < NEWTON_STEPS && mv_any(open); step++) {
        mv_slope(l, l->t, l->q, u);
        mv_jacobian(l);
        for (int i = 0; i < NQ * NQ; i++) l->w[i] = SELECT0(EQ(l->mass[i / NQ], SPLAT(0)), l->w[i]);
        for (int i = 0; i < NQ; i++) u[i] = SELECT0(EQ(l->mass[i], SPLAT(0)), u[i]);
        open = AND(open, mv_factor(l, SPLAT(1) / K(GAMMA)));
        mv_solve(l, u);
        open = AND(open, mv_finite(u, NQ));
        for (int i = 0; i < NQ; i++) l->q[i] = SELECT(open, l->q[i] + u[i], l->q[i]);
        open = AND(open, LT(K(SETTLED), mv_scaled_rms(l, u, l->q)));
    }
}

/* The change of the slope in time, where something in the loop depends on it. */
static void mv_slope_in_time(mv_loop *l, real *change)
{
    const real step = K(TIME_STEP) * mv_max(mv_fabs(l->t), SPLAT(1));
    mv_slope(l, l->t + step, l->q, change);
    for (int i = 0; i < NQ; i++) change[i] = (change[i] - l->k[0][i]) / step;
}

/* The stages k[1] ... and the end y of a step; no number where W has no factors. */
static void mv_implicit_stages(mv_loop *l, real h)
{
    const int timed = !SAMPLED && !REFERENCE_CONSTANT, stages = STAGES - 1;
    real *const in_time = l->k[STAGES];
    if (timed) mv_slope_in_time(l, in_time);
    mv_jacobian(l);
    const mask good = mv_factor(l, h);
    for (int s = 0; s < stages; s++) {
        real *const u = l->k[s + 1];
        mv_copy(l->stage, l->q, NQ);
        for (int j = 0; j < s; j++)
            for (int i = 0; i < NQ; i++) l->stage[i] += K(IMPLICIT_A(s, j)) * l->k[j + 1][i];
        if (s)
            mv_slope(l, l->t + K(IMPLICIT_C(s)) * h, l->stage, u);
        else
            mv_copy(u, l->k[0], NQ);
        for (int j = 0; j < s; j++)
            for (int i = 0; i < NQ; i++) u[i] += mv_under_mass(l, i, K(IMPLICIT_G(s, j)) / h) * l->k[j + 1][i];
        for (int i = 0; timed && i < NQ; i++) u[i] += K(IMPLICIT_D(s)) * h * in_time[i];
        mv_solve(l, u);
    }
    for (int i = 0; i < NQ; i++) l->y[i] = SELECT(good, l->stage[i] + l->k[stages][i], SPLAT(MV_NAN));
}

#endif
