/* Model exchange: time, states and rates in the hands of the environment. */
#include "instance.h"

#include <math.h>

bool set_time(Instance *self, double time)
{
    if (!isfinite(time)) {
        report(self, STATUS_ERROR, "time %g: must be finite", time);
        return false;
    }
    self->s.v[0] = time;
    self->s.stale = ALL_STALE;
    return true;
}

static bool count_fits(Instance *self, size_t n)
{
    return n == N_STATES || refuse_count(self, n, N_STATES);
}

bool set_states(Instance *self, const double *x, size_t n)
{
    if (!count_fits(self, n) || name_not_finite(self, x, (int)n, STATES))
        return false;
    memcpy(self->s.v + STATES, x, n * sizeof(double));
    self->s.stale = ALL_STALE;
    return true;
}

bool get_states(Instance *self, double *x, size_t n)
{
    if (!count_fits(self, n))
        return false;
    memcpy(x, self->s.v + STATES, n * sizeof(double));
    return true;
}

bool get_rates(Instance *self, double *rates, size_t n)
{
    if (!count_fits(self, n) || ((self->s.stale & RATES_STALE) && !refresh_rates(self)))
        return false;
    memcpy(rates, self->s.v + DERIVATIVES, n * sizeof(double));
    return true;
}

bool get_nominals(Instance *self, double *nominals, size_t n)
{
    if (!count_fits(self, n))
        return false;
    memcpy(nominals, model_nominal, n * sizeof(double));
    return true;
}
