/* FMI 2.0: instances, initialisation, values, states, partial derivatives. */
#include "access.h"
#include "fmi2.h"

static void emit(Instance *self, Severity severity, const char *category, const char *message)
{
    char escaped[1024]; /* the logger may take the message for a format */
    char *to = escaped;
    for (const char *from = message; *from && to < escaped + sizeof escaped - 2; from++) {
        if (*from == '%')
            *to++ = '%';
        *to++ = *from;
    }
    *to = '\0';
    ((fmi2CallbackLogger)self->logger)(self->environment, self->name, (fmi2Status)severity,
                                       category, escaped);
}

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count,
                               const fmi2String categories[])
{
    ALLOW(ANY_MODE);
    return status(choose_categories(self, on, count, categories));
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token,
                              fmi2String resources, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean logging)
{
    (void)resources, (void)visible;
    if (!functions)
        return NULL;
    Instance *self = create(name, token, type == fmi2CoSimulation ? CO_SIMULATION : MODEL_EXCHANGE,
                            functions->allocateMemory, functions->freeMemory);
    if (!self) {
        if (functions->logger)
            functions->logger(functions->componentEnvironment, name ? name : "", fmi2Error,
                              "logStatusError", why_not_created(name, token));
        return NULL;
    }
    self->emit = emit;
    self->logger = (void (*)(void))functions->logger;
    self->environment = functions->componentEnvironment;
    self->categories = logging ? CATEGORY_ALL : 0;
    return self;
}

void fmi2FreeInstance(fmi2Component c)
{
    Instance *self = c;
    if (self)
        self->release(self);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop)
{
    ALLOW(INSTANTIATED);
    if (tolerance_defined && RELATIVE_TOLERANCE && tolerance > 0.0 &&
        !write_value(self, RELATIVE_TOLERANCE, tolerance))
        return fmi2Error;
    self->s.start_time = start;
    self->s.stop_defined = stop_defined != fmi2False;
    self->s.stop_time = stop_defined ? stop : 0.0;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    ALLOW(INSTANTIATED);
    return status(enter_initialization(self, self->s.start_time));
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    ALLOW(INITIALIZATION);
    return status(exit_initialization(self, self->s.interface == CO_SIMULATION ? STEP : EVENT));
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    ALLOW(RUNNING);
    self->s.mode = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    ALLOW(ANY_MODE);
    to_start(self);
    return fmi2OK;
}

#define VALUES(name, ctype, type)                                                                  \
    static bool get_##name(Instance *self, const fmi2ValueReference vr[], size_t n, ctype out[])   \
    {                                                                                              \
        GET_VALUES(self, vr, n, type, out, n, ctype)                                               \
    }                                                                                              \
    static bool set_##name(Instance *self, const fmi2ValueReference vr[], size_t n,                \
                           const ctype in[])                                                       \
    {                                                                                              \
        SET_VALUES(self, vr, n, type, in, n)                                                       \
    }

VALUES(reals, fmi2Real, REAL)
VALUES(integers, fmi2Integer, INTEGER)
VALUES(enumerations, fmi2Integer, ENUMERATION)
VALUES(booleans, fmi2Boolean, BOOLEAN)

static bool enumerated(const fmi2ValueReference vr)
{
    return vr < N_VALUES && model_access[vr].type == ENUMERATION;
}

enum { SETTABLE = INSTANTIATED | INITIALIZATION | RUNNING };

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    ALLOW(READABLE);
    return status(get_reals(self, vr, n, value));
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                          fmi2Integer value[])
{
    ALLOW(READABLE);
    bool good = true;
    for (size_t i = 0; i < n && good; i++)
        good = enumerated(vr[i]) ? get_enumerations(self, vr + i, 1, value + i)
                                 : get_integers(self, vr + i, 1, value + i);
    return status(good);
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                          fmi2Boolean value[])
{
    ALLOW(READABLE);
    return status(get_booleans(self, vr, n, value));
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                       const fmi2Real value[])
{
    ALLOW(SETTABLE);
    return status(set_reals(self, vr, n, value));
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                          const fmi2Integer value[])
{
    ALLOW(SETTABLE);
    bool good = true;
    for (size_t i = 0; i < n; i++)
        good &= enumerated(vr[i]) ? set_enumerations(self, vr + i, 1, value + i)
                                  : set_integers(self, vr + i, 1, value + i);
    return status(good);
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                          const fmi2Boolean value[])
{
    ALLOW(SETTABLE);
    return status(set_booleans(self, vr, n, value));
}

static fmi2Status no_strings(Instance *self, size_t n)
{
    if (n == 0)
        return fmi2OK;
    report(self, STATUS_ERROR, "there are no string variables");
    return fmi2Error;
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                         fmi2String value[])
{
    (void)vr, (void)value;
    ALLOW(READABLE);
    return no_strings(self, n);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                         const fmi2String value[])
{
    (void)vr, (void)value;
    ALLOW(SETTABLE);
    return no_strings(self, n);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    ALLOW(ANY_MODE);
    return status(save_state(self, state));
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    ALLOW(ANY_MODE);
    return status(restore_state(self, state));
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    ALLOW(ANY_MODE);
    free_state(self, state);
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    (void)state;
    ALLOW(ANY_MODE);
    *size = serialized_size();
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[],
                                 size_t size)
{
    ALLOW(ANY_MODE);
    return status(serialize_state(self, state, (unsigned char *)bytes, size));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate *state)
{
    ALLOW(ANY_MODE);
    return status(deserialize_state(self, (const unsigned char *)bytes, size, state));
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[],
                                        size_t n_unknown, const fmi2ValueReference known[],
                                        size_t n_known, const fmi2Real seed[], fmi2Real result[])
{
    ALLOW(INITIALIZATION | RUNNING | TERMINATED);
    return status(directional_derivative(self, unknown, n_unknown, known, n_known, seed, n_known,
                                         result, n_unknown));
}
