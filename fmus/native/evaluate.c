/* Outputs, rates and ticks from the block's equations, when something that they use has changed. */
#include "instance.h"

#include <math.h>

bool all_finite(const double *values, int count)
{
    for (int i = 0; i < count; i++)
        if (!isfinite(values[i]))
            return false;
    return true;
}

/* Report the first value that is not finite; `first` is the reference of values[0]. */
bool name_not_finite(Instance *self, const double *values, int count, int first)
{
    for (int i = 0; i < count; i++)
        if (!isfinite(values[i])) {
            report(self, STATUS_ERROR, "%s is not finite at time %.9g s", model_names[first + i],
                   self->s.v[0]);
            return true;
        }
    return false;
}

static bool evaluate_outputs(Instance *self, const double *noise)
{
    if (!N_OUTPUTS)
        return true;
    double fresh[SOME(N_OUTPUTS)];
    model_outputs(self->s.v, noise, fresh);
    if (!all_finite(fresh, N_OUTPUTS)) {
        name_not_finite(self, fresh, N_OUTPUTS, OUTPUTS);
        return false;
    }
    memcpy(self->s.v + OUTPUTS, fresh, N_OUTPUTS * sizeof(double));
    return true;
}

bool evaluate_tick(Instance *self)
{
    self->s.evaluated = false;
    if (N_NOISE)
        draw_noise(self);
    if (!evaluate_outputs(self, self->s.noise))
        return false;
    if (N_DISCRETE) {
        model_update(self->s.v, self->s.noise, self->s.next_discrete);
        if (!all_finite(self->s.next_discrete, N_DISCRETE)) {
            name_not_finite(self, self->s.next_discrete, N_DISCRETE, DISCRETE);
            return false;
        }
    }
    self->s.evaluated = true;
    return true;
}

/* Outputs of the present instant: those of the pending tick, the held ones between ticks, or
   those of now if the block acts continuously. */
bool refresh_outputs(Instance *self)
{
    if (!(period(self) > 0.0)) {
        if (!evaluate_outputs(self, NULL))
            return false;
    } else if (self->s.pending && !evaluate_tick(self))
        return false;
    self->s.stale &= ~OUTPUTS_STALE;
    return true;
}

bool refresh_rates(Instance *self)
{
    if (!N_STATES)
        return true;
    double *v = self->s.v, rates[SOME(N_STATES)];
    model_derivatives(v[0], v, v + STATES, rates);
    if (!all_finite(rates, N_STATES)) {
        name_not_finite(self, rates, N_STATES, DERIVATIVES);
        return false;
    }
    memcpy(v + DERIVATIVES, rates, N_STATES * sizeof(double));
    self->s.stale &= ~RATES_STALE;
    return true;
}

/* Make a pending tick final: an evaluation that has been read stands. */
bool depart(Instance *self)
{
    if (!self->s.pending)
        return true;
    if (!self->s.evaluated && !evaluate_tick(self))
        return false;
    if (N_DISCRETE)
        memcpy(self->s.v + DISCRETE, self->s.next_discrete, N_DISCRETE * sizeof(double));
    self->s.tick++;
    self->s.pending = self->s.evaluated = false;
    self->s.stale = ALL_STALE;
    return true;
}

bool requirements_hold(Instance *self)
{
    if (!N_REQUIREMENTS)
        return true;
    double holds[SOME(N_REQUIREMENTS)];
    bool all = true;
    model_require(self->s.v, holds);
    for (int i = 0; i < N_REQUIREMENTS; i++)
        if (!(holds[i] != 0.0)) {
            report(self, STATUS_ERROR, "%s (time %.9g s)", model_requirements[i], self->s.v[0]);
            all = false;
        }
    return all;
}
