/* SPDX-License-Identifier: Apache-2.0 */
/* Explicit Runge-Kutta methods with exact stops: no allocation, no shared state. */
#ifndef MEHVAR_INTEGRATOR_H
#define MEHVAR_INTEGRATOR_H

#include <stdint.h>

enum mv_status { MV_DONE, MV_NOT_FINITE, MV_STEP_UNDERFLOW, MV_TOO_MANY_STEPS, MV_LIMIT };
enum mv_method { MV_RK4, MV_DOPRI5, MV_DOP853, MV_ROCK4 };

/* dx = f(t, x) */
typedef void (*mv_rhs)(double t, const double *x, double *dx, void *context);
/* Called with every accepted x, which it may put back on a manifold. */
enum mv_verdict { MV_STOP, MV_GO_ON, MV_MOVED };
typedef enum mv_verdict (*mv_accept)(double *x, void *context);

typedef struct {
    int32_t method;
    int32_t n;
    int32_t held;       /* f changes at the end of every interval: never reuse its last value there */
    int32_t ready;      /* the first stage holds f(t, x) */
    double rtol, atol;
    double step;        /* largest step of rk4; unused by the adaptive methods */
    double t;
    double h;           /* step the error control would take; 0 before the first */
    double reserve;     /* of the last accepted step, see there; 1 before the first */
    int64_t max_steps;  /* per interval */
    int64_t accepted, rejected, evaluations;
    double *work;       /* (MV_STAGES + 3) * n numbers */
} mv_stepper;

#define MV_STAGES 16

/* Integrate x from s->t to exactly target; on any status but MV_DONE, (s->t, x) is the last good point. */
int mv_advance(mv_stepper *s, double *x, double target, mv_rhs f, mv_accept accept, void *context);

#endif
