/* SPDX-License-Identifier: Apache-2.0 */
/* One closed loop. The caller owns all memory and may stop between two calls of mv_run. */
#include "single.h"

#include "mehvar/private/arithmetic.h"
#include "noise.h"
#include "tableaux.h"

#define NQ (l->model.nq)
#define NX (l->model.nx)
#define NU (l->model.nu)
#define NZ (l->model.nz)
#define NY (l->model.ny)
#define NR (l->model.nr)
#define SEEN (l->model.nseen)
#define LIMITS (l->model.nm)
#define STATE_LIMITS (l->model.limits_of_state)
#define NOISE (l->model.ne)
#define DELAYED (l->model.input_delays != 0)
#define WIENER (l->model.nw)
#define JUMP (l->model.nj)
#define EVENTS (l->model.nv)
#define EVENT(e, k) (l->model.events[(e) * 3 + (k)])
#define SAMPLED (l->model.sampled)
#define REFERENCE_CONSTANT (l->model.reference_constant)
#define PROJECTED (l->model.project != 0 || l->model.project_p != 0)
#define ALGEBRAIC (l->model.mass != 0)
#define RECORDS_COMMAND 1

#define METHOD (&mv_tableaux[l->model.method])
#define STRONG (l->model.method == MV_PLATEN)
#define STAGES (METHOD->stages)
#define ORDER (METHOD->order)
#define ESTIMATED (METHOD->order != 0)
#define END_IN_ERROR (ESTIMATED && METHOD->end_in_error)
#define THIRD (METHOD->e3 != 0)
#define GAMMA (METHOD->d ? METHOD->d[0] : 0)
#define IMPLICIT_A(s, j) (METHOD->a[s][j])
#define IMPLICIT_G(s, j) (METHOD->g[s][j])
#define IMPLICIT_C(s) (METHOD->c[s])
#define IMPLICIT_D(s) (METHOD->d[s])
#define STIFF_TEST (l->model.stiff_test)
#define DENSE (METHOD->dense)
#define SLOPES (METHOD->slopes)

#define CALL_REFERENCE m->reference(&t, m->p, m->s, r)
#define CALL_RHS m->rhs(x, u, m->p, dx)
#define CALL_LOOP m->loop(q, r, m->p, m->c, dq)
#define CALL_RHS_JAC m->rhs_jac(x, u, m->p, J)
#define CALL_LOOP_JAC                                                                                                \
    if (m->loop_jac_r) m->loop_jac_r(q, r, m->p, m->c, J_q, J_r);                                                    \
    else m->loop_jac(q, r, m->p, m->c, J_q)
#define CALL_OBSERVE                                                                                                 \
    if (m->observe_command) m->observe_command(q, r, m->p, m->c, x, u, u_cmd);                                       \
    else m->observe(q, r, m->p, m->c, x, u), mv_copy(u_cmd, u, m->nu)
#define CALL_OUTPUTS m->outputs(x, u, r, m->p, y)
#define CALL_LIMITS m->limits(x, u, m->p, margin)
#define CALL_LAW                                                                                                     \
    if (m->u_own) mv_copy(u_cmd, m->u_own, m->nu), mv_copy(z_next, m->z_own, m->nz);                                 \
    else if (m->law_memory) m->law_memory(x, r, v, z, m->p, m->c, u_cmd, z_next);                                         \
    else m->law(x, r, m->p, m->c, u_cmd)
#define CALL_ACTUATE                                                                                                 \
    if (m->actuate) m->actuate(x, u_cmd, m->p, u);                                                                   \
    else mv_copy(u, u_cmd, m->nu)
#define CALL_MEASURE                                                                                                 \
    if (m->measure) m->measure(x, e, m->p, x_seen);                                                                  \
    else mv_copy(x_seen, x, m->nx)
#define CALL_INPUT_DELAYS m->input_delays(m->p, d)
#define CALL_DIFFUSE m->diffuse(x, dw, m->p, x_step)
#define CALL_JUMP m->jump(x, e, m->p, x_after)
#define CALL_PROJECT                                                                                                 \
    if (m->project_p) m->project_p(q, m->p, q_next);                                                                 \
    else m->project(q, q_next)
#define CALL_MASS m->mass(m->p, diagonal)
#define CALL_GUARDS m->guards(x, u, m->p, g)
#define CALL_LOOP_GUARDS m->loop_guards(q, r, m->p, m->c, g)
#define CALL_RESETS m->resets(x, u, m->p, &event, x_next)
#define CALL_HOLD

#define REALS(a, n) real *a
#define ROWS(a, m, n) real *a[MV_STAGES + 1] /* the largest number of any method */

#include "loop.h"

typedef struct {
    mv_loop loop;
    mv_single *single;
} mv_work;

int64_t mv_single_size(void) { return (int64_t)sizeof(mv_single); }

/* y = sum_j w[j] k[j], over the weights that are not zero in their order */
static void combine(const mv_loop *l, double *const *k, const double *w, int count, double *y)
{
    int j = 0;
    while (w[j] == 0.0) j++;
    for (int i = 0; i < NQ; i++) y[i] = w[j] * k[j][i];
    for (j++; j < count; j++) {
        if (w[j] == 0.0) continue;
        for (int i = 0; i < NQ; i++) y[i] += w[j] * k[j][i];
    }
}

static void shift(const mv_loop *l, double h, double *y)
{
    for (int i = 0; i < NQ; i++) y[i] = l->q[i] + h * y[i];
}

/* The slopes k[first] ... k[last - 1]. */
static void stages(mv_loop *l, double h, int first, int last)
{
    const mv_tableau *m = METHOD;
    for (int j = first; j < last; j++) {
        combine(l, l->k, m->a[j], j, l->stage);
        shift(l, h, l->stage);
        mv_slope(l, l->t + m->c[j] * h, l->stage, l->k[j]);
    }
}

static inline void mv_stages(mv_loop *l, double h)
{
    stages(l, h, 1, STAGES);
    combine(l, l->k, METHOD->b, STAGES, l->y);
    shift(l, h, l->y);
}

static inline void mv_dense_slopes(mv_loop *l, double h) { stages(l, h, STAGES + 1, SLOPES); }

static inline void mv_dense_sums(const mv_loop *l, double (*sums)[NQ])
{
    double *const *k = l->k + (GAMMA ? 1 : 0); /* the stages of a linearly implicit step begin there */
    for (int j = 0; j < DENSE; j++) combine(l, k, METHOD->dense_g[j], SLOPES, sums[j]);
}

static inline void mv_estimate(const mv_loop *l, double *error, double *third_error)
{
    const mv_tableau *m = METHOD;
    combine(l, l->k, m->e, m->stages + m->end_in_error, error);
    if (m->e3) combine(l, l->k, m->e3, m->stages, third_error);
}

/* The noise of measurements was drawn before, for a law that is evaluated elsewhere. */
static void mv_draw(const mv_loop *l, enum mv_stream stream, int64_t index, int size, double *e)
{
    if (stream == MV_OF_MEASUREMENTS) mv_copy(e, l->model.e + index * size, size);
    else mv_noise(l->model.seed, &l->model.run, stream, (uint64_t)index, size, e);
}

static void write_row(mv_loop *l, double t)
{
    mv_single *s = ((mv_work *)l)->single;
    const int64_t row = s->records++;
    s->record_t[row] = t;
    mv_copy(s->record_x + row * NX, l->column, NX);
    mv_copy(s->record_u + row * NU, l->column + U_COLUMN, NU);
    mv_copy(s->record_u_cmd + row * NU, l->column + U_CMD_COLUMN, NU);
    mv_copy(s->record_y + row * NY, l->column + Y_COLUMN, NY);
    mv_copy(s->record_z + row * NZ, l->column + Z_COLUMN, NZ);
}

static void mv_record(mv_loop *l, mask lanes, int due)
{
    (void)lanes;
    (void)due;
    write_row(l, l->schedule->t[l->tick]);
}

static void mv_record_end(mv_loop *l, mask lanes)
{
    (void)lanes;
    write_row(l, l->t);
}

static void mv_happen(mv_loop *l, mask lanes, int event)
{
    (void)lanes;
    mv_single *s = ((mv_work *)l)->single;
    s->happened(s->journal, l->t, event);
}

/* Place the arrays of a loop one after the other from `place` on; return their end. */
static double *divide(mv_loop *l, double *place)
{
    for (int j = 0; j < MOST_SLOPES; j++, place += NQ) l->k[j] = place;
    for (int j = 0; j < ROWS_KEPT; j++, place += NQ) l->dense[j] = place;
    const struct {
        double **array;
        int64_t size;
    } arrays[] = {
        {&l->y, NQ}, {&l->stage, NQ}, {&l->r, NR}, {&l->u_cmd, NU}, {&l->z_next, NZ}, {&l->column, COLUMNS},
        {&l->queue, mv_queued(l->schedule) * NU}, {&l->w, GAMMA ? NQ * NQ : 0}, {&l->w_r, GAMMA ? NQ * NR : 0},
        {&l->mass, ALGEBRAIC ? NQ : 0}, {&l->kept, KEPT_SIZE},
        {&l->margin, LIMITS}, {&l->margin_end, LIMITS},
        {&l->guard, EVENTS}, {&l->guard_end, EVENTS}, {&l->side, EVENTS}, {&l->ahead, EVENTS}, {&l->resting, EVENTS},
        {&l->begins, EVENTS}, {&l->fires, EVENTS}, {&l->zero, EVENTS}, {&l->reaches, EVENTS}, {&l->noise, EVENTS},
    };
    for (unsigned i = 0; i < sizeof arrays / sizeof *arrays; place += arrays[i++].size) *arrays[i].array = place;
    return place;
}

static void link_loop(mv_loop *l, mv_single *s)
{
    l->schedule = &s->schedule;
    l->model = s->model;
    l->q = s->q;
}

/* Bytes of work. */
int64_t mv_work_size(mv_single *s)
{
    mv_work w;
    link_loop(&w.loop, s);
    return (int64_t)sizeof w + (divide(&w.loop, (double *)(&w + 1)) - (double *)(&w + 1)) * (int64_t)sizeof(double);
}

/* Write the arguments of a law elsewhere for the next tick, if that is a sample. */
static void see(mv_loop *l, mv_single *s)
{
    if (!l->model.u_own || !l->alive || l->tick >= l->schedule->ticks || l->tick % l->schedule->hold_every) return;
    real e[NOISE + 1];
    mv_refer(l, l->schedule->t[l->tick]);
    mv_draw(l, MV_OF_MEASUREMENTS, l->tick / l->schedule->hold_every, NOISE, e);
    mv_call_measure(&l->model, l->q, e, s->x_seen);
    mv_copy(s->r_seen, l->r, NR);
    mv_copy(s->v_seen, l->column + U_COLUMN, NU);
    mv_copy(s->z_seen, l->column + Z_COLUMN, NZ);
}

void mv_start(mv_single *s, mv_work *w)
{
    mv_loop *l = &w->loop;
    w->single = s;
    link_loop(l, s);
    divide(l, (double *)(w + 1));
    mv_begin(l, mv_all());
    mv_copy(l->column + Z_COLUMN, s->z, NZ);
    see(l, s);
}

/* Continue until `until` ticks are done or the run ends. A law elsewhere has answered at the first of them and is due at no
 * other before `until`. */
void mv_run(mv_single *s, mv_work *w, int64_t until)
{
    mv_loop *l = &w->loop;
    while (l->alive && l->tick < until) mv_tick(l);
    s->tick = l->tick;
    s->t = l->t;
    s->error = l->error;
    s->t_stiff = l->t_stiff;
    s->steps = (int64_t)l->steps;
    s->rejected = (int64_t)l->rejected;
    s->evaluations = l->evaluations;
    s->status = (int32_t)l->status;
    s->violated = (int32_t)l->violated;
    see(l, s);
}
