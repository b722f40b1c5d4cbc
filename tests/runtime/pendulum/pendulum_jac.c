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
