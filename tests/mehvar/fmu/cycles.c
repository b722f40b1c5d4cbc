/* SPDX-License-Identifier: Apache-2.0 */
/* Instances that come and go, go on from a copied state, are called wrongly and are reset: the same numbers each time. */
#include <stdio.h>
#include <string.h>

#include "fmi2Functions.h"

#define VALUES 20
#define CYCLES 10000

static void say(fmi2ComponentEnvironment e, fmi2String name, fmi2Status s, fmi2String category, fmi2String text, ...)
{
    (void)e, (void)name, (void)s, (void)category, (void)text;
}

static int run(fmi2Component c, double *values)
{
    fmi2ValueReference references[VALUES];
    fmi2FMUstate state = 0;
    for (unsigned k = 0; k < VALUES; k++) references[k] = k;
    fmi2SetupExperiment(c, 0, 0, 0, 0, 0);
    fmi2EnterInitializationMode(c);
    fmi2ExitInitializationMode(c);
    for (int k = 0; k < 3; k++)
        if (fmi2DoStep(c, k * 0.125, 0.125, 1) != fmi2OK) return 2;
    fmi2GetFMUstate(c, &state);
    fmi2DoStep(c, 0.375, 0.125, 1);
    fmi2SetFMUstate(c, state);
    fmi2FreeFMUstate(c, &state);
    if (fmi2DoStep(c, 0.375, 0.125, 1) != fmi2OK) return 3;
    if (fmi2DoStep(c, -1, 0.1, 1) != fmi2Error || fmi2DoStep(c, 0.5, -1, 1) != fmi2Error) return 4;
    return fmi2GetReal(c, references, VALUES, values) != fmi2OK;
}

int main(int count, char **arguments)
{
    const fmi2CallbackFunctions functions = {say, 0, 0, 0, 0};
    double first[VALUES], values[VALUES];
    if (count < 2) return 1;
    for (int cycle = 0; cycle < CYCLES; cycle++) {
        fmi2Component c = fmi2Instantiate("unit", fmi2CoSimulation, arguments[1], "", &functions, 0, 0);
        if (!c) return 1;
        for (int again = 0; again < 2; again++) {
            const int failed = run(c, values);
            if (failed) return failed;
            if (!cycle && !again) memcpy(first, values, sizeof first);
            if (memcmp(first, values, sizeof first)) return 5;
            fmi2Reset(c);
        }
        fmi2FreeInstance(c);
    }
    printf("%d cycles\n", CYCLES);
    return 0;
}
