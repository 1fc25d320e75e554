/* Ticks of a sampled block, as time events, and the modes around events. */
#include "instance.h"

#include <math.h>

static const double TICK_TOLERANCE = 1e-9;      /* of the period */
static const double PROJECTION_TOLERANCE = 1e-9; /* drift that model exchange corrects */

double period(const Instance *self)
{
    return SAMPLE_PERIOD ? self->s.v[SAMPLE_PERIOD] : 0.0;
}

/* Of the next tick, or of the pending one: by multiplication, so that nothing accumulates. */
double tick_time(const Instance *self)
{
    return self->s.start_time + (double)self->s.tick * period(self);
}

double tick_tolerance(const Instance *self, double time)
{
    const double size = fabs(time);
    return TICK_TOLERANCE * period(self) + 4.0 * (nextafter(size, INFINITY) - size);
}

static bool tick_is_due(const Instance *self)
{
    const double now = self->s.v[0];
    return period(self) > 0.0 && tick_time(self) <= now + tick_tolerance(self, now);
}

bool enter_event_mode(Instance *self)
{
    self->s.mode = EVENT;
    self->s.pending = tick_is_due(self);
    self->s.evaluated = false;
    self->s.stale = ALL_STALE;
    return !CHECKED_AT_STEPS || requirements_hold(self);
}

/* States moved back to their manifold, and whether they had drifted from it. */
static bool project_states(Instance *self, double *moved)
{
    if (!HAS_PROJECT)
        return false;
    double *x = self->s.v + STATES;
    model_project(self->s.v[0], self->s.v, x, moved);
    bool drifted = false;
    for (int i = 0; i < N_STATES; i++)
        drifted |= fabs(moved[i] - x[i]) > PROJECTION_TOLERANCE * fmax(1.0, fabs(x[i]));
    return drifted;
}

bool completed_step(Instance *self, bool *event)
{
    double moved[SOME(N_STATES)];
    *event = project_states(self, moved);
    return !CHECKED_AT_STEPS || requirements_hold(self);
}

bool update_discrete_states(Instance *self, EventUpdate *update)
{
    if (self->s.pending) {
        if (self->s.stale & OUTPUTS_STALE)  /* inputs have changed: evaluate with them */
            self->s.evaluated = false;
        if (!depart(self))
            return false;
        self->s.pending = tick_is_due(self);
    }
    double moved[SOME(N_STATES)];
    update->values_changed = project_states(self, moved);
    if (update->values_changed) {
        memcpy(self->s.v + STATES, moved, N_STATES * sizeof(double));
        self->s.stale = ALL_STALE;
    }
    update->again = self->s.pending;
    update->next_defined = period(self) > 0.0;
    update->next_time = update->next_defined ? tick_time(self) : 0.0;
    return true;
}
