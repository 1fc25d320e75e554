/* A small sound FMU of FMI 3.0 for the bench, most of whose variables the bench cannot drive.

   y = t. References: 0 time, 1 y, 2 label (string), 3 payload and 4 echo (binary), 5 tick (clock),
   6 gate and 7 count (clocked by tick). Strings, binaries, the clock and what it clocks are refused.
   Co-simulation. With -DLAG=step a solver of fixed step ends no later than the communication point;
   with -DENDS=time it asks for the end of the simulation; with -DDEFECT_DRIFT it adds up time. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi3FunctionTypes.h"

enum { NEW = 1, INIT = 2, STEP = 4, ENDED = 8 };

typedef struct {
    int mode;
    double start, point, time;
    fmi3LogMessageCallback log;
    void *environment;
} Model;

static fmi3Status refuse(Model *self, const char *what)
{
    self->log(self->environment, fmi3Error, "logStatusError", what);
    return fmi3Error;
}

#define ALLOW(modes)                                                                               \
    Model *self = c;                                                                               \
    if (!(self->mode & (modes)))                                                                   \
        return refuse(self, "not allowed in this mode")

const char *fmi3GetVersion(void) { return "3.0"; }
fmi3Status fmi3SetDebugLogging(void) { return fmi3OK; }

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String folder, fmi3Boolean visible, fmi3Boolean logging,
    fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference required[], size_t n,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3IntermediateUpdateCallback update)
{
    (void)name, (void)folder, (void)visible, (void)logging, (void)events, (void)early;
    (void)required, (void)n, (void)update;
    if (strcmp(token, "{bench3}") != 0) {
        log(environment, fmi3Error, "logStatusError", "wrong token");
        return NULL;
    }
    Model *self = calloc(1, sizeof *self);
    *self = (Model){.mode = NEW, .log = log, .environment = environment};
    return self;
}

fmi3Instance fmi3InstantiateModelExchange(void) { return NULL; }
fmi3Instance fmi3InstantiateScheduledExecution(void) { return NULL; }
void fmi3FreeInstance(fmi3Instance c) { free(c); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean td, fmi3Float64 t,
                                       fmi3Float64 start, fmi3Boolean sd, fmi3Float64 stop)
{
    (void)td, (void)t, (void)sd, (void)stop;
    ALLOW(NEW);
    self->start = self->point = self->time = start;
    self->mode = INIT;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    ALLOW(INIT);
    self->mode = STEP;
    return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance c)
{
    ALLOW(STEP);
    self->mode = ENDED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance c)
{
    Model *self = c;
    self->mode = NEW;
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                          fmi3Float64 value[], size_t n_values)
{
    ALLOW(INIT | STEP | ENDED);
    for (size_t i = 0; i < n; i++) {
        if (vr[i] > 1 || n_values != n)
            return refuse(self, "cannot be read");
        value[i] = self->time;
    }
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 h, fmi3Boolean no_rollback,
                      fmi3Boolean *event, fmi3Boolean *end, fmi3Boolean *early,
                      fmi3Float64 *reached)
{
    (void)no_rollback;
    ALLOW(STEP);
    if (!(h > 0) || !isfinite(h) || !(fabs(time - self->point) <= 1e-6 * (1 + fabs(time))))
        return refuse(self, "step from another time");
    self->point = time + h;
#if defined LAG
    self->time = floor(self->point / LAG + 1e-6) * LAG;
#elif defined DEFECT_DRIFT
    self->time += h;
#else
    self->time = self->point;
#endif
    *event = *early = *end = false;
#if defined ENDS
    *end = self->time - self->start > ENDS - 1e-9;
#endif
    *reached = self->time;
    return fmi3OK;
}

#define REFUSED(name)                                                                              \
    fmi3Status fmi3##name(fmi3Instance c) { return refuse(c, #name " is not offered"); }
#define ACCESS(T) REFUSED(Get##T) REFUSED(Set##T)
ACCESS(Float32) ACCESS(Int8) ACCESS(UInt8) ACCESS(Int16) ACCESS(UInt16) ACCESS(Int32)
ACCESS(UInt32) ACCESS(Int64) ACCESS(UInt64) ACCESS(Boolean) ACCESS(String) ACCESS(Binary)
ACCESS(Clock) ACCESS(IntervalDecimal) ACCESS(IntervalFraction) ACCESS(ShiftDecimal)
ACCESS(ShiftFraction) ACCESS(FMUState) ACCESS(ContinuousStates)
REFUSED(SetFloat64) REFUSED(SetTime) REFUSED(FreeFMUState) REFUSED(SerializedFMUStateSize)
REFUSED(SerializeFMUState) REFUSED(DeserializeFMUState) REFUSED(GetDirectionalDerivative)
REFUSED(GetAdjointDerivative) REFUSED(EnterConfigurationMode) REFUSED(ExitConfigurationMode)
REFUSED(EvaluateDiscreteStates) REFUSED(UpdateDiscreteStates) REFUSED(EnterContinuousTimeMode)
REFUSED(CompletedIntegratorStep) REFUSED(GetContinuousStateDerivatives)
REFUSED(GetEventIndicators) REFUSED(GetNominalsOfContinuousStates)
REFUSED(GetNumberOfEventIndicators) REFUSED(GetNumberOfContinuousStates) REFUSED(EnterStepMode)
REFUSED(EnterEventMode) REFUSED(GetOutputDerivatives) REFUSED(ActivateModelPartition)
REFUSED(GetNumberOfVariableDependencies) REFUSED(GetVariableDependencies)
