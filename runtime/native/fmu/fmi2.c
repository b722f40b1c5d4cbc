/* SPDX-License-Identifier: Apache-2.0 */
/* FMI 2.0 for model exchange and co-simulation. */
#include "fmi2Functions.h"

#include "core.h"

#define INSTANCE fmu_instance *i = (fmu_instance *)c
#define NEED(condition, message)                                                                                     \
    if (!i) return fmi2Error;                                                                                        \
    if (!(condition)) return fmu_fail(i, FMU_ERROR, message), fmi2Error
#define NOT_HERE(text) fmu_fail(i, FMU_ERROR, text " is not supported"), fmi2Error

static fmi2Status status_of(enum fmu_status s) { return s == FMU_OK ? fmi2OK : s == FMU_DISCARD ? fmi2Discard : fmi2Error; }

static void say(void *instance, const char *message)
{
    const fmi2CallbackFunctions *f = ((fmu_instance *)instance)->environment;
    if (f && f->logger) f->logger(f->componentEnvironment, "mehvar", fmi2Error, "logStatusError", message);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[])
{
    (void)on, (void)n, (void)categories;
    return c ? fmi2OK : fmi2Error;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String place,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)name, (void)place, (void)visible, (void)logging;
    if (!guid || strcmp(guid, FMU_TOKEN) != 0) return 0;
    return fmu_new(type == fmi2ModelExchange, (void *)functions, say);
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean stop_defined, fmi2Real stop)
{
    INSTANCE;
    NEED(i->mode == FMU_INSTANTIATED, "setupExperiment comes first");
    NEED(!stop_defined || stop >= start, "the stop time is before the start");
    NEED(!tolerance_defined || tolerance > 0, "the tolerance must be positive");
    if (tolerance_defined) i->single.schedule.rtol = tolerance;
    i->start = i->v[FMU_V_T] = start, i->stop = stop, i->stop_defined = stop_defined;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    INSTANCE;
    NEED(i->mode == FMU_INSTANTIATED, "initialization begins once");
    i->mode = FMU_INITIALIZING;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    INSTANCE;
    NEED(i->mode == FMU_INITIALIZING, "initialization has not begun");
    return status_of(fmu_begin(i));
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    INSTANCE;
    NEED(i->mode > FMU_INITIALIZING, "nothing runs");
    i->mode = FMU_TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    INSTANCE;
    NEED(1, "");
    fmu_reset(i);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real values[])
{
    INSTANCE;
    NEED(1, "");
    return status_of(fmu_get(i, r, n, values));
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real values[])
{
    INSTANCE;
    NEED(1, "");
    return status_of(fmu_set(i, r, n, values));
}

#define NO_VALUES(kind, type)                                                                                        \
    fmi2Status fmi2Get##kind(fmi2Component c, const fmi2ValueReference r[], size_t n, type values[])                 \
    {                                                                                                                \
        INSTANCE;                                                                                                    \
        (void)r, (void)values;                                                                                       \
        NEED(n == 0, "all variables are real");                                                                      \
        return fmi2OK;                                                                                               \
    }                                                                                                                \
    fmi2Status fmi2Set##kind(fmi2Component c, const fmi2ValueReference r[], size_t n, const type values[])           \
    {                                                                                                                \
        INSTANCE;                                                                                                    \
        (void)r, (void)values;                                                                                       \
        NEED(n == 0, "all variables are real");                                                                      \
        return fmi2OK;                                                                                               \
    }
NO_VALUES(Integer, fmi2Integer)
NO_VALUES(Boolean, fmi2Boolean)
NO_VALUES(String, fmi2String)

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    INSTANCE;
    NEED(state, "no place for the state");
    if (!*state) *state = calloc(1, sizeof(fmu_instance));
    NEED(*state, "no memory");
    fmu_copy(*state, i);
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    INSTANCE;
    NEED(state, "no state");
    fmu_copy(i, state);
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    INSTANCE;
    NEED(1, "");
    if (state) free(*state), *state = 0;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    INSTANCE;
    NEED(state && size, "no state");
    *size = sizeof(fmu_instance);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    INSTANCE;
    NEED(state && bytes && size >= sizeof(fmu_instance), "no state, or too few bytes for it");
    memcpy(bytes, state, sizeof(fmu_instance));
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    INSTANCE;
    NEED(state && bytes && size == sizeof(fmu_instance), "these bytes are no state of this FMU");
    fmu_instance *copy = calloc(1, sizeof *copy);
    NEED(copy, "no memory");
    memcpy(copy, bytes, sizeof *copy);
    copy->environment = i->environment, copy->log = i->log;
    fmu_restore(copy);
    *state = copy;
    return fmi2OK;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[], size_t nu,
                                        const fmi2ValueReference knowns[], size_t nk, const fmi2Real seed[],
                                        fmi2Real sensitivity[])
{
    INSTANCE;
    NEED(1, "");
    return status_of(fmu_directional(i, unknowns, nu, knowns, nk, seed, sensitivity));
}

/* model exchange */

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    INSTANCE;
    NEED(i->exchange && i->mode == FMU_CONTINUOUS, "events come from continuous time");
    i->mode = FMU_EVENTS;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info)
{
    INSTANCE;
    NEED(i->exchange && i->mode == FMU_EVENTS, "discrete states change in events");
    NEED(info, FMU_NULL);
    fmu_event(i);
    memset(info, 0, sizeof *info);
    info->terminateSimulation = i->terminated;
    info->valuesOfContinuousStatesChanged = i->reset;
    info->nextEventTimeDefined = FMU_KIND == 2;
    info->nextEventTime = i->next_event;
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    INSTANCE;
    NEED(i->exchange && i->mode == FMU_EVENTS, "continuous time follows events");
    i->mode = FMU_CONTINUOUS;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_set, fmi2Boolean *event, fmi2Boolean *terminate)
{
    INSTANCE;
    (void)no_set;
    NEED(i->exchange && i->mode == FMU_CONTINUOUS, "steps are taken in continuous time");
    NEED(event && terminate, FMU_NULL);
    *event = fmu_watch(i) ? fmi2True : fmi2False;
    *terminate = fmu_over(i) ? fmi2True : fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    INSTANCE;
    NEED(i->exchange, "the time is set in model exchange");
    i->v[FMU_V_T] = time;
    i->stale = 1;
    return fmi2OK;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n)
{
    INSTANCE;
    NEED(i->exchange && n == FMU_NQ, "another number of states");
    NEED(x, FMU_NULL);
    memcpy(i->v + FMU_V_Q, x, sizeof(double) * n);
    i->stale = 1;
    return fmi2OK;
}

#define GET(name, group, count)                                                                                      \
    fmi2Status name(fmi2Component c, fmi2Real values[], size_t n)                                                    \
    {                                                                                                                \
        INSTANCE;                                                                                                    \
        NEED(i->exchange && n == count, "another number of values");                                                 \
        NEED(values || !n, FMU_NULL);                                                                                \
        fmu_evaluate(i);                                                                                             \
        memcpy(values, i->v + group, sizeof(double) * n);                                                            \
        return fmi2OK;                                                                                               \
    }
GET(fmi2GetDerivatives, FMU_V_D, FMU_NQ)
GET(fmi2GetEventIndicators, FMU_V_M, FMU_NM + FMU_NV)
GET(fmi2GetContinuousStates, FMU_V_Q, FMU_NQ)

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real values[], size_t n)
{
    INSTANCE;
    NEED(i->exchange && n == FMU_NQ, "another number of states");
    NEED(values, FMU_NULL);
    for (size_t k = 0; k < n; k++) values[k] = 1.0;
    return fmi2OK;
}

/* co-simulation */

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_set)
{
    INSTANCE;
    (void)no_set;
    NEED(!i->exchange && i->mode == FMU_STEPPING, "steps are taken after initialization, in co-simulation");
    return status_of(fmu_step(i, t, h));
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                       const fmi2Integer orders[], const fmi2Real values[])
{
    INSTANCE;
    (void)r, (void)orders, (void)values;
    NEED(n == 0, "inputs are held");
    return fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                        const fmi2Integer orders[], fmi2Real values[])
{
    INSTANCE;
    (void)r, (void)orders, (void)values;
    NEED(n == 0, "outputs have no derivatives");
    return fmi2OK;
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    INSTANCE;
    NEED(0, "steps are not asynchronous");
    return fmi2Error;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    INSTANCE;
    (void)kind, (void)value;
    NEED(0, "steps are not asynchronous");
    return fmi2Error;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    INSTANCE;
    NEED(kind == fmi2LastSuccessfulTime, "this status is not known");
    NEED(value, FMU_NULL);
    *value = i->v[FMU_V_T];
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    INSTANCE;
    (void)kind, (void)value;
    NEED(0, "this status is not known");
    return fmi2Error;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    INSTANCE;
    NEED(kind == fmi2Terminated, "this status is not known");
    NEED(value, FMU_NULL);
    *value = i->terminated;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    INSTANCE;
    (void)kind, (void)value;
    NEED(0, "this status is not known");
    return fmi2Error;
}
