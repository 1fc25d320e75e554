/* A small sound FMU for the bench, and with -DDEFECT_... one defect in it.

   x' = k (u - x), y = u + 2 x, z = x^2, n = m + samples of 0.1 s so far. References: 1 u, 2 k, 3 x,
   4 der(x), 5 y, 6 n, 7 z, 8 m (discrete: not to be set in continuous time). FMI 2.0, co-simulation and model exchange. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fmi2Functions.h"

enum { NEW = 1, INIT = 2, STEP = 4, EVENT = 8, CONTINUOUS = 16, ENDED = 32, RUNNING = 28 };

typedef struct {
    int mode, steps, m;
    double time, start, u, k, x;
} State;

typedef struct {
    State s;
    int type, odd, large;
    fmi2CallbackLogger log;
    void *environment;
    char name[64];
} Model;

#if defined DEFECT_SHARED_STATE
static double shared;
#endif
#if defined DEFECT_LEAK_STEP || defined DEFECT_LEAK_INSTANCE
void *volatile lost;
#endif
#if defined DEFECT_DAMAGE
static double damage;
#endif

#define SELF Model *self = c

static fmi2Status refuse(Model *self, const char *what)
{
#if defined DEFECT_DAMAGE
    damage = 1e-3;
#endif
#if defined DEFECT_ABORTS
    abort();
#elif defined DEFECT_STUCK
    for (;;)
        pause();
#endif
#if !defined DEFECT_NO_MESSAGE
    if (self->log)
        self->log(self->environment, self->name, fmi2Error, "logStatusError", what);
#endif
    return fmi2Error;
}

#define ALLOW(modes)                                                                               \
    SELF;                                                                                          \
    if (!(self->s.mode & (modes)))                                                                 \
        return refuse(self, "not allowed in this mode")

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

static void to_start(Model *self)
{
    const double x = self->s.x;
    self->s = (State){.mode = NEW, .u = 0.5, .k = 1.0, .x = 1.0};
#if defined DEFECT_RESET
    if (x != 0.0)
        self->s.x = x;
#endif
    (void)x;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String folder,
                              const fmi2CallbackFunctions *f, fmi2Boolean visible, fmi2Boolean on)
{
    (void)folder, (void)visible, (void)on;
#if !defined DEFECT_ANY_TOKEN
    if (strcmp(token, "{bench}") != 0) {
        f->logger(f->componentEnvironment, name, fmi2Error, "logStatusError", "wrong token");
        return NULL;
    }
#endif
#if defined DEFECT_LEAK_INSTANCE
    lost = memset(malloc(200000), 1, 200000);
#endif
#if defined DEFECT_OPEN_FILE
    if (!fopen("/dev/null", "r"))
        return NULL;
#endif
#if defined DEFECT_CHDIR
    if (chdir("/"))
        return NULL;
#endif
#if defined DEFECT_WRITES_FILE
    FILE *file = fopen("debug.txt", "w");
    fputs("hello", file);
    fclose(file);
#endif
    Model *self = calloc(1, sizeof *self);
    snprintf(self->name, sizeof self->name, "%s", name);
    self->log = f->logger;
    self->environment = f->componentEnvironment;
    self->type = type;
    self->odd = 0;
#if defined DEFECT_ADDRESS
    self->odd = (int)(((uintptr_t)self >> 4) % 100000);
#endif
    to_start(self);
    return self;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String names[])
{
    (void)c, (void)on, (void)n, (void)names;
    return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean td, fmi2Real t, fmi2Real start,
                               fmi2Boolean sd, fmi2Real stop)
{
    (void)td, (void)t, (void)sd, (void)stop;
    ALLOW(NEW);
    self->s.start = self->s.time = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    ALLOW(NEW);
    self->s.mode = INIT;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    ALLOW(INIT);
    self->s.mode = self->type == fmi2CoSimulation ? STEP : EVENT;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    ALLOW(RUNNING);
    self->s.mode = ENDED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    SELF;
    to_start(self);
    return fmi2OK;
}

static double rate(const Model *self)
{
    const double r = self->s.k * (self->s.u - self->s.x);
#if defined DEFECT_EXCHANGE_LITTLE
    return self->type == fmi2ModelExchange ? 1.0001 * r : r;
#elif defined DEFECT_EXCHANGE
    return self->type == fmi2ModelExchange ? 1.1 * r : r;
#endif
    return r;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    ALLOW(INIT | RUNNING | ENDED);
    const State *s = &self->s;
    for (size_t i = 0; i < n; i++) {
        switch (vr[i]) {
        case 1: value[i] = s->u; break;
        case 2: value[i] = s->k; break;
        case 3: value[i] = s->x; break;
        case 4: value[i] = rate(self); break;
        case 5: value[i] = s->u + 2 * s->x; break;
        case 7: value[i] = s->x * s->x; break;
        default: return refuse(self, "no such variable");
        }
#if defined DEFECT_GAIN
        value[i] *= vr[i] == 5 ? 1.001 : 1.0;
#elif defined DEFECT_ADDRESS
        value[i] += vr[i] == 5 ? self->odd * 1e-9 : 0.0;
#elif defined DEFECT_PROCESS
        value[i] += vr[i] == 5 ? getpid() * 1e-9 : 0.0;
#elif defined DEFECT_SHARED_STATE
        value[i] += vr[i] == 5 ? shared : 0.0;
#elif defined DEFECT_DAMAGE
        value[i] += vr[i] == 5 ? damage : 0.0;
#elif defined DEFECT_COUNTS_STEPS
        value[i] += vr[i] == 5 ? self->odd * 1e-9 : 0.0;
#elif defined DEFECT_NAN_LARGE_STEP
        if (self->large && vr[i] == 5)
            value[i] = NAN;
#elif defined DEFECT_NAN_LATER
        if (s->time > 0.3 && vr[i] == 5)
            value[i] = NAN;
#endif
#if !defined DEFECT_NAN && !defined DEFECT_NAN_LARGE_STEP && !defined DEFECT_NAN_LATER
        if (!isfinite(value[i]))
            return refuse(self, "not finite");
#endif
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                       const fmi2Real value[])
{
    ALLOW(NEW | INIT | RUNNING);
#if defined DEFECT_REFUSES
    if (self->s.mode == INIT)
        return refuse(self, "no inputs during initialisation");
#endif
    for (size_t i = 0; i < n; i++) {
#if !defined DEFECT_NAN && !defined DEFECT_CRASH_ON_NAN
        if (!isfinite(value[i]))
            return refuse(self, "must be finite");
#elif defined DEFECT_CRASH_ON_NAN
        if (!isfinite(value[i]))
            abort();
#endif
        if (vr[i] == 1)
            self->s.u = value[i];
        else if (vr[i] == 2 && self->s.mode & (NEW | INIT)) {
#if !defined DEFECT_NAN
            if (!(value[i] >= 0.1 && value[i] <= 10.0))
                return refuse(self, "k must be from 0.1 to 10");
#endif
            self->s.k = value[i];
        } else if (vr[i] == 3 && self->s.mode & (NEW | INIT))
            self->s.x = value[i];
        else
            return refuse(self, "cannot be set");
    }
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                          fmi2Integer value[])
{
    ALLOW(INIT | RUNNING | ENDED);
    for (size_t i = 0; i < n; i++) {
        if (vr[i] == 8) {
            value[i] = self->s.m;
            continue;
        }
        if (vr[i] != 6)
            return refuse(self, "no such variable");
        value[i] = self->s.m + (int)floor((self->s.time - self->s.start) / 0.1 + 1e-6);
    }
    return fmi2OK;
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                          const fmi2Integer value[])
{
    ALLOW(NEW | INIT | STEP | EVENT);
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != 8 || value[i] < 0 || value[i] > 9)
            return refuse(self, "m must be from 0 to 9");
        self->s.m = value[i];
    }
    return fmi2OK;
}

#define NONE(name, T)                                                                              \
    fmi2Status name(fmi2Component c, const fmi2ValueReference vr[], size_t n, T value[])           \
    {                                                                                              \
        (void)vr, (void)value;                                                                     \
        SELF;                                                                                      \
        return n ? refuse(self, "no such variable") : fmi2OK;                                      \
    }
NONE(fmi2GetBoolean, fmi2Boolean)
NONE(fmi2GetString, fmi2String)
NONE(fmi2SetBoolean, const fmi2Boolean)
NONE(fmi2SetString, const fmi2String)

/* With -DENDS=time it asks for the end of the simulation, which is no defect. */
static int at_end(const Model *self)
{
#if defined ENDS
    return self->s.time - self->s.start > ENDS - 1e-9;
#else
    return self == NULL;
#endif
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real h, fmi2Boolean no_rollback)
{
    (void)no_rollback;
#if defined DEFECT_STEP_ANYWHERE
    SELF;
#else
    ALLOW(STEP);
    if (!(h >= 0) || !isfinite(h) || !(fabs(time - self->s.time) <= 1e-6 * (1 + fabs(time))))
        return refuse(self, "step from another time");
#endif
    State *s = &self->s;
    s->steps++;
    self->odd++;
    self->large = h > 0.5;
#if defined DEFECT_CRASH
    if (s->steps > 5)
        *(volatile int *)8 = 0;
#elif defined DEFECT_HANG
    while (s->steps > 5)
        usleep(1000);
#elif defined DEFECT_EXIT
    if (s->steps > 5)
        exit(3);
#elif defined DEFECT_FORKS
    if (s->steps == 5 && fork() == 0)
        for (;;)
            pause();
#elif defined DEFECT_GARBAGE
    for (int file = 3; file < 64; file++)
        if (write(file, "garbage\n", 8) < 0)
            continue;
#elif defined DEFECT_FLOOD
    char *flood = calloc(1, 1 << 22);
    memset(flood, 'x', (1 << 22) - 1);
    memcpy(flood, "\x1b[31m\xe2\x80\xae", 8);
    fmi2Status refused = refuse(self, flood);
    free(flood);
    return refused;
#elif defined DEFECT_LEAK_STEP
    lost = memset(malloc(9000), 1, 9000);
#elif defined DEFECT_SHARED_STATE
    shared += 1e-6;
#endif
#if defined DEFECT_EULER || defined DEFECT_EXCHANGE_LITTLE
    s->x += h * s->k * (s->u - s->x);
#else
    s->x = s->u + (s->x - s->u) * exp(-s->k * h);
#endif
#if defined DEFECT_DRIFT
    s->time += h;
#else
    s->time = time + h;
#endif
#if defined DEFECT_DISCARDS
    if (s->steps > 5)
        return fmi2Discard;
#endif
    if (at_end(self))
        return fmi2Discard;
    return isfinite(s->x) ? fmi2OK : refuse(self, "x is not finite");
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    (void)vr, (void)n, (void)order, (void)value;
    SELF;
    return refuse(self, "not offered");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[])
{
    (void)vr, (void)n, (void)order, (void)value;
    SELF;
    return refuse(self, "not offered");
}

fmi2Status fmi2CancelStep(fmi2Component c) { SELF; return refuse(self, "not offered"); }

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    ALLOW(STEP | ENDED);
    (void)kind;
    *value = self->s.time;
    return fmi2OK;
}

#define NO_STATUS(name, T)                                                                         \
    fmi2Status name(fmi2Component c, const fmi2StatusKind kind, T *value)                          \
    {                                                                                              \
        (void)c, (void)kind, (void)value;                                                          \
        return fmi2Discard;                                                                        \
    }
NO_STATUS(fmi2GetStatus, fmi2Status)
NO_STATUS(fmi2GetIntegerStatus, fmi2Integer)
NO_STATUS(fmi2GetStringStatus, fmi2String)

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    SELF;
    *value = kind == fmi2Terminated && at_end(self);
    return fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    SELF;
    if (!*state)
        *state = malloc(sizeof(State));
    memcpy(*state, &self->s, sizeof(State));
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    SELF;
#if defined DEFECT_STATE
    const double x = self->s.x;
#elif defined DEFECT_STATE_MODE
    const int mode = self->s.mode;
#endif
    memcpy(&self->s, state, sizeof(State));
#if defined DEFECT_STATE
    self->s.x = x;
#elif defined DEFECT_STATE_MODE
    self->s.mode = mode;
#endif
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    (void)c;
    free(*state);
    *state = NULL;
    return fmi2OK;
}

static const char MAGIC[8] = "bench 1";

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    (void)c, (void)state;
    *size = sizeof(State) + sizeof MAGIC;
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t n)
{
    (void)c, (void)n;
    memcpy(bytes, MAGIC, sizeof MAGIC);
    memcpy(bytes + sizeof MAGIC, state, sizeof(State));
#if defined DEFECT_SERIALIZE
    memset(bytes + sizeof MAGIC + offsetof(State, x), 0, sizeof(double));
#endif
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t n,
                                   fmi2FMUstate *state)
{
    SELF;
#if !defined DEFECT_ANY_BYTES
    if (n != sizeof(State) + sizeof MAGIC || memcmp(bytes, MAGIC, sizeof MAGIC) != 0)
        return refuse(self, "not a state of this FMU");
#endif
    State *made = calloc(1, sizeof(State));
    if (n == sizeof(State) + sizeof MAGIC)
        memcpy(made, bytes + sizeof MAGIC, sizeof(State));
    *state = made;
    return self ? fmi2OK : fmi2Error;
}

#if !defined DEFECT_MISSING_FUNCTION
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[],
                                        size_t n_unknown, const fmi2ValueReference known[],
                                        size_t n_known, const fmi2Real seed[], fmi2Real result[])
{
    ALLOW(INIT | RUNNING | ENDED);
    double du = 0, dx = 0;
    for (size_t i = 0; i < n_known; i++)
        *(known[i] == 1 ? &du : &dx) += seed[i];
    for (size_t i = 0; i < n_unknown; i++) {
        switch (unknown[i]) {
        case 3: result[i] = dx; break;
        case 4: result[i] = self->s.k * (du - dx); break;
        case 5: result[i] = du + 2 * dx; break;
        case 7: result[i] = 2 * self->s.x * dx; break;
        default: return refuse(self, "no such unknown");
        }
#if defined DEFECT_DERIVATIVE
        result[i] *= unknown[i] == 7 ? 1.01 : 1.0;
#endif
    }
    return fmi2OK;
}
#endif

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    ALLOW(EVENT | CONTINUOUS);
    self->s.mode = EVENT;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info)
{
    ALLOW(EVENT);
    memset(info, 0, sizeof *info);
    info->terminateSimulation = at_end(self);
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    ALLOW(EVENT);
    self->s.mode = CONTINUOUS;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_rollback, fmi2Boolean *event,
                                       fmi2Boolean *terminate)
{
    (void)no_rollback;
    ALLOW(CONTINUOUS);
    *event = fmi2False;
    *terminate = at_end(self);
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    ALLOW(EVENT | CONTINUOUS);
    self->s.time = time;
    return fmi2OK;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n)
{
    ALLOW(CONTINUOUS);
    if (n != 1)
        return refuse(self, "there is one state");
    self->s.x = x[0];
    return fmi2OK;
}

static fmi2Status one(Model *self, double value, fmi2Real to[], size_t n)
{
    if (n != 1)
        return refuse(self, "there is one state");
    to[0] = value;
    return fmi2OK;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real rates[], size_t n)
{
    SELF;
    return one(self, rate(self), rates, n);
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicators[], size_t n)
{
    (void)indicators;
    SELF;
    return n ? refuse(self, "there are no event indicators") : fmi2OK;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n)
{
    SELF;
    return one(self, self->s.x, x, n);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[], size_t n)
{
    SELF;
    return one(self, 1.0, nominals, n);
}
