/* SPDX-License-Identifier: Apache-2.0 */
#include "integrator.h"

#include <math.h>

#include "mehvar/private/exp.h"
#include "tableaux.h"

#define SAFETY 0.85
#define SHRINK 0.2
#define GROW 10.0
#define MOST_RESERVE (4.0 / 3)

static int finite_all(const double *v, int n)
{
    double zero = 0.0;
    for (int i = 0; i < n; i++) zero += v[i] - v[i];
    return zero == 0.0;
}

static double scaled_rms(const mv_stepper *s, const double *v, const double *x)
{
    double sum = 0.0;
    for (int i = 0; i < s->n; i++) {
        const double part = v[i] / (s->atol + s->rtol * fabs(x[i]));
        sum += part * part;
    }
    return sqrt(sum / s->n);
}

static void evaluate(mv_stepper *s, mv_rhs f, double t, const double *x, double *dx, void *context)
{
    f(t, x, dx, context);
    s->evaluations++;
}

/* y = sum_j w[j] k_j, over the weights that are not zero in their order */
static void combine(const double *w, int count, const double *k, int n, double *y)
{
    int j = 0;
    while (w[j] == 0.0) j++;
    for (int i = 0; i < n; i++) y[i] = w[j] * k[j * n + i];
    for (j++; j < count; j++) {
        if (w[j] == 0.0) continue;
        for (int i = 0; i < n; i++) y[i] += w[j] * k[j * n + i];
    }
}

static void shifted(const double *x, double h, int n, double *y)
{
    for (int i = 0; i < n; i++) y[i] = x[i] + h * y[i];
}

/* Starting step: Hairer, Norsett & Wanner I, section II.4. */
static double first_step(mv_stepper *s, const double *x, double room, const mv_tableau *m, mv_rhs f, void *context)
{
    const int n = s->n;
    const double *k = s->work;
    double *probe = s->work + (MV_STAGES + 1) * n, *slope = probe + n;
    const double size = scaled_rms(s, x, x), rate = scaled_rms(s, k, x);
    double h = size < 1e-5 || rate < 1e-5 ? 1e-6 : 0.01 * size / rate;
    h = fmin(h, room);
    for (int i = 0; i < n; i++) probe[i] = x[i] + h * k[i];
    evaluate(s, f, s->t + h, probe, slope, context);
    if (!finite_all(slope, n)) return h;
    for (int i = 0; i < n; i++) slope[i] -= k[i];
    const double steepest = fmax(rate, scaled_rms(s, slope, x) / h);
    const double next = steepest <= 1e-15 ? fmax(1e-6, h * 1e-3) : mv_pow(0.01 / steepest, 1.0 / m->order);
    return fmin(100 * h, next);
}

static double weighted_square(const mv_stepper *s, const double *v, const double *x, const double *y)
{
    double sum = 0.0;
    for (int i = 0; i < s->n; i++) {
        const double weight = 1.0 / (s->atol + s->rtol * fmax(fabs(x[i]), fabs(y[i])));
        const double part = v[i] * weight;
        sum += part * part;
    }
    return sum;
}

/* Error of the step x -> y over its tolerance: the step is good when this is below one. NaN when anything is. */
static double error_ratio(const mv_stepper *s, const mv_tableau *m, double h, const double *x, const double *y,
                          double *scratch)
{
    const int n = s->n, count = m->stages + m->end_in_error;
    combine(m->e, count, s->work, n, scratch);
    const double main = weighted_square(s, scratch, x, y);
    if (!m->e3) return h * sqrt(main / n);
    combine(m->e3, count, s->work, n, scratch);
    const double third = weighted_square(s, scratch, x, y);
    if (main == 0.0 && third == 0.0) return 0.0;
    return h * main / sqrt((main + 0.01 * third) * n);
}

/* One trial step x -> y; returns the error ratio (0 for a fixed step), or NaN when the step leaves the finite. */
static double try_step(mv_stepper *s, const mv_tableau *m, const double *x, double *y, double h, int want_end, mv_rhs f,
                       void *context)
{
    const int n = s->n;
    double *k = s->work, *stage = k + (MV_STAGES + 1) * n, *end = k + m->stages * n;
    for (int i = 1; i < m->stages; i++) {
        combine(m->a[i], i, k, n, stage);
        shifted(x, h, n, stage);
        evaluate(s, f, s->t + m->c[i] * h, stage, k + i * n, context);
    }
    combine(m->b, m->stages, k, n, y);
    shifted(x, h, n, y);
    if (!finite_all(y, n)) return NAN;
    if (m->end_in_error) evaluate(s, f, s->t + h, y, end, context);
    const double ratio = m->order ? error_ratio(s, m, h, x, y, stage) : 0.0;
    if (!(ratio <= 1.0) || !want_end) return ratio;
    if (!m->end_in_error) evaluate(s, f, s->t + h, y, end, context);
    return finite_all(end, n) ? ratio : NAN;
}

/* Step size control: Gustafsson's proportional and integral one, Hairer, Norsett & Wanner I and II, sections II.4 and
 * IV.2. The reserve of a step, ratio^(-1/(4 order)), is above one when the step could have been longer; its fourth
 * power is what the step may grow by. A good step grows by three of them less that of the step before. */
static double reserve(double ratio, int order)
{
    if (ratio == 0.0) return INFINITY;
    return isfinite(ratio) ? mv_pow(ratio, -0.25 / order) : 0.0;
}

static double within_bounds(double factor) { return fmin(GROW, fmax(SHRINK, SAFETY * factor)); }

int mv_advance(mv_stepper *s, double *x, double target, mv_rhs f, mv_accept accept, void *context)
{
    const mv_tableau *m = &mv_tableaux[s->method];
    const int n = s->n;
    double *k = s->work, *y = k + (MV_STAGES + 2) * n;
    if (s->t >= target) return MV_DONE;
    if (!s->ready) evaluate(s, f, s->t, x, k, context);
    s->ready = 1;
    if (!finite_all(k, n)) return MV_NOT_FINITE;
    if (!m->order)
        s->h = (target - s->t) / ceil((target - s->t) / s->step * (1 - 1e-12));
    else if (s->h == 0.0)
        s->h = first_step(s, x, target - s->t, m, f, context);

    int bounded = 0; /* the previous trial of this step failed: do not grow */
    for (int64_t trial = 0; s->t < target; trial++) {
        if (trial == s->max_steps) return MV_TOO_MANY_STEPS;
        const double room = target - s->t;
        const int last = 1.01 * s->h >= room;
        const double h = last ? room : s->h;
        const int want_end = !(last && s->held);
        const double ratio = try_step(s, m, x, y, h, want_end, f, context);
        if (!(ratio <= 1.0)) {
            s->rejected++;
            bounded = 1;
            if (!m->order) return MV_NOT_FINITE;
            const double r = reserve(ratio, m->order);
            s->h = h * fmin(1.0, within_bounds(r * r * r * r));
            if (s->h < 10 * (nextafter(s->t, INFINITY) - s->t))
                return isfinite(ratio) ? MV_STEP_UNDERFLOW : MV_NOT_FINITE;
            continue;
        }
        s->accepted++;
        s->t = last ? target : s->t + h;
        for (int i = 0; i < n; i++) x[i] = y[i];
        for (int i = 0; i < n; i++) k[i] = k[m->stages * n + i];
        if (m->order) {
            const double r = reserve(ratio, m->order);
            const double factor = fmin(bounded ? 1.0 : GROW, within_bounds(r * r * r / s->reserve));
            const int cut = h < s->h; /* short by the target, which says nothing against the longer step */
            s->h = cut && factor >= 1.0 ? fmax(s->h, h * factor) : h * factor;
            if (!cut) s->reserve = fmin(r, MOST_RESERVE);
        }
        bounded = 0;
        const enum mv_verdict verdict = accept ? accept(x, context) : MV_GO_ON;
        if (verdict == MV_STOP) return MV_LIMIT;
        if (verdict == MV_MOVED) evaluate(s, f, s->t, x, k, context);
    }
    if (s->held) s->ready = 0;
    return MV_DONE;
}
