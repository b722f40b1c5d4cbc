/* SPDX-License-Identifier: Apache-2.0 */
/* The least that dop853 needs in lanes: what the batch kernel is measured against.
 *
 * The right-hand side is the generated one, the coefficients, the error estimate and the step control are the product's,
 * and so are trials and final states, bit for bit. Nothing is sampled, summed up, limited, drawn or watched; there is one
 * method, one way in and one way out, and nothing but this file between them. */
#include "kernel.h"

typedef struct {
    real p[NP + 1], c[NC + 1], s[NS + 1];
    CONSTANTS
} mv_model;

#include "calls.h"

typedef struct {
    int64_t runs;
    double t_end, rtol, atol;
    const double *p, *c, *s, *x0, *u;
    double *final, *steps, *evaluations; /* steps of each run, slopes of each block */
} job;

static int any(mask m)
{
    int found = 0;
    for (int lane = 0; lane < MEHVAR_LANES; lane++) found |= m[lane] != 0;
    return found;
}

#if SAMPLED
#define SLOPE(q, dq) mv_call_rhs(m, q, input, dq)
#else
#define SLOPE(q, dq) mv_call_loop(m, q, input, dq) /* the input of a loop is its reference */
#endif

/* for its instructions to be counted and timed; elsewhere the compiler does as it likes */
__attribute__((noinline)) void bare_slope(const mv_model *m, const real *q, const real *input, real *dq) { SLOPE(q, dq); }

static void gather(const job *j, int64_t first, const double *rows, int width, real *to)
{
    for (int lane = 0; lane < MEHVAR_LANES; lane++) {
        const int64_t run = first + lane < j->runs ? first + lane : j->runs - 1;
        for (int i = 0; i < width; i++) to[i][lane] = rows[run * width + i];
    }
}

static void scatter(const job *j, int64_t first, const real *from, int width, double *rows)
{
    for (int lane = 0; lane < MEHVAR_LANES && first + lane < j->runs; lane++)
        for (int i = 0; i < width; i++) rows[(first + lane) * width + i] = from[i][lane];
}

static real rms(const job *j, const real *v, const real *x)
{
    real sum = SPLAT(0);
    for (int i = 0; i < NQ; i++) {
        const real part = v[i] / (K(j->atol) + K(j->rtol) * mv_fabs(x[i]));
        sum += part * part;
    }
    return mv_sqrt(sum / K(NQ));
}

static real first_step(const job *j, const mv_model *m, const real *input, const real *q, const real *slope, real room)
{
    real probe[NQ], change[NQ];
    const real size = rms(j, q, q), rate = rms(j, slope, q);
    const real small = SELECT(OR(LT(size, K(1e-5)), LT(rate, K(1e-5))), SPLAT(1e-6), K(0.01) * size / rate);
    const real h = mv_min(small, room);
    for (int i = 0; i < NQ; i++) probe[i] = q[i] + h * slope[i];
    SLOPE(probe, change);
    for (int i = 0; i < NQ; i++) change[i] -= slope[i];
    const real steepest = mv_max(rate, rms(j, change, q) / h);
    const real next = mv_pow(K(0.01) / steepest, SPLAT(1.0 / ORDER));
    return mv_min(K(100) * h, SELECT(LE(steepest, K(1e-15)), mv_max(SPLAT(1e-6), h * K(1e-3)), next));
}

/* Error of the step over its tolerance: both estimates of dop853. */
static inline real error_ratio(const job *j, const real *q, const real *y, const real (*k)[NQ], real h)
{
    real main = SPLAT(0), third = SPLAT(0);
    for (int i = 0; i < NQ; i++) {
        const real a = mv_fabs(q[i]), b = mv_fabs(y[i]);
        const real weight = K(1) / (K(j->atol) + K(j->rtol) * SELECT(LT(a, b), b, a));
        const real e = (ERROR_SUM) * weight, e3 = (THIRD_ERROR_SUM) * weight;
        main += e * e;
        third += e3 * e3;
    }
    const real ratio = h * main / mv_sqrt((main + K(0.01) * third) * K(NQ));
    return SELECT(AND(EQ(main, K(0)), EQ(third, K(0))), SPLAT(0), ratio);
}

static inline real bounded(real factor) { return mv_min(SPLAT(10), mv_max(SPLAT(0.2), K(0.85) * factor)); }

#define STAGE(s, c, sum)                                                                                             \
    for (int i = 0; i < NQ; i++) stage[i] = q[i] + h * (sum);                                                        \
    SLOPE(stage, k[s]);

static void integrate(const job *j, const mv_model *m, const real *input, real *q, real *steps, double *evaluations)
{
    real k[STAGES][NQ], y[NQ], stage[NQ], t = SPLAT(0), reserve = SPLAT(1);
    mask after_refusal = LT(t, t), open = LT(t, K(j->t_end));
    SLOPE(q, k[0]);
    real next = first_step(j, m, input, q, k[0], j->t_end - t);
    *steps = SPLAT(0);
    *evaluations = 2;
    while (any(open)) {
        const real room = j->t_end - t;
        const mask last = LE(room, K(1.01) * next);
        const real h = SELECT(last, room, next);
        STAGE_SUMS
        for (int i = 0; i < NQ; i++) y[i] = q[i] + h * (END_SUM);
        const real ratio = error_ratio(j, q, y, (const real(*)[NQ])k, h);
        const mask taken = AND(open, LE(ratio, K(1)));
#if PROJECTED
        mv_call_project(m, y, stage);
        mv_copy(y, stage, NQ);
#endif
        if (any(AND(taken, NOT(last)))) {
            SLOPE(y, stage);
            *evaluations += 1;
            for (int i = 0; i < NQ; i++) k[0][i] = SELECT(taken, stage[i], k[0][i]);
        }
        for (int i = 0; i < NQ; i++) q[i] = SELECT(taken, y[i], q[i]);
        t = SELECT(taken, SELECT(last, SPLAT(j->t_end), t + h), t);
        *steps += SELECT0(taken, SPLAT(1));
        *evaluations += STAGES - 1;

        const real root = SELECT(EQ(ratio, K(0)), SPLAT(MV_INFINITY), mv_pow(ratio, SPLAT(-0.25 / ORDER)));
        const real cube = root * root * root;
        const real factor = mv_min(SELECT(after_refusal, SPLAT(1), SPLAT(10)), bounded(cube / reserve));
        const mask cut = LT(h, next), refused = AND(open, NOT(taken));
        const real longer = SELECT(AND(cut, LE(K(1), factor)), mv_max(next, h * factor), h * factor);
        const real retry = h * mv_min(SPLAT(1), bounded(cube * root));
        next = SELECT(taken, longer, SELECT(refused, retry, next));
        reserve = SELECT(AND(taken, NOT(cut)), mv_min(root, SPLAT(4.0 / 3)), reserve);
        after_refusal = OR(refused, AND(after_refusal, NOT(taken)));
        open = LT(t, K(j->t_end));
    }
}

void bare_run(const job *j)
{
    for (int64_t first = 0; first < j->runs; first += MEHVAR_LANES) {
        mv_model m_, *m = &m_;
        real x[NX], q[NQ], u[NU + 1], r[NR + 1], steps;
        gather(j, first, j->p, NP, m->p);
        gather(j, first, j->c, NC, m->c);
        gather(j, first, j->s, NS, m->s);
        gather(j, first, j->x0, NX, x);
        gather(j, first, j->u, NU, u);
        mv_call_reference(m, SPLAT(0), r);
        BARE_PREPARE;
        CALL_HOLD;
        CALL_TO_COORDINATES;
        integrate(j, m, SAMPLED ? u : r, q, &steps, j->evaluations + first / MEHVAR_LANES);
        CALL_FROM_COORDINATES;
        scatter(j, first, x, NX, j->final);
        scatter(j, first, &steps, 1, j->steps);
    }
}

/* The right-hand side alone, `calls` times at the start of the first block. */
void bare_slopes(const job *j, int64_t calls)
{
    mv_model m_, *m = &m_;
    real x[NX], q[NQ], u[NU + 1], r[NR + 1], dq[NQ];
    gather(j, 0, j->p, NP, m->p);
    gather(j, 0, j->c, NC, m->c);
    gather(j, 0, j->s, NS, m->s);
    gather(j, 0, j->x0, NX, x);
    gather(j, 0, j->u, NU, u);
    mv_call_reference(m, SPLAT(0), r);
    BARE_PREPARE;
    CALL_HOLD;
    CALL_TO_COORDINATES;
    for (int64_t i = 0; i < calls; i++) bare_slope(m, q, SAMPLED ? u : r, dq);
}

/* What the processor does of one kind: `count` times CHAINS of them that do not wait for each other. */
#define CHAINS 12
#define RATE(name, operation)                                                                                        \
    double name(int64_t count)                                                                                       \
    {                                                                                                                \
        real x[CHAINS];                                                                                              \
        for (int i = 0; i < CHAINS; i++) x[i] = SPLAT(1.5 + i);                                                      \
        for (int64_t n = 0; n < count; n++) {                                                                        \
            _Pragma("GCC unroll 12") for (int i = 0; i < CHAINS; i++) x[i] = operation;                              \
        }                                                                                                            \
        for (int i = 1; i < CHAINS; i++) x[0] += x[i];                                                               \
        return x[0][0];                                                                                              \
    }
RATE(bare_products, x[i] * K(0.999) + K(0.5)) /* one product and one sum each */
RATE(bare_quotients, K(2) / x[i])
RATE(bare_roots, mv_sqrt(x[i]))

/* As many sums that wait for each other, one in each cycle. */
int64_t bare_cycles(int64_t count)
{
    int64_t sum = 0;
    for (int64_t n = 0; n < count / 16; n++) {
        _Pragma("GCC unroll 16") for (int i = 0; i < 16; i++) __asm__ volatile("add $1, %0" : "+r"(sum));
    }
    return sum;
}
