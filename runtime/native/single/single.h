/* SPDX-License-Identifier: Apache-2.0 */
/* A single run: one lane, and a model given by the addresses of its functions. */
#ifndef MEHVAR_SINGLE_H
#define MEHVAR_SINGLE_H

#include "mehvar/real.h"

#include "schedule.h"

typedef void mv_1_1(const mv_real *, mv_real *);
typedef void mv_2_1(const mv_real *, const mv_real *, mv_real *);
typedef void mv_3_1(const mv_real *, const mv_real *, const mv_real *, mv_real *);
typedef void mv_4_1(const mv_real *, const mv_real *, const mv_real *, const mv_real *, mv_real *);
typedef void mv_4_2(const mv_real *, const mv_real *, const mv_real *, const mv_real *, mv_real *, mv_real *);
typedef void mv_4_3(const mv_real *, const mv_real *, const mv_real *, const mv_real *, mv_real *, mv_real *, mv_real *);
typedef void mv_6_2(const mv_real *, const mv_real *, const mv_real *, const mv_real *, const mv_real *, const mv_real *,
                    mv_real *, mv_real *);

typedef struct {
    int32_t nq, nx, nu, nz, ny, nr, nm, ne; /* coordinates, state, input, memory, outputs, reference, limits, noise */
    int32_t nseen;            /* what the law receives of the state */
    int32_t nw, nj;           /* Wiener processes; 0, or 1 and the noise of a random step */
    int32_t nv;               /* events */
    int32_t sampled, reference_constant;
    int32_t limits_of_state;  /* limits read no input, and coordinates are states */
    int32_t method;           /* an mv_method */
    int32_t stiff_test;       /* the run ends where it is stiff to dop853 */
    mv_3_1 *rhs;              /* x, u, p -> dx */
    mv_4_1 *outputs;          /* x, u, r, p -> y */
    mv_3_1 *limits;           /* x, u, p -> margin; null without limits */
    mv_3_1 *reference;        /* t, p, s -> r */
    mv_4_1 *law;              /* x, r, p, c -> u */
    mv_6_2 *law_memory;       /* x, r, v, z, p, c -> u, z_next; null without memory */
    mv_4_1 *loop;             /* q, r, p, c -> dq */
    mv_4_2 *observe;          /* q, r, p, c -> x, u; null with an actuator */
    mv_4_3 *observe_command;  /* q, r, p, c -> x, u, u_cmd; null without an actuator */
    mv_3_1 *actuate;          /* x, u_cmd, p -> u; null without an actuator */
    mv_3_1 *measure;          /* x, e, p -> what the law sees of x; null when it sees x */
    mv_3_1 *diffuse;          /* x, dw, p -> change of x; null without process noise */
    mv_3_1 *jump;             /* x, e, p -> x; null without random steps */
    mv_1_1 *input_delays;     /* p -> samples of each input; null without delays of the plant */
    mv_3_1 *rhs_jac;          /* x, u, p -> J; this and the next two null unless the method is linearly implicit */
    mv_4_1 *loop_jac;         /* q, r, p, c -> J_q */
    mv_4_2 *loop_jac_r;       /* q, r, p, c -> J_q, J_r; in place of it where there are references */
    mv_1_1 *project;          /* q -> q; null without a manifold */
    mv_2_1 *project_p;        /* q, p -> q; in place of it where parameters decide */
    mv_1_1 *mass;             /* p -> one, and zero of algebraic states; null without any */
    mv_3_1 *guards;           /* x, u, p -> g; this and the next two null without events */
    mv_4_1 *loop_guards;      /* q, r, p, c -> g */
    mv_4_1 *resets;           /* x, u, p, event -> x_next; null without resets */
    const int32_t *events;    /* of each its direction, whether it resets, an mv_ends */
    const mv_real *p, *c, *s;
    const mv_real *u_own, *z_own; /* results of a law elsewhere for this sample; null for a law of the model */
    const mv_real *e;         /* ne numbers for each evaluation of the law */
    uint64_t seed, run;       /* of the noise that is not in e */
} mv_model;

/* Events in their order, as many as there are: see journal.c. */
typedef struct {
    double *t;
    int32_t *event;
    int64_t count, room;
    int32_t full;             /* no memory for the last ones */
} mv_journal;

typedef void mv_happened(mv_journal *journal, double t, int32_t event);

/* Values that Python sets and reads again. */
typedef struct {
    mv_schedule schedule;
    mv_model model;
    double *q;                /* coordinates at time t */
    const double *z;          /* memory before the first sample */
    mv_happened *happened;    /* called for every event, with the journal */
    mv_journal *journal;
    double *x_seen, *r_seen, *v_seen, *z_seen; /* arguments of a law elsewhere at the next sample */
    double *record_t, *record_x, *record_u, *record_u_cmd, *record_y, *record_z; /* a row each recorded sample */
    int64_t tick, records;    /* done so far */
    int64_t steps, rejected, evaluations;
    double t;
    double error;             /* the largest of a step over its tolerance */
    double t_stiff;           /* where the run was stiff, or NaN */
    int32_t status, violated; /* an mv_status; index of the limit that ended the run, or -1 */
} mv_single;

#endif
