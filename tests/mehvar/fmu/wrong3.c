/* SPDX-License-Identifier: Apache-2.0 */
/* Wrong calls by FMI 3.0 are answered by the status Error, and leave an instance as it was. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "fmi3Functions.h"

#define VALUES 20
#define UNKNOWN 100000u
#define EXPECT(call, status)                                                                                         \
    do {                                                                                                             \
        if ((call) != (status)) return printf("%s\n", #call), 1;                                                     \
    } while (0)
#define FINE(call) EXPECT(call, fmi3OK)
#define REFUSED(call) EXPECT(call, fmi3Error)

static unsigned references[VALUES];

static fmi3Status step(fmi3Instance c, double t, double h)
{
    fmi3Boolean events, terminate, early;
    double last;
    return fmi3DoStep(c, t, h, 1, &events, &terminate, &early, &last);
}

static int steps(fmi3Instance c, int wrongly, double *values)
{
    fmi3FMUState state = 0;
    const unsigned unknown = UNKNOWN;
    size_t size = 0;
    double value = 0;
    fmi3Boolean flag;
    if (wrongly) {
        REFUSED(step(c, 0, 0.125));
        REFUSED(fmi3ExitInitializationMode(c));
        REFUSED(fmi3Terminate(c));
        REFUSED(fmi3EnterInitializationMode(c, 0, 0, 0, 1, -1));
        REFUSED(fmi3EnterInitializationMode(c, 1, -1, 0, 0, 0));
        REFUSED(fmi3EnterConfigurationMode(c));
    }
    FINE(fmi3EnterInitializationMode(c, 0, 0, 0, 1, 0.5));
    if (wrongly) {
        REFUSED(fmi3EnterInitializationMode(c, 0, 0, 0, 1, 0.5));
        REFUSED(step(c, 0, 0.125));
    }
    FINE(fmi3ExitInitializationMode(c));
    for (int k = 0; k < 4; k++) {
        if (wrongly) {
            REFUSED(step(c, k * 0.125, -0.125));
            REFUSED(step(c, k * 0.125, 0));
            REFUSED(step(c, k * 0.125, NAN));
            REFUSED(step(c, k * 0.125, 1));
            REFUSED(step(c, k * 0.125 + 0.0625, 0.125));
            REFUSED(step(0, k * 0.125, 0.125));
            REFUSED(fmi3DoStep(c, k * 0.125, 0.125, 1, 0, &flag, &flag, &value));
            REFUSED(fmi3DoStep(c, k * 0.125, 0.125, 1, &flag, &flag, &flag, 0));
            REFUSED(fmi3ExitInitializationMode(c));
            REFUSED(fmi3EnterEventMode(c));
            REFUSED(fmi3EnterStepMode(c));
            REFUSED(fmi3SetTime(c, 0));
            REFUSED(fmi3GetFloat64(c, &unknown, 1, &value, 1));
            REFUSED(fmi3SetFloat64(c, &unknown, 1, &value, 1));
            REFUSED(fmi3GetFloat64(c, references, 2, &value, 1));
            REFUSED(fmi3SetFloat64(c, references, 2, &value, 1));
            REFUSED(fmi3GetFloat64(c, 0, 1, &value, 1));
            REFUSED(fmi3GetFloat64(c, references, 1, 0, 1));
            REFUSED(fmi3SetFloat64(c, references, 1, 0, 1));
            REFUSED(fmi3GetInt32(c, references, 1, 0, 1));
            REFUSED(fmi3GetDirectionalDerivative(c, &unknown, 1, references, 1, &value, 1, &value, 1));
            REFUSED(fmi3GetDirectionalDerivative(c, references, 1, references, 1, &value, 2, &value, 1));
            REFUSED(fmi3GetDirectionalDerivative(c, references, 1, references, 1, 0, 1, 0, 1));
            REFUSED(fmi3GetFMUState(c, 0));
            REFUSED(fmi3SetFMUState(c, 0));
            REFUSED(fmi3SerializedFMUStateSize(c, 0, &size));
            FINE(fmi3GetFMUState(c, &state));
            REFUSED(fmi3SerializedFMUStateSize(c, state, 0));
            FINE(fmi3SerializedFMUStateSize(c, state, &size));
            REFUSED(fmi3SerializeFMUState(c, state, 0, size));
            REFUSED(fmi3SerializeFMUState(c, state, (fmi3Byte *)&value, sizeof value));
            REFUSED(fmi3DeserializeFMUState(c, (fmi3Byte *)&value, sizeof value, &state));
            REFUSED(fmi3DeserializeFMUState(c, 0, size, &state));
            FINE(fmi3FreeFMUState(c, &state));
        }
        FINE(step(c, k * 0.125, 0.125));
    }
    if (wrongly) REFUSED(step(c, 0.5, 0.125)); /* past the stop time */
    return fmi3GetFloat64(c, references, VALUES, values, VALUES) != fmi3OK;
}

static fmi3Status update(fmi3Instance e)
{
    fmi3Boolean again, terminate, nominals, values, next_defined;
    double next;
    return fmi3UpdateDiscreteStates(e, &again, &terminate, &nominals, &values, &next_defined, &next);
}

static int exchange(fmi3Instance e)
{
    fmi3Boolean event, terminate;
    double value = 0;
    REFUSED(update(e));
    REFUSED(fmi3EnterContinuousTimeMode(e));
    FINE(fmi3EnterInitializationMode(e, 0, 0, 0, 0, 0));
    FINE(fmi3ExitInitializationMode(e));
    REFUSED(fmi3UpdateDiscreteStates(e, 0, &event, &event, &event, &event, &value));
    REFUSED(fmi3UpdateDiscreteStates(e, &event, &event, &event, &event, &event, 0));
    REFUSED(fmi3CompletedIntegratorStep(e, 1, &event, &terminate));
    FINE(update(e));
    FINE(fmi3EnterContinuousTimeMode(e));
    REFUSED(fmi3EnterContinuousTimeMode(e));
    REFUSED(update(e));
    REFUSED(fmi3CompletedIntegratorStep(e, 1, &event, 0));
    REFUSED(fmi3SetContinuousStates(e, &value, 1));
    REFUSED(fmi3SetContinuousStates(e, 0, STATES));
    REFUSED(fmi3GetContinuousStates(e, &value, 1));
    REFUSED(fmi3GetContinuousStates(e, 0, STATES));
    REFUSED(fmi3GetContinuousStateDerivatives(e, 0, STATES));
    REFUSED(fmi3GetNominalsOfContinuousStates(e, 0, STATES));
    REFUSED(fmi3GetEventIndicators(e, &value, UNKNOWN));
    REFUSED(fmi3GetNumberOfContinuousStates(e, 0));
    REFUSED(fmi3GetNumberOfEventIndicators(e, 0));
    REFUSED(step(e, 0, 0.125));
    FINE(fmi3CompletedIntegratorStep(e, 1, &event, &terminate));
    FINE(fmi3EnterEventMode(e));
    REFUSED(fmi3EnterEventMode(e));
    return 0;
}

int main(int count, char **arguments)
{
    double right[VALUES], wrong[VALUES];
    if (count < 2) return 1;
    for (unsigned k = 0; k < VALUES; k++) references[k] = k;
    if (fmi3InstantiateCoSimulation("unit", "another", "", 0, 0, 0, 0, 0, 0, 0, 0, 0)) return 2;
    if (fmi3InstantiateModelExchange("unit", 0, "", 0, 0, 0, 0)) return 2;
    fmi3Instance c = fmi3InstantiateCoSimulation("unit", arguments[1], "", 0, 0, 0, 0, 0, 0, 0, 0, 0);
    fmi3Instance e = fmi3InstantiateModelExchange("unit", arguments[1], "", 0, 0, 0, 0);
    if (!c || !e || steps(c, 0, right)) return 3;
    fmi3Reset(c);
    if (steps(c, 1, wrong) || memcmp(right, wrong, sizeof right)) return 4;
    if (exchange(e)) return 5;
    fmi3FreeInstance(c);
    fmi3FreeInstance(e);
    fmi3FreeInstance(0);
    printf("refused\n");
    return 0;
}
