/* SPDX-License-Identifier: Apache-2.0 */
/* Coordinates between the ends of a step, for methods whose steps pass over ticks.
 *
 * With s the part of the step: before + s (f0 + (1 - s) (f1 + s (f2 + s f3))), f0 the change over the step and the others
 * sums over its stages. Of rodas5p it is of order four. Source: Steinebach, BIT 63 (2023) 27. */
#ifndef MEHVAR_DENSE_H
#define MEHVAR_DENSE_H

#include "state.h"

/* Keep the step q -> y of length h in `lanes`, which took it; its stages are still there. */
static void mv_keep_step(mv_loop *l, real h, mask lanes)
{
    for (int j = 0; j < TERMS; j++) mv_blend(lanes, l->dense[TERMS + j], l->dense[j], NQ);
    mv_blend(lanes, l->before[1], l->before[0], NQ);
    mv_blend(lanes, l->before[0], l->q, NQ);
    mv_blend(lanes, l->begin + 1, l->begin, 1);
    mv_blend(lanes, l->span + 1, l->span, 1);
    mv_blend(lanes, l->begin, &l->t, 1);
    mv_blend(lanes, l->span, &h, 1);
    for (int i = 0; i < NQ; i++) {
        l->dense[0][i] = SELECT(lanes, l->y[i] - l->q[i], l->dense[0][i]);
        for (int term = 1; term < TERMS; term++) {
            real sum = SPLAT(0);
            for (int j = 0; j < STAGES - 1; j++) sum += K(DENSE_G(term - 1, j)) * l->k[j + 1][i];
            l->dense[term][i] = SELECT(lanes, sum, l->dense[term][i]);
        }
    }
}

/* Coordinates at the instant t, which every lane has reached and at most two kept steps ago. */
static void mv_between(mv_loop *l, double t, real *q)
{
    const mask end = EQ(l->t, SPLAT(t)), older = LT(SPLAT(t), l->begin[0]);
    const real begin = SELECT(older, l->begin[1], l->begin[0]), span = SELECT(older, l->span[1], l->span[0]);
    const real part = (SPLAT(t) - begin) / span, rest = K(1) - part;
    for (int i = 0; i < NQ; i++) {
        real sum = SPLAT(0);
        for (int j = TERMS - 1; j >= 0; j--)
            sum = (sum + SELECT(older, l->dense[TERMS + j][i], l->dense[j][i])) * (j == 1 ? rest : part);
        q[i] = SELECT(end, l->q[i], SELECT(older, l->before[1][i], l->before[0][i]) + sum);
    }
    if (!PROJECTED) return;
    const mask exact = OR(end, EQ(SPLAT(t), begin));
    mv_project(l, q, l->stage);
    mv_blend(NOT(exact), q, l->stage, NQ);
}

#endif
