/* SPDX-License-Identifier: Apache-2.0 */
/* Whether stability and not error holds the steps of a run: then it ends, for somebody to make it again by a method that
 * this does not hold. The test of the code dop853 of Hairer, Norsett & Wanner, Solving Ordinary Differential Equations II,
 * 2nd ed., section IV.2: the last stage is at the end of the step, as the end is, so that the difference of the slopes
 * there over that of the places is about the largest eigenvalue. */
#ifndef MEHVAR_STIFFNESS_H
#define MEHVAR_STIFFNESS_H

#include "state.h"

/* Of h times the eigenvalue. Where stability holds the steps of dop853 it is about the end of the stable piece of the real
 * axis: of slosh under `lyapunov-v2` at 1e-6, between 6.37 and 6.41 in eight steps of ten. Source: dop853. With a half the
 * triangle is taken for stiff at tolerances ten to a hundred times tighter, which it is not; with twice slosh never is. */
#define STABLE_PIECE 6.1
/* So many steps beyond it, with never so many on this side of it one after the other between them. Source: dop853. Of the
 * first, a half finds slosh at 1e-6 after 1.1 s and twice after 3.2 s, instead of 1.8 s, and a half the triangle under
 * `sliding` at 1e-8, for a few steps of its end; of the other, a half finds slosh at 1e-11 after 22 s instead of 4, and
 * twice changes nothing. */
#define STIFF_STEPS 15
#define SMOOTH_STEPS 6

/* Look at the step of length h to y in the lanes that took it to the instant `after`; `last` is where its last stage was. */
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
