/* SPDX-License-Identifier: Apache-2.0 */
/* Test whether stability, not error, limits the steps of a run. If so, the run ends, and the caller repeats it with
 * an implicit method. The test is that of the code dop853 in Hairer, Norsett & Wanner, Solving Ordinary Differential
 * Equations II, 2nd ed., section IV.2. The last stage and the end of a step belong to the same instant. So the
 * difference of their slopes, divided by the difference of their states, is about the largest eigenvalue. */
#ifndef MEHVAR_STIFFNESS_H
#define MEHVAR_STIFFNESS_H

#include "state.h"

/* Largest h times eigenvalue in the stable region of dop853 on the real axis. For slosh under `lyapunov-v2` at 1e-6,
 * where stability limits the steps, the product is between 6.37 and 6.41 in eight steps of ten. Source: dop853. With
 * half the value, the triangle counts as stiff at tolerances ten to a hundred times tighter, which is wrong; with
 * twice the value, slosh never counts as stiff. */
#define STABLE_PIECE 6.1
/* STIFF_STEPS: number of steps beyond this bound after which a run is stiff. SMOOTH_STEPS: number of steps in a row
 * below the bound that reset the count. Source: dop853. With STIFF_STEPS, slosh at 1e-6 is found stiff after 1.8 s;
 * with half after 1.1 s, with twice after 3.2 s. Half also finds the triangle under `sliding` stiff at 1e-8, for a
 * few steps at its end. With half SMOOTH_STEPS, slosh at 1e-11 is found after 22 s instead of 4; twice changes
 * nothing. */
#define STIFF_STEPS 15
#define SMOOTH_STEPS 6

/* Test the step of length h to y in the lanes that took it to the instant `after`; `last` is the state of its last
 * stage. */
static inline void mv_test_stiffness(mv_loop *l, real h, const real *last, mask taken, real after)
{
    real slopes = SPLAT(0), places = SPLAT(0);
    for (int i = 0; i < NQ; i++) {
        const real slope = l->k[STAGES][i] - l->k[STAGES - 1][i], place = l->y[i] - last[i];
        slopes += slope * slope;
        places += place * place;
    }
    const mask beyond = AND(taken, LT(K(STABLE_PIECE * STABLE_PIECE) * places, h * h * slopes));
    l->stiff += SELECT0(beyond, SPLAT(1));
    l->smooth = SELECT(beyond, SPLAT(0), l->smooth + SELECT0(taken, SPLAT(1)));
    l->stiff = SELECT(LE(SPLAT(SMOOTH_STEPS), l->smooth), SPLAT(0), l->stiff);
    const mask stiff = AND(taken, LE(SPLAT(STIFF_STEPS), l->stiff));
    l->t_stiff = SELECT(stiff, after, l->t_stiff);
    l->alive = AND(l->alive, NOT(stiff));
}

#endif
