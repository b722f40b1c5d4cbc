/* SPDX-License-Identifier: Apache-2.0 */
/* Hand-written model in the form of a generated one, with states, laws and scenarios whose answers are known. */
#ifndef PENDULUM_H
#define PENDULUM_H

#include "mehvar/real.h"

#define PENDULUM_HASH "0000000000000000000000000000000000000000000000000000000000000000"

/* what a generated header says vector by vector and function by function */
enum {
    PENDULUM_X_ANGLE = 0,
    PENDULUM_X_RATE = 1,
    PENDULUM_NX = 2,
    PENDULUM_U_TORQUE = 0,
    PENDULUM_NU = 1,
    PENDULUM_R_ANGLE_REF = 0,
    PENDULUM_NR = 1,
    PENDULUM_Y_ENERGY = 0,
    PENDULUM_Y_ANGLE_ERROR = 1,
    PENDULUM_Y_POWER = 2,
    PENDULUM_NY = 3,
    PENDULUM_P_M = 0,
    PENDULUM_P_L = 1,
    PENDULUM_P_G = 2,
    PENDULUM_P_B = 3,
    PENDULUM_P_WALL = 4,
    PENDULUM_P_K_WALL = 5,
    PENDULUM_P_CUBE = 6,
    PENDULUM_P_RATE_MAX = 7,
    PENDULUM_P_TORQUE_MAX = 8,
    PENDULUM_P_TS = 9,
    PENDULUM_NP = 10,
    PENDULUM_S_ANGLE_0 = 0,
    PENDULUM_S_RATE_0 = 1,
    PENDULUM_S_ANGLE_REF = 2,
    PENDULUM_S_REF_RATE = 3,
    PENDULUM_NS = 4,
    PENDULUM_Q_DOUBLE_ANGLE = 0,
    PENDULUM_Q_RATE = 1,
    PENDULUM_NQ = 2,
    PENDULUM_PD_C_K_P = 0,
    PENDULUM_PD_C_K_D = 1,
    PENDULUM_NPD_C = 2,
    PENDULUM_P_SUM_C_K_P = 0,
    PENDULUM_P_SUM_C_K_I = 1,
    PENDULUM_NP_SUM_C = 2,
    PENDULUM_P_SUM_Z_SUM = 0,
    PENDULUM_NP_SUM_Z = 1,
    PENDULUM_RHS_NX = 2,
    PENDULUM_RHS_NU = 1,
    PENDULUM_RHS_NP = 10,
    PENDULUM_RHS_NDX = 2,
    PENDULUM_OUTPUTS_NX = 2,
    PENDULUM_OUTPUTS_NU = 1,
    PENDULUM_OUTPUTS_NR = 1,
    PENDULUM_OUTPUTS_NP = 10,
    PENDULUM_OUTPUTS_NY = 3,
    PENDULUM_LIMITS_NX = 2,
    PENDULUM_LIMITS_NU = 1,
    PENDULUM_LIMITS_NP = 10,
    PENDULUM_LIMITS_NMARGIN = 2,
    PENDULUM_TO_COORDINATES_NX = 2,
    PENDULUM_TO_COORDINATES_NQ = 2,
    PENDULUM_FROM_COORDINATES_NQ = 2,
    PENDULUM_FROM_COORDINATES_NX = 2,
    PENDULUM_INITIAL_NP = 10,
    PENDULUM_INITIAL_NS = 4,
    PENDULUM_INITIAL_NX = 2,
    PENDULUM_REFERENCE_NT = 1,
    PENDULUM_REFERENCE_NP = 10,
    PENDULUM_REFERENCE_NS = 4,
    PENDULUM_REFERENCE_NR = 1,
    PENDULUM_CONSTRAINTS_NP = 10,
    PENDULUM_CONSTRAINTS_NS = 4,
    PENDULUM_CONSTRAINTS_NMARGIN = 1,
    PENDULUM_PD_NX = 2,
    PENDULUM_PD_NR = 1,
    PENDULUM_PD_NP = 10,
    PENDULUM_PD_NC = 2,
    PENDULUM_PD_NU = 1,
    PENDULUM_PD_LOOP_NQ = 2,
    PENDULUM_PD_LOOP_NR = 1,
    PENDULUM_PD_LOOP_NP = 10,
    PENDULUM_PD_LOOP_NC = 2,
    PENDULUM_PD_LOOP_NDQ = 2,
    PENDULUM_PD_OBSERVE_NQ = 2,
    PENDULUM_PD_OBSERVE_NR = 1,
    PENDULUM_PD_OBSERVE_NP = 10,
    PENDULUM_PD_OBSERVE_NC = 2,
    PENDULUM_PD_OBSERVE_NX = 2,
    PENDULUM_PD_OBSERVE_NU = 1,
    PENDULUM_PD_DEFAULTS_NC = 2,
    PENDULUM_PD_DEFAULTS_NDERIVED = 1,
    PENDULUM_PD_CONSTRAINTS_NP = 10,
    PENDULUM_PD_CONSTRAINTS_NC = 2,
    PENDULUM_PD_CONSTRAINTS_NS = 4,
    PENDULUM_PD_CONSTRAINTS_NMARGIN = 1,
    PENDULUM_P_SUM_NX = 2,
    PENDULUM_P_SUM_NR = 1,
    PENDULUM_P_SUM_NV = 1,
    PENDULUM_P_SUM_NZ = 1,
    PENDULUM_P_SUM_NP = 10,
    PENDULUM_P_SUM_NC = 2,
    PENDULUM_P_SUM_NU = 1,
    PENDULUM_P_SUM_NZ_NEXT = 1,
    PENDULUM_P_SUM_START_NX = 2,
    PENDULUM_P_SUM_START_NR = 1,
    PENDULUM_P_SUM_START_NP = 10,
    PENDULUM_P_SUM_START_NC = 2,
    PENDULUM_P_SUM_START_NZ = 1,
    PENDULUM_SWING_NL = 1,
    PENDULUM_SWING_NG = 1,
    PENDULUM_SWING_NPERIOD = 1,
    PENDULUM_SWING_NOMEGA = 1,
    PENDULUM_JAC_X_NX = 2,
    PENDULUM_JAC_X_NU = 1,
    PENDULUM_JAC_X_NP = 10,
    PENDULUM_JAC_X_NJ = 4,
    PENDULUM_JAC_U_NX = 2,
    PENDULUM_JAC_U_NU = 1,
    PENDULUM_JAC_U_NP = 10,
    PENDULUM_JAC_U_NJ = 2,
    PENDULUM_OUTPUTS_JAC_NX = 2,
    PENDULUM_OUTPUTS_JAC_NU = 1,
    PENDULUM_OUTPUTS_JAC_NR = 1,
    PENDULUM_OUTPUTS_JAC_NP = 10,
    PENDULUM_OUTPUTS_JAC_NJ_X = 6,
    PENDULUM_OUTPUTS_JAC_NJ_U = 3,
    PENDULUM_OUTPUTS_JAC_NJ_R = 3,
    PENDULUM_PD_JVP_NX = 2,
    PENDULUM_PD_JVP_NR = 1,
    PENDULUM_PD_JVP_NP = 10,
    PENDULUM_PD_JVP_NC = 2,
    PENDULUM_PD_JVP_NALONG_X = 2,
    PENDULUM_PD_JVP_NALONG_R = 1,
    PENDULUM_PD_JVP_NCHANGE = 1,
    PENDULUM_P_SUM_JVP_NX = 2,
    PENDULUM_P_SUM_JVP_NR = 1,
    PENDULUM_P_SUM_JVP_NV = 1,
    PENDULUM_P_SUM_JVP_NZ = 1,
    PENDULUM_P_SUM_JVP_NP = 10,
    PENDULUM_P_SUM_JVP_NC = 2,
    PENDULUM_P_SUM_JVP_NALONG_X = 2,
    PENDULUM_P_SUM_JVP_NALONG_R = 1,
    PENDULUM_P_SUM_JVP_NALONG_V = 1,
    PENDULUM_P_SUM_JVP_NALONG_Z = 1,
    PENDULUM_P_SUM_JVP_NCHANGE_U = 1,
    PENDULUM_P_SUM_JVP_NCHANGE_Z_NEXT = 1,
};

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
