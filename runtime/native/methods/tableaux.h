/* SPDX-License-Identifier: Apache-2.0 */
/* Coefficients of the explicit Runge-Kutta methods, and of a linearly implicit one. */
#ifndef MEHVAR_TABLEAUX_H
#define MEHVAR_TABLEAUX_H

#define MV_STAGES 16 /* largest number of any method */
#define MV_KEPT 9    /* largest number of rows that dense output keeps of a step: dop853 */

enum mv_method { MV_RK4, MV_DOPRI5, MV_DOP853, MV_ROCK4, MV_RODAS5P, MV_EULER, MV_PLATEN };

typedef struct {
    int stages;                     /* slopes; of a linearly implicit method one more than it has stages */
    int order;                      /* the local error goes like step^order; 0 = fixed step */
    int end_in_error;               /* the estimate e needs the slope at the end of the step */
    const double (*a)[MV_STAGES];
    const double *b, *c;
    const double *e;                /* main error estimate: for each stage, and for the end if it is needed; or null */
    const double *e3;               /* third-order estimate of dop853, or null */
    /* of a linearly implicit method, see step/implicit.h, whose a and c are there too: */
    const double (*g)[MV_STAGES];   /* contributions of previous stages to the right side, over the step */
    const double *d;                /* weights of the slope's change in time, the first of which is gamma; or null */
    /* of dense output, see step/dense.h; a method without one has none of: */
    int dense;                      /* sums over slopes, or over the stages of a linearly implicit method */
    int slopes;                     /* in these sums; those after the end of the step are computed for them alone */
    const double (*dense_g)[MV_STAGES];
} mv_tableau;

extern const mv_tableau mv_tableaux[7];  /* by enum mv_method */

#endif
