/* FMI 3.0: instances, initialisation, states, partial derivatives. */
#include "access.h"
#include "fmi3.h"

static void emit3(Instance *self, Severity severity, const char *category, const char *message)
{
    ((fmi3LogMessageCallback)self->logger)(self->environment, (fmi3Status)severity, category,
                                           message);
}

const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t count,
                               const fmi3String categories[])
{
    ALLOW3(ANY_MODE);
    return status3(choose_categories(self, on, count, categories));
}

static Instance *instantiate(Interface interface, fmi3String name, fmi3String token,
                             fmi3Boolean logging, fmi3InstanceEnvironment environment,
                             fmi3LogMessageCallback logger)
{
    Instance *self = create(name, token, interface, NULL, NULL);
    if (!self) {
        if (logger)
            logger(environment, fmi3Error, "logStatusError", why_not_created(name, token));
        return NULL;
    }
    self->emit = emit3;
    self->logger = (void (*)(void))logger;
    self->environment = environment;
    self->categories = logging ? CATEGORY_ALL : 0;
    return self;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                          fmi3Boolean visible, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback logger)
{
    (void)resources, (void)visible;
    return instantiate(MODEL_EXCHANGE, name, token, logging, environment, logger);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean visible, fmi3Boolean logging,
                                         fmi3Boolean event_mode_used,
                                         fmi3Boolean early_return_allowed,
                                         const fmi3ValueReference required[], size_t n_required,
                                         fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback logger,
                                         fmi3IntermediateUpdateCallback intermediate)
{
    (void)resources, (void)visible, (void)required, (void)n_required, (void)intermediate;
    Instance *self = instantiate(CO_SIMULATION, name, token, logging, environment, logger);
    if (self) {
        self->event_mode_used = event_mode_used;
        self->early_return_allowed = early_return_allowed;
    }
    return self;
}

fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
    fmi3ClockUpdateCallback clock_update, fmi3LockPreemptionCallback lock,
    fmi3UnlockPreemptionCallback unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)clock_update;
    (void)lock, (void)unlock;
    if (logger)
        logger(environment, fmi3Error, "logStatusError", "scheduled execution is not offered");
    return NULL;
}

void fmi3FreeInstance(fmi3Instance instance)
{
    Instance *self = instance;
    if (self)
        self->release(self);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean tolerance_defined,
                                       fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean stop_defined, fmi3Float64 stop)
{
    ALLOW3(INSTANTIATED);
    if (tolerance_defined && RELATIVE_TOLERANCE && tolerance > 0.0 &&
        !write_value(self, RELATIVE_TOLERANCE, tolerance))
        return fmi3Error;
    self->s.stop_defined = stop_defined;
    self->s.stop_time = stop_defined ? stop : 0.0;
    return status3(enter_initialization(self, start));
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    ALLOW3(INITIALIZATION);
    const bool stepping = self->s.interface == CO_SIMULATION && !self->event_mode_used;
    return status3(exit_initialization(self, stepping ? STEP : EVENT));
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    ALLOW3(RUNNING);
    self->s.mode = TERMINATED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    ALLOW3(ANY_MODE);
    to_start(self);
    return fmi3OK;
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    ALLOW3(ANY_MODE);
    return status3(save_state(self, state));
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state)
{
    ALLOW3(ANY_MODE);
    return status3(restore_state(self, state));
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    ALLOW3(ANY_MODE);
    free_state(self, state);
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size)
{
    (void)state;
    ALLOW3(ANY_MODE);
    *size = serialized_size();
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[],
                                 size_t size)
{
    ALLOW3(ANY_MODE);
    return status3(serialize_state(self, state, bytes, size));
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size,
                                   fmi3FMUState *state)
{
    ALLOW3(ANY_MODE);
    return status3(deserialize_state(self, bytes, size, state));
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                        size_t n_unknowns, const fmi3ValueReference knowns[],
                                        size_t n_knowns, const fmi3Float64 seed[], size_t n_seed,
                                        fmi3Float64 sensitivity[], size_t n_sensitivity)
{
    ALLOW3(INITIALIZATION | RUNNING | TERMINATED);
    return status3(directional_derivative(self, unknowns, n_unknowns, knowns, n_knowns, seed,
                                          n_seed, sensitivity, n_sensitivity));
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                    size_t n_unknowns, const fmi3ValueReference knowns[],
                                    size_t n_knowns, const fmi3Float64 seed[], size_t n_seed,
                                    fmi3Float64 sensitivity[], size_t n_sensitivity)
{
    ALLOW3(INITIALIZATION | RUNNING | TERMINATED);
    return status3(adjoint_derivative(self, unknowns, n_unknowns, knowns, n_knowns, seed, n_seed,
                                      sensitivity, n_sensitivity));
}
