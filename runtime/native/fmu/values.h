/* SPDX-License-Identifier: Apache-2.0 */
/* Functions of a unit's model and the values that they determine, for numbers and for dual numbers. */
#ifndef MEHVAR_FMU_VALUES_H
#define MEHVAR_FMU_VALUES_H

#include <string.h>

#include "single.h"

#include "fmu_model.h"

enum fmu_kind { FMU_PLANT, FMU_LOOP, FMU_SAMPLED }; /* the plant alone; under a continuous law; under a sampled one */

static void fmu_reference(const mv_real *t, const mv_real *p, const mv_real *r_now, mv_real *r)
{
    (void)t, (void)p;
    memcpy(r, r_now, FMU_NR * sizeof(mv_real));
}

#if FMU_KIND == 0
static void fmu_input(const mv_real *x, const mv_real *r, const mv_real *p, const mv_real *u_now, mv_real *u)
{
    (void)x, (void)r, (void)p;
    memcpy(u, u_now, FMU_NU * sizeof(mv_real));
}
#endif

/* Sizes of the model, and addresses of its functions in this process. */
static void fmu_functions(mv_model *m)
{
    *m = (mv_model){0};
    m->nq = FMU_NQ, m->nx = FMU_NX, m->nseen = FMU_SEEN, m->nu = FMU_NU, m->nz = FMU_NZ, m->ny = FMU_NY;
    m->nr = FMU_NR, m->nm = FMU_NM, m->ne = FMU_NE, m->nv = FMU_NV;
    m->events = fmu_events;
    m->sampled = FMU_KIND != 1;
    m->method = FMU_METHOD;
    m->outputs = FMU_OUTPUTS;
    m->reference = fmu_reference;
    FMU_MODEL(m);
}

static void fmu_parameters(mv_model *m, const mv_real *v)
{
    m->p = v + FMU_V_P;
    m->c = v + (FMU_KIND == 0 ? FMU_V_U : FMU_V_C);
    m->s = v + FMU_V_R;
}

/* Values of guards at given states. */
static void fmu_guards(const mv_model *m, const mv_real *v, const mv_real *q, mv_real *g)
{
#if FMU_NV > 0 && FMU_KIND == 1
    m->loop_guards(q, v + FMU_V_R, m->p, m->c, g);
#elif FMU_NV > 0
    m->guards(q, v + FMU_V_U, m->p, g);
#else
    (void)m, (void)v, (void)q, (void)g;
#endif
}

/* The memory of a law at the start. */
static void fmu_remember(const mv_model *m, mv_real *v)
{
#if FMU_KIND == 2 && FMU_NZ > 0
    FMU_START(v + FMU_V_Q, v + FMU_V_R, m->p, m->c, v + FMU_V_Z);
#else
    (void)m, (void)v;
#endif
}

/* Evaluate a sampled law at the present values, after the input `applied`. */
static void fmu_command(const mv_model *m, const mv_real *v, const mv_real *applied, mv_real *u, mv_real *z_next)
{
#if FMU_KIND == 2
    mv_real seen[FMU_SEEN], command[FMU_NU + 1];
    const mv_real noise[FMU_NE + 1] = {0};
    if (m->measure) m->measure(v + FMU_V_Q, noise, m->p, seen);
    else memcpy(seen, v + FMU_V_Q, sizeof seen);
    if (m->law_memory) m->law_memory(seen, v + FMU_V_R, applied, v + FMU_V_Z, m->p, m->c, command, z_next);
    else m->law(seen, v + FMU_V_R, m->p, m->c, command);
    if (m->actuate) m->actuate(v + FMU_V_Q, command, m->p, u);
    else memcpy(u, command, FMU_NU * sizeof(mv_real));
#else
    (void)m, (void)v, (void)applied, (void)u, (void)z_next;
#endif
}

/* Compute outputs, derivatives, limits and guards from the present values, with a sampled law's command if it is due. */
static void fmu_follow(const mv_model *m, mv_real *v, const mv_real *applied, int due)
{
    mv_real x[FMU_NX + 1], spare[FMU_NU + FMU_NZ + 1];
    if (due) fmu_command(m, v, applied, v + FMU_V_U, spare);
#if FMU_KIND == 1
    if (m->observe_command) m->observe_command(v + FMU_V_Q, v + FMU_V_R, m->p, m->c, x, v + FMU_V_U, spare);
    else m->observe(v + FMU_V_Q, v + FMU_V_R, m->p, m->c, x, v + FMU_V_U);
    m->loop(v + FMU_V_Q, v + FMU_V_R, m->p, m->c, v + FMU_V_D);
#else
    memcpy(x, v + FMU_V_Q, FMU_NX * sizeof(mv_real));
    m->rhs(x, v + FMU_V_U, m->p, v + FMU_V_D);
#endif
    memcpy(v + FMU_V_X, x, FMU_NX * sizeof(mv_real));
    m->outputs(x, v + FMU_V_U, v + FMU_V_R, m->p, v + FMU_V_Y);
    if (m->limits) m->limits(x, v + FMU_V_U, m->p, v + FMU_V_M);
    fmu_guards(m, v, v + FMU_V_Q, v + FMU_V_G);
}

#endif
