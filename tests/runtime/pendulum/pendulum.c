/* SPDX-License-Identifier: Apache-2.0 */
#include "pendulum.h"

#include "mehvar/private/arithmetic.h"

/* p: m, l, g, b, wall, k_wall, cube, rate_max, torque_max, Ts */
void pendulum_rhs(const real *x, const real *u, const real *p, real *dx)
{
    const real torque = u[0] - p[3] * x[1] - p[0] * p[2] * p[1] * mv_sin(x[0]);
    dx[0] = x[1];
    dx[1] = torque / (p[0] * p[1] * p[1]) + p[5] * mv_sqrt(p[4] - x[0]) + p[6] * x[0] * x[0] * x[0];
}

void pendulum_outputs(const real *x, const real *u, const real *r, const real *p, real *y)
{
    y[0] = K(0.5) * p[0] * p[1] * p[1] * x[1] * x[1] + p[0] * p[2] * p[1] * (K(1.0) - mv_cos(x[0]));
    y[1] = x[0] - r[0];
    y[2] = u[0] * x[1];
}

void pendulum_limits(const real *x, const real *u, const real *p, real *margin)
{
    margin[0] = p[7] - mv_fabs(x[1]);
    margin[1] = p[8] - mv_fabs(u[0]);
}

void pendulum_to_coordinates(const real *x, real *q)
{
    q[0] = K(2.0) * x[0];
    q[1] = x[1];
}

void pendulum_from_coordinates(const real *q, real *x)
{
    x[0] = K(0.5) * q[0];
    x[1] = q[1];
}

/* s: angle_0, rate_0, angle_ref, ref_rate */
void pendulum_initial(const real *p, const real *s, real *x)
{
    (void)p;
    x[0] = s[0];
    x[1] = s[1];
}

void pendulum_reference(const real *t, const real *p, const real *s, real *r)
{
    (void)p;
    r[0] = s[2] + s[3] * t[0];
}

void pendulum_constraints(const real *p, const real *s, real *margin)
{
    (void)p;
    margin[0] = K(3.141592653589793) - mv_fabs(s[0]);
}

/* c: k_p, k_d */
void pendulum_pd(const real *x, const real *r, const real *p, const real *c, real *u)
{
    (void)p;
    u[0] = -c[0] * (x[0] - r[0]) - c[1] * x[1];
}

void pendulum_pd_observe(const real *q, const real *r, const real *p, const real *c, real *x, real *u)
{
    pendulum_from_coordinates(q, x);
    pendulum_pd(x, r, p, c, u);
}

void pendulum_pd_loop(const real *q, const real *r, const real *p, const real *c, real *dq)
{
    real x[2], u[1];
    pendulum_pd_observe(q, r, p, c, x, u);
    pendulum_rhs(x, u, p, dq);
    dq[0] = K(2.0) * dq[0];
}

void pendulum_pd_defaults(const real *c, real *derived) { derived[0] = K(2.0) * mv_sqrt(c[0]); }

void pendulum_pd_constraints(const real *p, const real *c, const real *s, real *margin)
{
    (void)s;
    margin[0] = c[0] - p[0] * p[2] * p[1];
}

/* c: k_p, k_i */
void pendulum_p_sum_start(const real *x, const real *r, const real *p, const real *c, real *z)
{
    (void)x, (void)r, (void)p, (void)c;
    z[0] = SPLAT(K(0.25));
}

void pendulum_p_sum(const real *x, const real *r, const real *v, const real *z, const real *p, const real *c, real *u,
                    real *z_next)
{
    (void)v, (void)p;
    u[0] = -c[0] * (x[0] - r[0]) - c[1] * z[0];
    z_next[0] = z[0] + (x[0] - r[0]);
}

void pendulum_swing(const real *l, const real *g, real *period, real *omega)
{
    omega[0] = mv_sqrt(g[0] / l[0]);
    period[0] = K(6.283185307179586) / omega[0];
}
