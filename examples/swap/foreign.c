/* A controller as an FMU of FMI 2.0 in plain C, made without any tool: law A of the line-of-sight
   paper. A value reference is the place of the variable in the struct; foreign.xml names them. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

typedef void (*Logger)(void *environment, const char *name, int status, const char *category,
                       const char *message, ...);
typedef struct { Logger log; } Callbacks; /* as far as it is needed */
typedef struct {
    double b12[3], b21[3], range, velocity[3], rate[3];                                /* 0..12 */
    double torque[3], force[3];                                                       /* 13..18 */
    double mass, rate_gain, velocity_gain, alignment_gain, range_gain, desired_range; /* 19..24 */
    Logger log;
    char name[64];
} Controller;
typedef unsigned Reference;
enum { OK, WARNING, DISCARD, ERROR };

static void evaluate(Controller *c)
{
    const double *p = c->b12, *q = c->b21;
    const double cosine = p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const double turn = q[j] * p[k] - q[k] * p[j];
        const double pull = c->range_gain * (c->range - c->desired_range) * p[i];
        const double swing = c->alignment_gain / c->range * (q[i] - cosine * p[i]);
        c->torque[i] = -c->rate_gain * c->rate[i] - c->alignment_gain * turn;
        c->force[i] = c->mass * (c->velocity_gain * c->velocity[i] + pull + swing);
    }
}

static void start(Controller *c)
{
    const double values[25] = {1, 0, 0, -1, 0, 0, 1, [19] = 1.0, 0.25, 0.025, 0.05, 0.001, 20.0};
    memcpy(c, values, sizeof values);
}

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                      const Callbacks *callbacks, int visible, int logging)
{
    Controller *c = malloc(sizeof *c);
    if (!c || strcmp(guid, "foreign")) {
        free(c);
        return NULL;
    }
    start(c);
    c->log = callbacks->log;
    strncpy(c->name, name, sizeof c->name - 1);
    c->name[sizeof c->name - 1] = 0;
    return c;
}
void fmi2FreeInstance(void *c) { free(c); }
int fmi2SetupExperiment(void *c, int tolerant, double tolerance, double start, int ends, double stop)
{
    return OK;
}
int fmi2EnterInitializationMode(void *c) { return OK; }
int fmi2ExitInitializationMode(void *c) { return OK; }
int fmi2Terminate(void *c) { return OK; }
int fmi2Reset(void *c) { start(c); return OK; }
int fmi2SetDebugLogging(void *c, int on, size_t count, const char *const categories[]) { return OK; }
int fmi2SetReal(void *c, const Reference *references, size_t count, const double *values)
{
    for (size_t i = 0; i < count; i++) ((double *)c)[references[i]] = values[i];
    return OK;
}
int fmi2GetReal(void *c, const Reference *references, size_t count, double *values)
{
    Controller *own = c;
    evaluate(own);
    for (size_t i = 0; i < count; i++) values[i] = ((double *)c)[references[i]];
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(values[i])) {
            own->log(NULL, own->name, ERROR, "logStatusError", "a value is not finite");
            return ERROR;
        }
    }
    return OK;
}
int fmi2DoStep(void *c, double time, double step, int final) { return OK; }

/* What the standard asks every FMU to have, and this one to refuse. */
#define REFUSED(function) int function(void) { return ERROR; }
REFUSED(fmi2GetInteger) REFUSED(fmi2SetInteger) REFUSED(fmi2GetBoolean) REFUSED(fmi2SetBoolean)
REFUSED(fmi2GetString) REFUSED(fmi2SetString) REFUSED(fmi2GetFMUstate) REFUSED(fmi2SetFMUstate)
REFUSED(fmi2FreeFMUstate) REFUSED(fmi2SerializedFMUstateSize) REFUSED(fmi2SerializeFMUstate)
REFUSED(fmi2DeSerializeFMUstate) REFUSED(fmi2GetDirectionalDerivative)
REFUSED(fmi2SetRealInputDerivatives) REFUSED(fmi2GetRealOutputDerivatives) REFUSED(fmi2CancelStep)
REFUSED(fmi2GetStatus) REFUSED(fmi2GetRealStatus) REFUSED(fmi2GetIntegerStatus)
REFUSED(fmi2GetBooleanStatus) REFUSED(fmi2GetStringStatus)
