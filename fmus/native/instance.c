/* Life of an instance: creation, start values, initialisation, messages. */
#include "instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

static const double SHORTEST_PERIOD = 1e-6; /* s */
static const char *const CATEGORIES[] = {
    "logAll", "logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal"};

Instance *create(const char *name, const char *token, Interface interface,
                 void *(*allocate)(size_t, size_t), void (*release)(void *))
{
    if (!name || !*name || !token || strcmp(token, MODEL_TOKEN) != 0)
        return NULL;
    const size_t length = strlen(name) + 1;
    Instance *self = allocate ? allocate(1, sizeof(Instance) + length)
                              : calloc(1, sizeof(Instance) + length);
    if (!self)
        return NULL;
    memset(self, 0, sizeof(Instance));
    memcpy(self->name, name, length);
    self->allocate = allocate ? allocate : calloc;
    self->release = allocate && release ? release : free;
    self->s.interface = interface;
    to_start(self);
    return self;
}

const char *why_not_created(const char *name, const char *token)
{
    if (!name || !*name)
        return "an instance needs a name";
    if (!token || strcmp(token, MODEL_TOKEN) != 0)
        return "the GUID or token is not that of this FMU";
    return "no memory for an instance";
}

void to_start(Instance *self)
{
    const int32_t interface = self->s.interface;
    memset(&self->s, 0, sizeof(State));
    memcpy(self->s.v, model_start, sizeof model_start);
    self->s.interface = interface;
    self->s.stream = stream_of(self->name);
    self->s.mode = INSTANTIATED;
    self->s.stale = ALL_STALE;
}

bool enter_initialization(Instance *self, double start_time)
{
    if (!isfinite(start_time)) {
        report(self, STATUS_ERROR, "start time %g: must be finite", start_time);
        return false;
    }
    self->s.start_time = self->s.v[0] = start_time;
    self->s.tick = 0;
    self->s.pending = SAMPLE_PERIOD != 0; /* with a period of zero nothing ticks: see refresh_outputs */
    self->s.evaluated = false;
    self->s.stale = ALL_STALE;
    self->s.mode = INITIALIZATION;
    return true;
}

/* Shorter periods would tick for ever. */
static bool period_is_sound(Instance *self)
{
    if (period(self) == 0.0 || period(self) >= SHORTEST_PERIOD)
        return true;
    report(self, STATUS_ERROR, "sample_period = %g: must be 0 or at least %g", period(self),
           SHORTEST_PERIOD);
    return false;
}

bool exit_initialization(Instance *self, Mode next)
{
    const bool sound = period_is_sound(self); /* report all that is wrong */
    if (!requirements_hold(self) || !sound)
        return false;
    self->s.pending = period(self) > 0.0;
    self->s.evaluated = false;
    self->s.stale = ALL_STALE;
    self->s.proposal = SOLVER_STEP ? self->s.v[SOLVER_STEP] : 0.0;
    self->s.mode = next;
    return true;
}

bool allowed(Instance *self, const char *function, int modes)
{
    static const char *const NAMES[] = {
        "instantiated", "initialization mode", "event mode", "continuous-time mode", "step mode",
        "terminated", "failed"};
    if (self->s.mode & modes)
        return true;
    int index = 0;
    while (!(self->s.mode >> index & 1))
        index++;
    report(self, STATUS_ERROR, "%s is not allowed here (the instance is in state: %s)", function,
           NAMES[index]);
    return false;
}

void report(Instance *self, Severity severity, const char *format, ...)
{
    if (!self->logger || !(self->categories >> severity & 1))
        return;
    char message[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    self->emit(self, severity, CATEGORIES[severity], message);
}

bool choose_categories(Instance *self, bool on, size_t count, const char *const names[])
{
    unsigned chosen = count ? 0 : CATEGORY_ALL;
    for (size_t i = 0; i < count; i++) {
        unsigned found = 0;
        for (unsigned c = 0; names[i] && c < sizeof CATEGORIES / sizeof *CATEGORIES; c++)
            if (strcmp(names[i], CATEGORIES[c]) == 0)
                found = c ? 1u << c : CATEGORY_ALL;
        if (!found) {
            report(self, STATUS_ERROR, "there is no log category %s", names[i] ? names[i] : "");
            return false;
        }
        chosen |= found;
    }
    self->categories = on ? (count ? self->categories | chosen : CATEGORY_ALL)
                          : self->categories & ~chosen;
    return true;
}
