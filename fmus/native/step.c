/* A communication step: ticks that fall into it, integration between them. */
#include "instance.h"

#include <math.h>

static bool begin(Instance *self, double time, double h)
{
    const double now = self->s.v[0];
    const double tolerance = 1e-9 * fmax(1.0, fmax(fabs(time), fabs(now)));
    if (!(h >= 0.0) || !isfinite(h) || !(fabs(time - now) <= tolerance)) {
        report(self, STATUS_ERROR, "step from %.9g s by %.9g s, internal time is %.9g s", time, h,
               now);
        return false;
    }
    if (self->s.stop_defined && time + h > self->s.stop_time + tolerance) {
        report(self, STATUS_ERROR, "step to %.9g s goes past the stop time %.9g s", time + h,
               self->s.stop_time);
        return false;
    }
    if (self->s.extrapolated) {
        memcpy(self->s.base, self->s.v + INPUTS, N_INPUTS * sizeof(double));
        self->s.base_time = now;
    }
    return true;
}

/* Arrive at a tick: it is pending from now on. */
static void arrive(Instance *self)
{
    self->s.pending = true;
    self->s.evaluated = false;
    self->s.stale = ALL_STALE;
}

static bool advance(Instance *self, double end, bool stop_at_ticks, Progress *progress)
{
    if (!depart(self))
        return false;
    if (period(self) > 0.0) {
        const double near = tick_tolerance(self, end);
        for (double at = tick_time(self); at < end - near; at = tick_time(self)) {
            if (!integrate(self, at))
                return false;
            arrive(self);
            if (stop_at_ticks) {
                *progress = (Progress){at, true, true};
                return true;
            }
            if (!depart(self))
                return false;
        }
        if (!integrate(self, end))
            return false;
        if (tick_time(self) <= end + near)
            arrive(self);
    } else if (!integrate(self, end))
        return false;
    *progress = (Progress){end, self->s.pending, false};
    return true;
}

/* Go from `time` to `time + h`, or to the first tick inside if so wished. */
bool do_step(Instance *self, double time, double h, bool stop_at_ticks, Progress *progress)
{
    *progress = (Progress){self->s.v[0], false, false};
    if (!begin(self, time, h))
        return false;
    const bool done = advance(self, time + h, stop_at_ticks, progress);
    self->s.stale = ALL_STALE;
    if (self->s.extrapolated) {
        memset(self->s.slope, 0, sizeof self->s.slope);
        memset(self->s.curvature, 0, sizeof self->s.curvature);
        self->s.extrapolated = false;
    }
    if (!done || (CHECKED_AT_STEPS && !requirements_hold(self))) {
        progress->reached = self->s.v[0];
        self->s.mode = FAILED;
        return false;
    }
    return true;
}
