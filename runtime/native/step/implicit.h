/* SPDX-License-Identifier: Apache-2.0 */
/* Linearly implicit (Rosenbrock) steps: each stage solves one linear system; all stages of a step have the same
 * matrix.
 *
 * With W = 1/(h gamma) - J, where J is the Jacobian at the beginning of the step, the stages fulfil
 *   W u_i = f(t + c_i h, q + sum_j a_ij u_j) + sum_j g_ij u_j / h + d_i h df/dt
 * The end of the step is q + sum_j a_sj u_j + u_s, and u_s is the estimate of its error. A factor M multiplies 1/h:
 * one for ordinary states, zero for algebraic states, whose f is zero at the end. Source: Hairer & Wanner, Solving
 * Ordinary Differential Equations II, 2nd ed., sections IV.7 and VI.3. */
#ifndef MEHVAR_IMPLICIT_H
#define MEHVAR_IMPLICIT_H

#include "control.h"

/* Smallest pivot. Pivots are the diagonal entries in their order, so lanes need no individual row exchanges. The
 * pivots of h gamma W are one for small h, whatever the units of the coordinates. If a pivot is smaller than this,
 * the step is repeated with a smaller size. Own, not measured: such a pivot makes rounding in the correction by J a
 * thousand times larger. Pivots of algebraic states have any size at any h; they must not be zero. */
#define LEAST_PIVOT 1e-3

/* Relative step in time for a difference of slopes: the square root of the spacing of doubles keeps half of the
 * digits. */
#define TIME_STEP 1.5e-8

/* Jacobian at (t, q). An entry without a value, as at a kink, becomes zero. Then the order of the step is low; its
 * error estimate shows this, and a shorter step is accepted. */
static inline void mv_jacobian(mv_loop *l)
{
    mv_refer(l, l->t);
    if (SAMPLED)
        mv_call_rhs_jac(&l->model, l->q, l->column + U_COLUMN, l->w);
    else
        mv_call_loop_jac(&l->model, l->q, l->r, l->w, l->w_r);
    for (int i = 0; i < NQ * NQ; i++) l->w[i] = SELECT0(EQ(l->w[i] - l->w[i], SPLAT(0)), l->w[i]);
}

/* Factor of the rate of state i: zero for an algebraic state. */
static inline real mv_under_mass(const mv_loop *l, int i, real number)
{
    return ALGEBRAIC ? l->mass[i] * number : number;
}

/* Replace J by the factors of W, with reciprocals on the diagonal. Return the lanes for which this succeeds. */
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

/* Newton's method for algebraic states after a jump of the law's input. It ends when a correction is a tenth of the
 * tolerance, because the next one would be its square, or after a number of steps, as at the start of a run: distant
 * starts and double roots gain one bit per step. The error control detects a remaining error. */
#define NEWTON_STEPS 50
#define SETTLED 0.1

/* Solve for the algebraic states; the others stay. Their rows of W are those of the identity. */
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

/* Derivative of the slope by time, if something in the loop depends on time. */
static void mv_slope_in_time(mv_loop *l, real *change)
{
    const real step = K(TIME_STEP) * mv_max(mv_fabs(l->t), SPLAT(1));
    mv_slope(l, l->t + step, l->q, change);
    for (int i = 0; i < NQ; i++) change[i] = (change[i] - l->k[0][i]) / step;
}

/* Stages k[1] ... and end y of a step; NaN if W has no factors. */
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
