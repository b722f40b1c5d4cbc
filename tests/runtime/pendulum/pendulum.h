/* SPDX-License-Identifier: Apache-2.0 */
/* Hand-written model in the form of a generated one, with states, laws and scenarios whose answers are known. */
#ifndef PENDULUM_H
#define PENDULUM_H

#include "mehvar_math.h"

void pendulum_rhs(const real *x, const real *u, const real *p, real *dx);
void pendulum_outputs(const real *x, const real *u, const real *r, const real *p, real *y);
void pendulum_limits(const real *x, const real *u, const real *p, real *margin);
void pendulum_to_coordinates(const real *x, real *q);
void pendulum_from_coordinates(const real *q, real *x);
void pendulum_initial(const real *p, const real *s, real *x);
void pendulum_reference(const real *t, const real *p, const real *s, real *r);
void pendulum_constraints(const real *p, const real *s, real *margin);
void pendulum_pd(const real *x, const real *r, const real *p, const real *c, real *u);
void pendulum_pd_loop(const real *q, const real *r, const real *p, const real *c, real *dq);
void pendulum_pd_observe(const real *q, const real *r, const real *p, const real *c, real *x, real *u);
void pendulum_pd_defaults(const real *c, real *derived);
void pendulum_pd_constraints(const real *p, const real *c, const real *s, real *margin);
void pendulum_p_sum_start(const real *x, const real *r, const real *p, const real *c, real *z);
void pendulum_p_sum(const real *x, const real *r, const real *v, const real *z, const real *p, const real *c, real *u,
                    real *z_next);
void pendulum_swing(const real *l, const real *g, real *period, real *omega);
void pendulum_jac_x(const real *x, const real *u, const real *p, real *J);
void pendulum_jac_u(const real *x, const real *u, const real *p, real *J);

#endif
