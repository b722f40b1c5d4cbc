/* SPDX-License-Identifier: Apache-2.0 */
/* Functions of a model under a law that a loop calls, with the same arguments for every model. The including file
 * defines mv_model, which has the parameters of a run, and for every call a statement: CALL_RHS and so on. */
#ifndef MEHVAR_CALLS_H
#define MEHVAR_CALLS_H

#include "mehvar/private/arithmetic.h"

static inline void mv_copy(real *to, const real *from, int n)
{
    for (int i = 0; i < n; i++) to[i] = from[i];
}

static inline void mv_call_reference(const mv_model *m, real t, real *r) { CALL_REFERENCE; }
static inline void mv_call_rhs(const mv_model *m, const real *x, const real *u, real *dx) { CALL_RHS; }
static inline void mv_call_loop(const mv_model *m, const real *q, const real *r, real *dq) { CALL_LOOP; }
static inline void mv_call_rhs_jac(const mv_model *m, const real *x, const real *u, real *J) { CALL_RHS_JAC; }
static inline void mv_call_loop_jac(const mv_model *m, const real *q, const real *r, real *J_q, real *J_r)
{
    CALL_LOOP_JAC;
}
static inline void mv_call_observe(const mv_model *m, const real *q, const real *r, real *x, real *u, real *u_cmd)
{
    CALL_OBSERVE;
}
static inline void mv_call_outputs(const mv_model *m, const real *x, const real *u, const real *r, real *y)
{
    CALL_OUTPUTS;
}
static inline void mv_call_limits(const mv_model *m, const real *x, const real *u, real *margin) { CALL_LIMITS; }
static inline void mv_call_law(const mv_model *m, const real *x, const real *r, const real *v, const real *z,
                               real *u_cmd, real *z_next)
{
    CALL_LAW;
}
static inline void mv_call_actuate(const mv_model *m, const real *x, const real *u_cmd, real *u) { CALL_ACTUATE; }
static inline void mv_call_measure(const mv_model *m, const real *x, const real *e, real *x_seen) { CALL_MEASURE; }
static inline void mv_call_input_delays(const mv_model *m, real *d) { CALL_INPUT_DELAYS; }
static inline void mv_call_diffuse(const mv_model *m, const real *x, const real *dw, real *x_step) { CALL_DIFFUSE; }
static inline void mv_call_jump(const mv_model *m, const real *x, const real *e, real *x_after) { CALL_JUMP; }
static inline void mv_call_mass(const mv_model *m, real *diagonal) { CALL_MASS; }
static inline void mv_call_guards(const mv_model *m, const real *x, const real *u, real *g) { CALL_GUARDS; }
static inline void mv_call_loop_guards(const mv_model *m, const real *q, const real *r, real *g) { CALL_LOOP_GUARDS; }
static inline void mv_call_resets(const mv_model *m, const real *x, const real *u, real event, real *x_next)
{
    CALL_RESETS;
}
static inline void mv_call_project(const mv_model *m, const real *q, real *q_next) { CALL_PROJECT; }

/* values that depend only on the held input; computed when the input changes */
static inline void mv_hold(mv_model *m, const real *u) { CALL_HOLD; }

#endif
