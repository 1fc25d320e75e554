/* FMI 2.0: co-simulation steps and model exchange. */
#include "access.h"
#include "fmi2.h"

#include <math.h>

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real h, fmi2Boolean no_rollback)
{
    (void)no_rollback;
    ALLOW(STEP);
    Progress progress;
    return status(do_step(self, time, h, false, &progress));
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    ALLOW(STEP);
    for (size_t i = 0; i < n; i++) {
        if (!writable(self, vr[i], REAL, 1u << INPUT))
            return fmi2Error;
        if (order[i] != 1 && order[i] != 2) {
            report(self, STATUS_ERROR, "%s: derivative of order %d cannot be used, only 1 and 2",
                   model_names[vr[i]], order[i]);
            return fmi2Error;
        }
        if (!isfinite(value[i])) {
            report(self, STATUS_ERROR, "%s: derivative %g: must be finite", model_names[vr[i]],
                   value[i]);
            return fmi2Error;
        }
    }
    for (size_t i = 0; i < n; i++)
        (order[i] == 1 ? self->s.slope : self->s.curvature)[vr[i] - INPUTS] = value[i];
    self->s.extrapolated = self->s.extrapolated || n > 0;
    return fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[])
{
    (void)vr, (void)order, (void)value;
    ALLOW(STEP | TERMINATED | FAILED);
    if (n == 0)
        return fmi2OK;
    report(self, STATUS_ERROR, "derivatives of outputs are not offered");
    return fmi2Error;
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    ALLOW(ANY_MODE);
    report(self, STATUS_ERROR, "no step is under way: steps are complete when fmi2DoStep returns");
    return fmi2Error;
}

static fmi2Status no_status(Instance *self)
{
    report(self, STATUS_DISCARD, "no such status: steps are complete when fmi2DoStep returns");
    return fmi2Discard;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind, (void)value;
    ALLOW(STEP | TERMINATED | FAILED);
    return no_status(self);
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    ALLOW(STEP | TERMINATED | FAILED);
    if (kind != fmi2LastSuccessfulTime)
        return no_status(self);
    *value = self->s.v[0];
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind, (void)value;
    ALLOW(STEP | TERMINATED | FAILED);
    return no_status(self);
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    ALLOW(STEP | TERMINATED | FAILED);
    if (kind != fmi2Terminated)
        return no_status(self);
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    (void)kind, (void)value;
    ALLOW(STEP | TERMINATED | FAILED);
    return no_status(self);
}

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    ALLOW(EVENT | CONTINUOUS);
    return status(enter_event_mode(self));
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info)
{
    ALLOW(EVENT);
    EventUpdate update;
    if (!update_discrete_states(self, &update))
        return fmi2Error;
    info->newDiscreteStatesNeeded = update.again;
    info->terminateSimulation = fmi2False;
    info->nominalsOfContinuousStatesChanged = fmi2False;
    info->valuesOfContinuousStatesChanged = update.values_changed;
    info->nextEventTimeDefined = update.next_defined;
    info->nextEventTime = update.next_time;
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    ALLOW(EVENT);
    self->s.mode = CONTINUOUS;
    self->s.pending = false;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_rollback,
                                       fmi2Boolean *event, fmi2Boolean *terminate)
{
    (void)no_rollback;
    ALLOW(CONTINUOUS);
    bool wanted;
    const bool good = completed_step(self, &wanted);
    *event = wanted;
    *terminate = fmi2False;
    return status(good);
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    ALLOW(EVENT | CONTINUOUS);
    return status(set_time(self, time));
}

enum { EXCHANGE = INITIALIZATION | EVENT | CONTINUOUS | TERMINATED };

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n)
{
    ALLOW(CONTINUOUS);
    return status(set_states(self, x, n));
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real rates[], size_t n)
{
    ALLOW(EXCHANGE);
    return status(get_rates(self, rates, n));
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicators[], size_t n)
{
    (void)indicators;
    ALLOW(EXCHANGE);
    return status(n == 0 || refuse_count(self, n, 0));
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n)
{
    ALLOW(EXCHANGE);
    return status(get_states(self, x, n));
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[], size_t n)
{
    ALLOW(INSTANTIATED | EXCHANGE);
    return status(get_nominals(self, nominals, n));
}
