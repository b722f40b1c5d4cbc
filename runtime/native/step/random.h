/* SPDX-License-Identifier: Apache-2.0 */
/* Randomness in the state: process noise over a step, and random steps at samples.
 *
 * The numbers of a step depend only on seed, run, number of the step and component. Source: Kloeden & Platen,
 * Numerical Solution of Stochastic Differential Equations, sections 10.2 (Euler and Maruyama) and 11.1 (Platen). */
#ifndef MEHVAR_RANDOM_H
#define MEHVAR_RANDOM_H

#include "noise.h"
#include "state.h"

/* Defined by the including file: the numbers of one sample or step. */
static void mv_draw(const mv_loop *l, enum mv_stream stream, int64_t index, int size, real *e);

/* Platen's terms of strong order one, without derivatives, for noise that commutes. For each process j: the change
 * of b from x to x + a h + b_j sqrt(h), times (dw_j dw - h e_j) / 2. These terms vanish if b does not depend on the
 * state. */
static void mv_add_platen(mv_loop *l, real h, real root, const real *dw)
{
    real along[WIENER + 1], support[NX], there[NX], here[NX];
    for (int j = 0; j < WIENER; j++) {
        for (int i = 0; i < WIENER; i++) along[i] = i == j ? root : SPLAT(0);
        mv_call_diffuse(&l->model, l->q, along, support);
        for (int i = 0; i < NX; i++) support[i] += l->q[i] + h * l->k[0][i];
        for (int i = 0; i < WIENER; i++) along[i] = K(0.5) * (dw[j] * dw[i] - (i == j ? h : SPLAT(0)));
        mv_call_diffuse(&l->model, support, along, there);
        mv_call_diffuse(&l->model, l->q, along, here);
        for (int i = 0; i < NX; i++) l->y[i] += (there[i] - here[i]) / root;
    }
}

/* Add process noise over the step q -> y of length h; k[0] is the slope at q. */
static void mv_diffuse(mv_loop *l, real h)
{
    real dw[WIENER + 1], change[NX];
    const real root = mv_sqrt(h);
    mv_draw(l, MV_OF_WIENER_PROCESSES, l->diffused++, WIENER, dw);
    for (int i = 0; i < WIENER; i++) dw[i] *= root;
    mv_call_diffuse(&l->model, l->q, dw, change);
    for (int i = 0; i < NX; i++) l->y[i] += change[i];
    if (STRONG) mv_add_platen(l, h, root, dw);
}

/* Apply the random step of the sample `evaluation` in the lanes that reached it. */
static void mv_jump(mv_loop *l, int64_t evaluation)
{
    real e[JUMP + 1], after[NX];
    mv_draw(l, MV_OF_RANDOM_STEPS, evaluation, JUMP - 1, e);
    mv_call_jump(&l->model, l->q, e, after);
    mv_blend(l->alive, l->q, after, NX);
}

#endif
