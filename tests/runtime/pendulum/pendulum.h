/* SPDX-License-Identifier: Apache-2.0 */
/* Hand-written model in the form of a generated one, with states, laws and scenarios whose answers are known. */
#ifndef PENDULUM_H
#define PENDULUM_H

#include "mehvar/real.h"

#ifdef __cplusplus
extern "C" {
#endif

void pendulum_rhs(const mv_real *x, const mv_real *u, const mv_real *p, mv_real *dx);
void pendulum_outputs(const mv_real *x, const mv_real *u, const mv_real *r, const mv_real *p, mv_real *y);
void pendulum_limits(const mv_real *x, const mv_real *u, const mv_real *p, mv_real *margin);
void pendulum_to_coordinates(const mv_real *x, mv_real *q);
void pendulum_from_coordinates(const mv_real *q, mv_real *x);
void pendulum_initial(const mv_real *p, const mv_real *s, mv_real *x);
void pendulum_reference(const mv_real *t, const mv_real *p, const mv_real *s, mv_real *r);
void pendulum_constraints(const mv_real *p, const mv_real *s, mv_real *margin);
void pendulum_pd(const mv_real *x, const mv_real *r, const mv_real *p, const mv_real *c, mv_real *u);
void pendulum_pd_loop(const mv_real *q, const mv_real *r, const mv_real *p, const mv_real *c, mv_real *dq);
void pendulum_pd_observe(const mv_real *q, const mv_real *r, const mv_real *p, const mv_real *c, mv_real *x, mv_real *u);
void pendulum_pd_defaults(const mv_real *c, mv_real *derived);
void pendulum_pd_constraints(const mv_real *p, const mv_real *c, const mv_real *s, mv_real *margin);
void pendulum_p_sum_start(const mv_real *x, const mv_real *r, const mv_real *p, const mv_real *c, mv_real *z);
void pendulum_p_sum(const mv_real *x, const mv_real *r, const mv_real *v, const mv_real *z, const mv_real *p, const mv_real *c,
                    mv_real *u, mv_real *z_next);
void pendulum_swing(const mv_real *l, const mv_real *g, mv_real *period, mv_real *omega);
void pendulum_jac_x(const mv_real *x, const mv_real *u, const mv_real *p, mv_real *J);
void pendulum_jac_u(const mv_real *x, const mv_real *u, const mv_real *p, mv_real *J);
void pendulum_outputs_jac(const mv_real *x, const mv_real *u, const mv_real *r, const mv_real *p, mv_real *J_x,
                          mv_real *J_u, mv_real *J_r);
void pendulum_pd_jvp(const mv_real *x, const mv_real *r, const mv_real *p, const mv_real *c, const mv_real *along_x,
                     const mv_real *along_r, mv_real *change);
void pendulum_p_sum_jvp(const mv_real *x, const mv_real *r, const mv_real *v, const mv_real *z, const mv_real *p,
                        const mv_real *c, const mv_real *along_x, const mv_real *along_r, const mv_real *along_v,
                        const mv_real *along_z, mv_real *change_u, mv_real *change_z_next);

#ifdef __cplusplus
}
#endif

#endif
