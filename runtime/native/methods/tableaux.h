/* SPDX-License-Identifier: Apache-2.0 */
/* Coefficients of the explicit Runge-Kutta methods. */
#ifndef MEHVAR_TABLEAUX_H
#define MEHVAR_TABLEAUX_H

#define MV_STAGES 16 /* the most that a method has */

enum mv_method { MV_RK4, MV_DOPRI5, MV_DOP853, MV_ROCK4 };

typedef struct {
    int stages;
    int order;                      /* the local error goes like step^order; 0 = fixed step */
    int end_in_error;               /* the estimate e needs the slope at the end of the step */
    const double (*a)[MV_STAGES];
    const double *b, *c;
    const double *e;                /* main error estimate: for each stage, and for the end if it is needed */
    const double *e3;               /* third-order estimate of dop853, or null */
} mv_tableau;

extern const mv_tableau mv_tableaux[4];  /* by enum mv_method */

#endif
