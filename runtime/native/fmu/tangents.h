/* SPDX-License-Identifier: Apache-2.0 */
/* Derivatives of a unit's values along a change of parameters, inputs and states, by its code for dual numbers. */
#include "values.h"

void fmu_tangents(const double *v, const double *applied, int due, int starts, const double *along, double *change);

void fmu_tangents(const double *v, const double *applied, int due, int starts, const double *along, double *change)
{
    mv_model m;
    mv_real dual[FMU_VALUES], u[FMU_NU + 1] = {0};
    for (int k = 0; k < FMU_VALUES; k++) dual[k] = mv_dual(v[k], TINY, along[k]);
    for (int k = 0; k < FMU_NU; k++) u[k] = applied[k];
    fmu_functions(&m);
    fmu_parameters(&m, dual);
    if (starts) fmu_remember(&m, dual);
    fmu_follow(&m, dual, u, due);
    for (int k = 0; k < FMU_VALUES; k++) change[k] = __imag__ dual[k] / TINY;
}
