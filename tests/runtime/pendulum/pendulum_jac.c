/* SPDX-License-Identifier: Apache-2.0 */
#include "pendulum.h"

#include "mehvar/private/arithmetic.h"

void pendulum_jac_x(const real *x, const real *u, const real *p, real *J)
{
    (void)u;
    const real wall = K(0.5) * p[5] / mv_sqrt(p[4] - x[0]);
    J[0] = SPLAT(0.0);
    J[1] = SPLAT(1.0);
    J[2] = K(3.0) * p[6] * x[0] * x[0] - p[2] / p[1] * mv_cos(x[0]) - wall;
    J[3] = -p[3] / (p[0] * p[1] * p[1]);
}

void pendulum_jac_u(const real *x, const real *u, const real *p, real *J)
{
    (void)x;
    (void)u;
    J[0] = SPLAT(0.0);
    J[1] = K(1.0) / (p[0] * p[1] * p[1]);
}

void pendulum_outputs_jac(const real *x, const real *u, const real *r, const real *p, real *J_x, real *J_u, real *J_r)
{
    (void)r;
    J_x[0] = p[0] * p[2] * p[1] * mv_sin(x[0]);
    J_x[1] = p[0] * p[1] * p[1] * x[1];
    J_x[2] = SPLAT(1.0);
    J_x[3] = SPLAT(0.0);
    J_x[4] = SPLAT(0.0);
    J_x[5] = u[0];
    J_u[0] = SPLAT(0.0);
    J_u[1] = SPLAT(0.0);
    J_u[2] = x[1];
    J_r[0] = SPLAT(0.0);
    J_r[1] = SPLAT(-1.0);
    J_r[2] = SPLAT(0.0);
}

void pendulum_pd_jvp(const real *x, const real *r, const real *p, const real *c, const real *along_x,
                     const real *along_r, real *change)
{
    (void)x, (void)r, (void)p;
    change[0] = -c[0] * (along_x[0] - along_r[0]) - c[1] * along_x[1];
}

void pendulum_p_sum_jvp(const real *x, const real *r, const real *v, const real *z, const real *p, const real *c,
                        const real *along_x, const real *along_r, const real *along_v, const real *along_z,
                        real *change_u, real *change_z_next)
{
    (void)x, (void)r, (void)v, (void)z, (void)p, (void)along_v;
    change_u[0] = -c[0] * (along_x[0] - along_r[0]) - c[1] * along_z[0];
    change_z_next[0] = along_z[0] + (along_x[0] - along_r[0]);
}
