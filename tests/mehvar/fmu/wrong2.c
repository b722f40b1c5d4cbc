/* SPDX-License-Identifier: Apache-2.0 */
/* Wrong calls by FMI 2.0 are answered by the status Error, and leave an instance as it was. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "fmi2Functions.h"

#define VALUES 20
#define UNKNOWN 100000u
#define EXPECT(call, status)                                                                                         \
    do {                                                                                                             \
        if ((call) != (status)) return printf("%s\n", #call), 1;                                                     \
    } while (0)
#define FINE(call) EXPECT(call, fmi2OK)
#define REFUSED(call) EXPECT(call, fmi2Error)

static unsigned references[VALUES];

static int steps(fmi2Component c, int wrongly, double *values)
{
    fmi2FMUstate state = 0;
    const unsigned unknown = UNKNOWN;
    size_t size = 0;
    double value = 0;
    if (wrongly) {
        REFUSED(fmi2DoStep(c, 0, 0.125, 1));
        REFUSED(fmi2ExitInitializationMode(c));
        REFUSED(fmi2Terminate(c));
        REFUSED(fmi2SetupExperiment(c, 0, 0, 0, 1, -1));
        REFUSED(fmi2SetupExperiment(c, 1, -1, 0, 0, 0));
    }
    FINE(fmi2SetupExperiment(c, 0, 0, 0, 1, 0.5));
    FINE(fmi2EnterInitializationMode(c));
    if (wrongly) {
        REFUSED(fmi2EnterInitializationMode(c));
        REFUSED(fmi2DoStep(c, 0, 0.125, 1));
    }
    FINE(fmi2ExitInitializationMode(c));
    for (int k = 0; k < 4; k++) {
        if (wrongly) {
            REFUSED(fmi2DoStep(c, k * 0.125, -0.125, 1));
            REFUSED(fmi2DoStep(c, k * 0.125, 0, 1));
            REFUSED(fmi2DoStep(c, k * 0.125, NAN, 1));
            REFUSED(fmi2DoStep(c, k * 0.125, 1, 1));
            REFUSED(fmi2DoStep(c, k * 0.125 + 0.0625, 0.125, 1));
            REFUSED(fmi2DoStep(0, k * 0.125, 0.125, 1));
            REFUSED(fmi2ExitInitializationMode(c));
            REFUSED(fmi2EnterEventMode(c));
            REFUSED(fmi2SetTime(c, 0));
            REFUSED(fmi2GetReal(c, &unknown, 1, &value));
            REFUSED(fmi2SetReal(c, &unknown, 1, &value));
            REFUSED(fmi2GetReal(c, 0, 1, &value));
            REFUSED(fmi2GetReal(c, references, 1, 0));
            REFUSED(fmi2SetReal(c, references, 1, 0));
            REFUSED(fmi2GetDirectionalDerivative(c, &unknown, 1, references, 1, &value, &value));
            REFUSED(fmi2GetDirectionalDerivative(c, references, 1, references, 1, 0, 0));
            REFUSED(fmi2GetFMUstate(c, 0));
            REFUSED(fmi2SetFMUstate(c, 0));
            REFUSED(fmi2SerializedFMUstateSize(c, 0, &size));
            FINE(fmi2GetFMUstate(c, &state));
            REFUSED(fmi2SerializedFMUstateSize(c, state, 0));
            FINE(fmi2SerializedFMUstateSize(c, state, &size));
            REFUSED(fmi2SerializeFMUstate(c, state, 0, size));
            REFUSED(fmi2SerializeFMUstate(c, state, (fmi2Byte *)&value, sizeof value));
            REFUSED(fmi2DeSerializeFMUstate(c, (fmi2Byte *)&value, sizeof value, &state));
            FINE(fmi2FreeFMUstate(c, &state));
            REFUSED(fmi2GetRealStatus(c, fmi2LastSuccessfulTime, 0));
            REFUSED(fmi2GetBooleanStatus(c, fmi2Terminated, 0));
            REFUSED(fmi2CancelStep(c));
        }
        FINE(fmi2DoStep(c, k * 0.125, 0.125, 1));
    }
    if (wrongly) REFUSED(fmi2DoStep(c, 0.5, 0.125, 1)); /* past the stop time */
    return fmi2GetReal(c, references, VALUES, values) != fmi2OK;
}

static int exchange(fmi2Component c)
{
    fmi2EventInfo info;
    fmi2Boolean event, terminate;
    double value = 0;
    FINE(fmi2SetupExperiment(c, 0, 0, 0, 0, 0));
    REFUSED(fmi2NewDiscreteStates(c, &info));
    REFUSED(fmi2EnterContinuousTimeMode(c));
    FINE(fmi2EnterInitializationMode(c));
    FINE(fmi2ExitInitializationMode(c));
    REFUSED(fmi2NewDiscreteStates(c, 0));
    REFUSED(fmi2CompletedIntegratorStep(c, 1, &event, &terminate));
    FINE(fmi2NewDiscreteStates(c, &info));
    FINE(fmi2EnterContinuousTimeMode(c));
    REFUSED(fmi2EnterContinuousTimeMode(c));
    REFUSED(fmi2NewDiscreteStates(c, &info));
    REFUSED(fmi2CompletedIntegratorStep(c, 1, 0, &terminate));
    REFUSED(fmi2SetContinuousStates(c, &value, 1));
    REFUSED(fmi2SetContinuousStates(c, 0, STATES));
    REFUSED(fmi2GetContinuousStates(c, &value, 1));
    REFUSED(fmi2GetContinuousStates(c, 0, STATES));
    REFUSED(fmi2GetDerivatives(c, 0, STATES));
    REFUSED(fmi2GetNominalsOfContinuousStates(c, 0, STATES));
    REFUSED(fmi2GetEventIndicators(c, &value, UNKNOWN));
    REFUSED(fmi2DoStep(c, 0, 0.125, 1));
    FINE(fmi2CompletedIntegratorStep(c, 1, &event, &terminate));
    FINE(fmi2EnterEventMode(c));
    REFUSED(fmi2EnterEventMode(c));
    return 0;
}

int main(int count, char **arguments)
{
    const fmi2CallbackFunctions functions = {0, 0, 0, 0, 0};
    double right[VALUES], wrong[VALUES];
    if (count < 2) return 1;
    for (unsigned k = 0; k < VALUES; k++) references[k] = k;
    if (fmi2Instantiate("unit", fmi2CoSimulation, "another", "", &functions, 0, 0)) return 2;
    if (fmi2Instantiate("unit", fmi2CoSimulation, 0, "", &functions, 0, 0)) return 2;
    fmi2Component c = fmi2Instantiate("unit", fmi2CoSimulation, arguments[1], "", &functions, 0, 0);
    fmi2Component e = fmi2Instantiate("unit", fmi2ModelExchange, arguments[1], "", 0, 0, 0);
    if (!c || !e || steps(c, 0, right)) return 3;
    fmi2Reset(c);
    if (steps(c, 1, wrong) || memcmp(right, wrong, sizeof right)) return 4;
    if (exchange(e)) return 5;
    fmi2FreeInstance(c);
    fmi2FreeInstance(e);
    fmi2FreeInstance(0);
    printf("refused\n");
    return 0;
}
