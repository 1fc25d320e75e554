/* FMI 3.0: co-simulation steps, events, model exchange. */
#include "access.h"
#include "fmi3.h"

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    ALLOW3(EVENT | CONTINUOUS | STEP);
    if (self->s.interface == CO_SIMULATION && !self->event_mode_used) {
        report(self, STATUS_ERROR, "event mode was not asked for at instantiation");
        return fmi3Error;
    }
    return status3(enter_event_mode(self));
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance)
{
    ALLOW3(INITIALIZATION | EVENT);
    return status3(!(self->s.stale & OUTPUTS_STALE) || refresh_outputs(self));
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again,
                                    fmi3Boolean *terminate, fmi3Boolean *nominals_changed,
                                    fmi3Boolean *values_changed, fmi3Boolean *next_defined,
                                    fmi3Float64 *next_time)
{
    ALLOW3(EVENT);
    EventUpdate update;
    if (!update_discrete_states(self, &update))
        return fmi3Error;
    *again = update.again;
    *terminate = *nominals_changed = fmi3False;
    *values_changed = update.values_changed;
    *next_defined = update.next_defined;
    *next_time = update.next_time;
    return fmi3OK;
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    ALLOW3(EVENT);
    if (self->s.interface != CO_SIMULATION) {
        report(self, STATUS_ERROR, "step mode belongs to co-simulation");
        return fmi3Error;
    }
    self->s.mode = STEP;
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 h,
                      fmi3Boolean no_rollback, fmi3Boolean *event, fmi3Boolean *terminate,
                      fmi3Boolean *early, fmi3Float64 *reached)
{
    (void)no_rollback;
    ALLOW3(STEP);
    Progress progress;
    const bool stop_at_ticks = self->event_mode_used && self->early_return_allowed;
    const bool good = do_step(self, time, h, stop_at_ticks, &progress);
    *event = self->event_mode_used && progress.event;
    *terminate = fmi3False;
    *early = progress.early;
    *reached = progress.reached;
    return status3(good);
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,
                                    const fmi3Int32 orders[], fmi3Float64 values[],
                                    size_t n_values)
{
    (void)vr, (void)orders, (void)values, (void)n_values;
    ALLOW3(STEP | TERMINATED | FAILED);
    if (n == 0)
        return fmi3OK;
    report(self, STATUS_ERROR, "derivatives of outputs are not offered");
    return fmi3Error;
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    ALLOW3(EVENT);
    if (self->s.interface != MODEL_EXCHANGE) {
        report(self, STATUS_ERROR, "continuous-time mode belongs to model exchange");
        return fmi3Error;
    }
    self->s.mode = CONTINUOUS;
    self->s.pending = false;
    return fmi3OK;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean no_rollback,
                                       fmi3Boolean *event, fmi3Boolean *terminate)
{
    (void)no_rollback;
    ALLOW3(CONTINUOUS);
    bool wanted;
    const bool good = completed_step(self, &wanted);
    *event = wanted;
    *terminate = fmi3False;
    return status3(good);
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    ALLOW3(CONTINUOUS | EVENT);
    return status3(set_time(self, time));
}

enum { EXCHANGE = INITIALIZATION | EVENT | CONTINUOUS | TERMINATED };

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 x[], size_t n)
{
    ALLOW3(CONTINUOUS);
    return status3(set_states(self, x, n));
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 rates[], size_t n)
{
    ALLOW3(EXCHANGE);
    return status3(get_rates(self, rates, n));
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 indicators[], size_t n)
{
    (void)indicators;
    ALLOW3(EXCHANGE);
    return status3(n == 0 || refuse_count(self, n, 0));
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 x[], size_t n)
{
    ALLOW3(EXCHANGE);
    return status3(get_states(self, x, n));
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[],
                                             size_t n)
{
    ALLOW3(INSTANTIATED | EXCHANGE);
    return status3(get_nominals(self, nominals, n));
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *count)
{
    ALLOW3(ANY_MODE);
    *count = 0;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *count)
{
    ALLOW3(ANY_MODE);
    *count = N_STATES;
    return fmi3OK;
}
