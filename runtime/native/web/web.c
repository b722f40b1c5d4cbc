/* SPDX-License-Identifier: Apache-2.0 */
/* The closed loops of a model as a WebAssembly module, the simulator of a page: the loop of a single run over arrays in the
 * module's memory. Included after single.c and a header that mehvar writes for one model: sizes WEB_NAME, web_laws, and the
 * functions that web_initial and others call. The interface uses doubles and 32-bit integers. */
#define WEB_WORK ((int64_t)(sizeof(mv_work) / sizeof(double)) + 4 + (MV_STAGES + 4 + 2 * MV_KEPT) * WEB_NQ + \
                  WEB_NR + 3 * WEB_NU + 2 * WEB_NZ + WEB_NX + WEB_NY) /* as mv_work_size has it */
#define WEB_EXPORT(name) __attribute__((export_name(#name))) name

#if !__STDC_HOSTED__
/* Product of two 128-bit numbers, which compilers call for the noise; computed by 32-bit halves. */
typedef unsigned __int128 web_wide;
web_wide __multi3(web_wide a, web_wide b)
{
    const uint64_t half = 0xffffffff, x = (uint64_t)a, y = (uint64_t)b;
    const uint64_t low = (x & half) * (y & half), left = (x >> 32) * (y & half), right = (x & half) * (y >> 32);
    const uint64_t middle = (low >> 32) + (left & half) + (right & half);
    const uint64_t high = (x >> 32) * (y >> 32) + (left >> 32) + (right >> 32) + (middle >> 32) +
                          (uint64_t)(a >> 64) * y + x * (uint64_t)(b >> 64);
    return (web_wide)high << 64 | middle << 32 | (low & half);
}
#endif

static double web_p[WEB_NP + 1], web_c[WEB_NC + 1], web_s[WEB_NS + 1];
static double web_x[WEB_NX], web_q[WEB_NQ + 1], web_z[WEB_NZ + 1], web_r[WEB_NR + 1];
static double web_ticks[WEB_TICKS], web_noise[WEB_EVALUATIONS * WEB_NE + 1];
static double web_margins[WEB_MARGINS + 1], web_derived[WEB_NC + 1];
static double web_t[WEB_ROWS], web_record_x[WEB_ROWS * WEB_NX + 1], web_record_u[WEB_ROWS * WEB_NU + 1];
static double web_record_u_cmd[WEB_ROWS * WEB_NU + 1], web_record_y[WEB_ROWS * WEB_NY + 1];
static double web_record_z[WEB_ROWS * WEB_NZ + 1];
static double web_x_seen[WEB_SEEN + 1], web_r_seen[WEB_NR + 1], web_v_seen[WEB_NU + 1], web_z_seen[WEB_NZ + 1];
static double web_u_own[WEB_NU + 1], web_z_own[WEB_NZ + 1];
static double web_shown[WEB_POINTS + 1];
static double web_work[WEB_WORK];
static mv_single web_single;

/* Return the address of an array of the module; a page reads it once. */
double *WEB_EXPORT(web_array)(int32_t which)
{
    double *const arrays[] = {web_p, web_c, web_s, web_ticks, web_margins, web_derived, web_t,
                              web_record_x, web_record_u, web_record_u_cmd, web_record_y, web_record_z,
                              web_x_seen, web_r_seen, web_u_own};
    return arrays[which];
}

/* Evaluate the default formulas of a law's parameters with the present c. */
void WEB_EXPORT(web_defaults)(int32_t law)
{
    if (web_laws[law].defaults) web_laws[law].defaults(web_c, web_derived);
}

/* Margins that must be positive: the plant's constraints, the law's, the limits at the start. */
void WEB_EXPORT(web_check)(int32_t law)
{
    double *margin = web_margins;
    const double u[WEB_NU + 1] = {0.0};
    web_initial(web_p, web_s, web_x);
    web_constraints(web_p, web_s, margin);
    margin += WEB_CONSTRAINTS;
    if (web_laws[law].constraints) web_laws[law].constraints(web_p, web_c, web_s, margin);
    margin += web_laws[law].count;
    if (web_laws[law].model.limits) web_laws[law].model.limits(web_x, u, web_p, margin);
}

void WEB_EXPORT(web_start)(int32_t law, int32_t ticks, int32_t record_every, int32_t hold_every, int32_t max_steps,
                            double rtol, double atol)
{
    const double zero = 0.0;
    mv_single *s = &web_single;
    const web_law *l = &web_laws[law];
    *s = (mv_single){0};
    s->schedule = (mv_schedule){web_ticks, ticks, record_every, hold_every, max_steps, 0, rtol, atol, 0.0, 0};
    s->model = l->model;
    s->model.p = web_p, s->model.c = web_c, s->model.s = web_s, s->model.e = web_noise;
    if (l->own) s->model.u_own = web_u_own, s->model.z_own = web_z_own;
    s->x_seen = web_x_seen, s->r_seen = web_r_seen, s->v_seen = web_v_seen, s->z_seen = web_z_seen;
    s->q = web_q, s->z = web_z;
    s->record_t = web_t, s->record_x = web_record_x, s->record_u = web_record_u;
    s->record_u_cmd = web_record_u_cmd, s->record_y = web_record_y, s->record_z = web_record_z;
    web_initial(web_p, web_s, web_x);
    if (l->charted) web_to_coordinates(web_x, web_q);
    else mv_copy(web_q, web_x, WEB_NX);
    s->model.reference(&zero, web_p, web_s, web_r);
    if (l->start) l->start(web_x, web_r, web_p, web_c, web_z);
    if (!l->model.sampled) mv_copy(web_q + (l->model.nq - l->model.nz), web_z, l->model.nz);
    mv_start(s, (mv_work *)web_work);
}

/* Compute the noise for a seed; the module starts with one. */
void WEB_EXPORT(web_draw)(double seed) { mv_normals((uint64_t)seed, 0, WEB_EVALUATIONS, WEB_NE, web_noise); }

/* Continue until so many ticks are done; a law of the page has set u_own from x_seen and r_seen. Returns the number of
 * finished ticks, or -1 after the end of the run. */
int32_t WEB_EXPORT(web_run)(int32_t until)
{
    mv_run(&web_single, (mv_work *)web_work, until);
    return web_single.status == MV_DONE ? (int32_t)web_single.tick : -1;
}

/* Compute the points of the picture at a row of the run; without a picture they stay unchanged. */
double *WEB_EXPORT(web_points)(int32_t row)
{
    double r[WEB_NR + 1];
    web_single.model.reference(&web_t[row], web_p, web_s, r);
    web_geometry(&web_record_x[row * WEB_NX], &web_record_u[row * WEB_NU], r, web_p, web_shown);
    return web_shown;
}

int32_t WEB_EXPORT(web_records)(void) { return (int32_t)web_single.records; }
int32_t WEB_EXPORT(web_status)(void) { return web_single.status; }
int32_t WEB_EXPORT(web_violated)(void) { return web_single.violated; }
double WEB_EXPORT(web_time)(void) { return web_single.t; }
double WEB_EXPORT(web_steps)(void) { return (double)web_single.steps; }
