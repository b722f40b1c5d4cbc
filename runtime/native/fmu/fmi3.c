/* SPDX-License-Identifier: Apache-2.0 */
/* FMI 3.0 for model exchange and co-simulation. */
#include "fmi3Functions.h"

#include "core.h"

#define INSTANCE fmu_instance *i = (fmu_instance *)instance
#define NEED(condition, message)                                                                                     \
    if (!i) return fmi3Error;                                                                                        \
    if (!(condition)) return fmu_fail(i, FMU_ERROR, message), fmi3Error

/* Unsupported functions, which the standard requires to exist. */
#define UNSUPPORTED(name, parameters, message)                                                                       \
    fmi3Status name parameters                                                                                       \
    {                                                                                                                \
        INSTANCE;                                                                                                    \
        NEED(0, message);                                                                                            \
        return fmi3Error;                                                                                            \
    }

typedef struct {
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback message;
} listener;

static fmi3Status status_of(enum fmu_status s) { return s == FMU_OK ? fmi3OK : s == FMU_DISCARD ? fmi3Discard : fmi3Error; }

static void say(void *instance, const char *message)
{
    const listener *l = ((fmu_instance *)instance)->environment;
    if (l->message) l->message(l->environment, fmi3Error, "logStatusError", message);
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t n, const fmi3String categories[])
{
    (void)on, (void)n, (void)categories;
    return instance ? fmi3OK : fmi3Error;
}

static fmi3Instance new_instance(int exchange, fmi3String token, fmi3InstanceEnvironment environment,
                                 fmi3LogMessageCallback message)
{
    if (!token || strcmp(token, FMU_TOKEN) != 0) return 0;
    listener *l = malloc(sizeof *l);
    if (!l) return 0;
    l->environment = environment, l->message = message;
    fmu_instance *i = fmu_new(exchange, l, say);
    if (!i) free(l);
    return i;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String place, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback message)
{
    (void)name, (void)place, (void)visible, (void)logging;
    return new_instance(1, token, environment, message);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String place, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t n,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback message,
                                         fmi3IntermediateUpdateCallback update)
{
    (void)name, (void)place, (void)visible, (void)logging, (void)events, (void)early, (void)required, (void)n, (void)update;
    return new_instance(0, token, environment, message);
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String place, fmi3Boolean visible,
                                               fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                               fmi3LogMessageCallback message, fmi3ClockUpdateCallback update,
                                               fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock)
{
    (void)name, (void)token, (void)place, (void)visible, (void)logging, (void)environment, (void)message, (void)update;
    (void)lock, (void)unlock;
    return 0;
}

void fmi3FreeInstance(fmi3Instance instance)
{
    INSTANCE;
    if (i) free(i->environment);
    free(i);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean stop_defined, fmi3Float64 stop)
{
    INSTANCE;
    NEED(i->mode == FMU_INSTANTIATED, "initialization begins once");
    NEED(!stop_defined || stop >= start, "the stop time is before the start");
    NEED(!tolerance_defined || tolerance > 0, "the tolerance must be positive");
    if (tolerance_defined) i->single.schedule.rtol = tolerance;
    i->start = i->v[FMU_V_T] = start, i->stop = stop, i->stop_defined = stop_defined;
    i->mode = FMU_INITIALIZING;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    INSTANCE;
    NEED(i->mode == FMU_INITIALIZING, "initialization has not begun");
    return status_of(fmu_begin(i));
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    INSTANCE;
    NEED(i->mode > FMU_INITIALIZING, "nothing runs");
    i->mode = FMU_TERMINATED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    INSTANCE;
    NEED(1, "");
    fmu_reset(i);
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3Float64 values[], size_t m)
{
    INSTANCE;
    NEED(n == m, "as many values as references");
    return status_of(fmu_get(i, r, n, values));
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference r[], size_t n, const fmi3Float64 values[],
                          size_t m)
{
    INSTANCE;
    NEED(n == m, "as many values as references");
    return status_of(fmu_set(i, r, n, values));
}

#define NO_VALUES(kind)                                                                                              \
    fmi3Status fmi3Get##kind(fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3##kind values[],     \
                             size_t m)                                                                               \
    {                                                                                                                \
        INSTANCE;                                                                                                    \
        (void)r, (void)values, (void)m;                                                                              \
        NEED(n == 0, "all variables are Float64");                                                                   \
        return fmi3OK;                                                                                               \
    }                                                                                                                \
    fmi3Status fmi3Set##kind(fmi3Instance instance, const fmi3ValueReference r[], size_t n,                          \
                             const fmi3##kind values[], size_t m)                                                    \
    {                                                                                                                \
        INSTANCE;                                                                                                    \
        (void)r, (void)values, (void)m;                                                                              \
        NEED(n == 0, "all variables are Float64");                                                                   \
        return fmi3OK;                                                                                               \
    }
NO_VALUES(Float32)
NO_VALUES(Int8)
NO_VALUES(UInt8)
NO_VALUES(Int16)
NO_VALUES(UInt16)
NO_VALUES(Int32)
NO_VALUES(UInt32)
NO_VALUES(Int64)
NO_VALUES(UInt64)
NO_VALUES(Boolean)
NO_VALUES(String)

UNSUPPORTED(fmi3GetBinary, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, size_t sizes[],
                            fmi3Binary values[], size_t m), ((void)r, (void)n, (void)sizes, (void)values, (void)m,
                            "all variables are Float64"))
UNSUPPORTED(fmi3SetBinary, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const size_t sizes[],
                            const fmi3Binary values[], size_t m), ((void)r, (void)n, (void)sizes, (void)values, (void)m,
                            "all variables are Float64"))
UNSUPPORTED(fmi3GetClock, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3Clock values[]),
            ((void)r, (void)n, (void)values, "there are no clocks"))
UNSUPPORTED(fmi3SetClock, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const fmi3Clock values[]),
            ((void)r, (void)n, (void)values, "there are no clocks"))
UNSUPPORTED(fmi3GetNumberOfVariableDependencies, (fmi3Instance instance, fmi3ValueReference r, size_t *n),
            ((void)r, (void)n, "dependencies do not change"))
UNSUPPORTED(fmi3GetVariableDependencies, (fmi3Instance instance, fmi3ValueReference r, size_t of[],
                                          fmi3ValueReference by[], size_t in[], fmi3DependencyKind kinds[], size_t n),
            ((void)r, (void)of, (void)by, (void)in, (void)kinds, (void)n, "dependencies do not change"))
UNSUPPORTED(fmi3GetAdjointDerivative, (fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nu,
                                       const fmi3ValueReference knowns[], size_t nk, const fmi3Float64 seed[],
                                       size_t ns, fmi3Float64 sensitivity[], size_t m),
            ((void)unknowns, (void)nu, (void)knowns, (void)nk, (void)seed, (void)ns, (void)sensitivity, (void)m,
             "derivatives are directional"))
UNSUPPORTED(fmi3EnterConfigurationMode, (fmi3Instance instance), "there are no structural parameters")
UNSUPPORTED(fmi3ExitConfigurationMode, (fmi3Instance instance), "there are no structural parameters")
UNSUPPORTED(fmi3GetIntervalDecimal, (fmi3Instance instance, const fmi3ValueReference r[], size_t n,
                                     fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[]),
            ((void)r, (void)n, (void)intervals, (void)qualifiers, "there are no clocks"))
UNSUPPORTED(fmi3GetIntervalFraction, (fmi3Instance instance, const fmi3ValueReference r[], size_t n,
                                      fmi3UInt64 counters[], fmi3UInt64 resolutions[],
                                      fmi3IntervalQualifier qualifiers[]),
            ((void)r, (void)n, (void)counters, (void)resolutions, (void)qualifiers, "there are no clocks"))
UNSUPPORTED(fmi3GetShiftDecimal, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3Float64 shifts[]),
            ((void)r, (void)n, (void)shifts, "there are no clocks"))
UNSUPPORTED(fmi3GetShiftFraction, (fmi3Instance instance, const fmi3ValueReference r[], size_t n,
                                   fmi3UInt64 counters[], fmi3UInt64 resolutions[]),
            ((void)r, (void)n, (void)counters, (void)resolutions, "there are no clocks"))
UNSUPPORTED(fmi3SetIntervalDecimal, (fmi3Instance instance, const fmi3ValueReference r[], size_t n,
                                     const fmi3Float64 intervals[]),
            ((void)r, (void)n, (void)intervals, "there are no clocks"))
UNSUPPORTED(fmi3SetIntervalFraction, (fmi3Instance instance, const fmi3ValueReference r[], size_t n,
                                      const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]),
            ((void)r, (void)n, (void)counters, (void)resolutions, "there are no clocks"))
UNSUPPORTED(fmi3SetShiftDecimal, (fmi3Instance instance, const fmi3ValueReference r[], size_t n,
                                  const fmi3Float64 shifts[]),
            ((void)r, (void)n, (void)shifts, "there are no clocks"))
UNSUPPORTED(fmi3SetShiftFraction, (fmi3Instance instance, const fmi3ValueReference r[], size_t n,
                                   const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]),
            ((void)r, (void)n, (void)counters, (void)resolutions, "there are no clocks"))
UNSUPPORTED(fmi3ActivateModelPartition, (fmi3Instance instance, fmi3ValueReference clock, fmi3Float64 t),
            ((void)clock, (void)t, "there are no clocks"))
UNSUPPORTED(fmi3EnterStepMode, (fmi3Instance instance), "co-simulation has no events")

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference r[], size_t n,
                                    const fmi3Int32 orders[], fmi3Float64 values[], size_t m)
{
    INSTANCE;
    (void)r, (void)orders, (void)values, (void)m;
    NEED(n == 0, "outputs have no derivatives");
    return fmi3OK;
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    INSTANCE;
    NEED(state, "no place for the state");
    if (!*state) *state = calloc(1, sizeof(fmu_instance));
    NEED(*state, "no memory");
    fmu_copy(*state, i);
    return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state)
{
    INSTANCE;
    NEED(state, "no state");
    fmu_copy(i, state);
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    INSTANCE;
    NEED(1, "");
    if (state) free(*state), *state = 0;
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size)
{
    INSTANCE;
    NEED(state && size, "no state");
    *size = sizeof(fmu_instance);
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    INSTANCE;
    NEED(state && bytes && size >= sizeof(fmu_instance), "no state, or too few bytes for it");
    memcpy(bytes, state, sizeof(fmu_instance));
    return fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    INSTANCE;
    NEED(state && bytes && size == sizeof(fmu_instance), "these bytes are no state of this FMU");
    fmu_instance *copy = calloc(1, sizeof *copy);
    NEED(copy, "no memory");
    memcpy(copy, bytes, sizeof *copy);
    copy->environment = 0, copy->log = 0;
    fmu_restore(copy);
    *state = copy;
    return fmi3OK;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nu,
                                        const fmi3ValueReference knowns[], size_t nk, const fmi3Float64 seed[],
                                        size_t ns, fmi3Float64 sensitivity[], size_t m)
{
    INSTANCE;
    NEED(ns == nk && m == nu, "as many numbers as references");
    return status_of(fmu_directional(i, unknowns, nu, knowns, nk, seed, sensitivity));
}

/* model exchange */

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    INSTANCE;
    NEED(i->exchange && i->mode == FMU_CONTINUOUS, "events come from continuous time");
    i->mode = FMU_EVENTS;
    return fmi3OK;
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance)
{
    INSTANCE;
    NEED(i->mode == FMU_EVENTS, "discrete states change in events");
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again, fmi3Boolean *terminate,
                                    fmi3Boolean *nominals, fmi3Boolean *values, fmi3Boolean *next_defined,
                                    fmi3Float64 *next)
{
    INSTANCE;
    NEED(i->exchange && i->mode == FMU_EVENTS, "discrete states change in events");
    NEED(again && terminate && nominals && values && next_defined && next, FMU_NULL);
    fmu_event(i);
    *again = *nominals = fmi3False;
    *values = i->reset != 0;
    *terminate = i->terminated != 0;
    *next_defined = FMU_KIND == 2;
    *next = i->next_event;
    return fmi3OK;
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    INSTANCE;
    NEED(i->exchange && i->mode == FMU_EVENTS, "continuous time follows events");
    i->mode = FMU_CONTINUOUS;
    return fmi3OK;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean no_set, fmi3Boolean *event,
                                       fmi3Boolean *terminate)
{
    INSTANCE;
    (void)no_set;
    NEED(i->exchange && i->mode == FMU_CONTINUOUS, "steps are taken in continuous time");
    NEED(event && terminate, FMU_NULL);
    *event = fmu_watch(i) != 0;
    *terminate = fmu_over(i) != 0;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    INSTANCE;
    NEED(i->exchange, "the time is set in model exchange");
    i->v[FMU_V_T] = time;
    i->stale = 1;
    return fmi3OK;
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 x[], size_t n)
{
    INSTANCE;
    NEED(i->exchange && n == FMU_NQ, "another number of states");
    NEED(x, FMU_NULL);
    memcpy(i->v + FMU_V_Q, x, sizeof(double) * n);
    i->stale = 1;
    return fmi3OK;
}

#define GET(name, group, count)                                                                                      \
    fmi3Status name(fmi3Instance instance, fmi3Float64 values[], size_t n)                                           \
    {                                                                                                                \
        INSTANCE;                                                                                                    \
        NEED(i->exchange && n == count, "another number of values");                                                 \
        NEED(values || !n, FMU_NULL);                                                                                \
        fmu_evaluate(i);                                                                                             \
        memcpy(values, i->v + group, sizeof(double) * n);                                                            \
        return fmi3OK;                                                                                               \
    }
GET(fmi3GetContinuousStateDerivatives, FMU_V_D, FMU_NQ)
GET(fmi3GetEventIndicators, FMU_V_M, FMU_NM + FMU_NV)
GET(fmi3GetContinuousStates, FMU_V_Q, FMU_NQ)

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 values[], size_t n)
{
    INSTANCE;
    NEED(i->exchange && n == FMU_NQ, "another number of states");
    NEED(values, FMU_NULL);
    for (size_t k = 0; k < n; k++) values[k] = 1.0;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *n)
{
    INSTANCE;
    NEED(i->exchange, "events are of model exchange");
    NEED(n, FMU_NULL);
    *n = FMU_NM + FMU_NV;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *n)
{
    INSTANCE;
    NEED(i->exchange, "states are of model exchange");
    NEED(n, FMU_NULL);
    *n = FMU_NQ;
    return fmi3OK;
}

/* co-simulation */

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_set, fmi3Boolean *events,
                      fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *last)
{
    INSTANCE;
    (void)no_set;
    NEED(!i->exchange && i->mode == FMU_STEPPING, "steps are taken after initialization, in co-simulation");
    NEED(events && terminate && early && last, FMU_NULL);
    const fmi3Status status = status_of(fmu_step(i, t, h));
    *events = fmi3False, *early = fmi3False;
    *terminate = i->terminated != 0;
    *last = i->v[FMU_V_T];
    return status;
}
