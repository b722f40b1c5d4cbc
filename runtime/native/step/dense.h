/* SPDX-License-Identifier: Apache-2.0 */
/* Dense output: coordinates within a step, for loops whose steps pass over ticks.
 *
 * Let s be the part of the step and r = 1 - s. For explicit methods the coordinates are before + s (f0 + r (f1 + s
 * (f2 + r (f3 + s ...)))). f0 is the change over the step. f1 and f2 belong to the cubic with the slopes at both
 * ends (Hermite). The other terms are h times sums over slopes: order 7 for dop853, which computes three more slopes
 * for them, and order 4 for dopri5 and rock4. For rodas5p, of order 4, the coordinates are before + s (f0 + r (f1 +
 * s (f2 + s f3))), with sums over its stages from f1 on. Sources: Hairer, Norsett & Wanner I, section II.6, and
 * their codes; Steinebach, BIT 63 (2023) 27; tests/runtime/run/rock4.py.
 *
 * Steps wait in a ring, in the order of each lane, until the ticks reach them. So lanes need not take equal steps. */
#ifndef MEHVAR_DENSE_H
#define MEHVAR_DENSE_H

#include "control.h"

/* Largest values of s^3 r^3 and s^4 r^3: weights of the last two terms of dop853. */
#define LAST_BUT_ONE 0.015625
#define LAST 0.00839
/* Weight of the error within a step relative to the error at its end. Where stability limits the steps, polynomials
 * of this order are not accurate. Without this weight, samples of slosh under `lyapunov-v2` every 0.1 s are off by
 * 85 times a tolerance of 1e-6 and by 3000 times a tolerance of 1e-10. With the weight they are off by 1.7 and 2.8
 * times; with four times the weight by 0.9 and 2.5 times, for 13 % more slopes at 1e-10; with twenty times the
 * weight by 0.6 and 0.4 times, for 28 % more. */
#define TERMS_WEIGHT 0.005

/* Defined by the including file: the slopes that only dense output needs, and its sums. */
static inline void mv_dense_slopes(mv_loop *l, real h);
static inline void mv_dense_sums(const mv_loop *l, real (*sums)[NQ]);

/* Return those of `lanes` whose coordinates within the step q -> y of length h are accurate. `ratio` grows to the
 * error of these coordinates. The sums of the step are stored for lanes that keep it. The error is estimated from
 * the largest values of the last two terms: the ratio of the next, missing term to the last one would be the same. */
static mask mv_between_good(mv_loop *l, real h, mask lanes, real *ratio, real (*sums)[NQ])
{
    if (!mv_any(lanes)) { /* no samples within a step that ends at a tick and passes over none */
        for (int j = 0; j < DENSE; j++)
            for (int i = 0; i < NQ; i++) sums[j][i] = SPLAT(0);
        return mv_all();
    }
    mv_dense_slopes(l, h);
    mv_dense_sums(l, sums);
    if (!THIRD) return mv_all();
    const real before = mv_scaled_rms(l, sums[DENSE - 2], l->y) * K(LAST_BUT_ONE);
    const real last = mv_scaled_rms(l, sums[DENSE - 1], l->y) * K(LAST);
    const real error = SELECT(EQ(last, SPLAT(0)), SPLAT(0), K(TERMS_WEIGHT) * h * last * last / before);
    *ratio = SELECT(AND(lanes, NOT(LE(error, *ratio))), error, *ratio);
    return NOT(AND(lanes, NOT(LE(error, SPLAT(1)))));
}

/* Coordinates before and after a step, then the terms f0 ... */
static inline void mv_terms(const mv_loop *l, real h, real (*sums)[NQ], real (*terms)[NQ])
{
    for (int i = 0; i < NQ; i++) {
        const real change = l->y[i] - l->q[i];
        terms[0][i] = l->q[i];
        terms[1][i] = l->y[i];
        terms[2][i] = change;
        if (!GAMMA) {
            terms[3][i] = h * l->k[0][i] - change;
            terms[4][i] = change - h * l->k[STAGES][i] - terms[3][i];
        }
        for (int j = 0; j < DENSE; j++) terms[ROWS_KEPT - DENSE + j][i] = GAMMA ? sums[j][i] : h * sums[j][i];
    }
}

/* The place of a lane's step in its ring, whose numbers lie side by side: in vectors each would take a cache line. */
static inline scalar *mv_slot(const mv_loop *l, int lane, int64_t step)
{
    return l->kept + (lane * (int64_t)KEPT + step % KEPT) * KEPT_SIZE;
}

/* Store the step q -> y of length h to the instant `after` in `lanes`, which accepted it; its slopes are still
 * available. */
static void mv_keep_step(mv_loop *l, real h, real after, mask lanes, real (*sums)[NQ])
{
    const real moved = SELECT0(lanes, SPLAT(1));
    real terms[ROWS_KEPT][NQ];
    mv_terms(l, h, sums, terms);
    for (int lane = 0; lane < MEHVAR_LANES; lane++) {
        if (!AT(moved, lane)) continue;
        scalar *const slot = mv_slot(l, lane, l->made[lane]++);
        slot[0] = AT(l->t, lane);
        slot[1] = AT(after, lane);
        slot[2] = AT(h, lane);
        for (int j = 0; j < ROWS_KEPT; j++)
            for (int i = 0; i < NQ; i++) slot[3 + j * NQ + i] = AT(terms[j][i], lane);
    }
    l->waiting += moved;
}

/* For every lane, select the stored step that contains the instant t. */
static inline void mv_find_step(mv_loop *l, double t)
{
    for (int lane = 0; lane < MEHVAR_LANES; lane++) {
        while (AT(l->end, lane) < t && AT(l->waiting, lane) > 0) {
            const scalar *const slot = mv_slot(l, lane, l->made[lane] - (int64_t)AT(l->waiting, lane));
            AT(l->begin, lane) = slot[0];
            AT(l->end, lane) = slot[1];
            AT(l->span, lane) = slot[2];
            for (int j = 0; j < ROWS_KEPT; j++)
                for (int i = 0; i < NQ; i++) AT(l->dense[j][i], lane) = slot[3 + j * NQ + i];
            AT(l->waiting, lane) -= 1;
        }
    }
}

/* Coordinates at the instant t, which every live lane has reached. */
static void mv_between(mv_loop *l, double t, real *q)
{
    if (l->tick == 0) {
        mv_copy(q, l->q, NQ);
        return;
    }
    mv_find_step(l, t);
    const mask end = EQ(l->end, SPLAT(t));
    const real part = (SPLAT(t) - l->begin) / l->span, rest = K(1) - part;
    for (int i = 0; i < NQ; i++) {
        real sum = SPLAT(0);
        for (int j = ROWS_KEPT - 3; j >= 0; j--)
            sum = (sum + l->dense[j + 2][i]) * ((GAMMA ? j == 1 : j % 2) ? rest : part);
        q[i] = SELECT(end, l->dense[1][i], l->dense[0][i] + sum);
    }
    if (!PROJECTED) return;
    mv_project(l, q, l->stage);
    mv_blend(NOT(end), q, l->stage, NQ);
}

#endif
