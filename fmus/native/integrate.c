/* Integration of the continuous states over an interval without events.

   Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.1 and II.5. */
#include "instance.h"

#include <math.h>

enum { RK4 = 1 };
typedef double Rates[SOME(N_STATES)];

static const double NODES[7] = {0.0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1.0, 1.0};
static const double STAGES[7][6] = {
    {0.0},
    {1.0 / 5},
    {3.0 / 40, 9.0 / 40},
    {44.0 / 45, -56.0 / 15, 32.0 / 9},
    {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
    {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
    {35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84},
};
static const double ERROR_WEIGHTS[7] = {71.0 / 57600,      0.0,         -71.0 / 16695, 71.0 / 1920,
                                        -17253.0 / 339200, 22.0 / 525, -1.0 / 40};
static const double SAFETY = 0.9, SHRINK = 0.2, GROW = 5.0;

/* Inputs of the coming step follow base + slope τ + curvature τ²/2, if derivatives were given. */
void extrapolate_inputs(Instance *self, double time)
{
    const double tau = time - self->s.base_time;
    for (int i = 0; i < N_INPUTS; i++)
        self->s.v[INPUTS + i] =
            self->s.base[i] + tau * (self->s.slope[i] + 0.5 * tau * self->s.curvature[i]);
}

static inline void rate(Instance *self, double t, const double *x, double *k)
{
    if (self->s.extrapolated)
        extrapolate_inputs(self, t);
    model_derivatives(t, self->s.v, x, k);
}

/* Take the new states unless they are not finite: then say which rate or state. */
static bool accept(Instance *self, double t, const double *x, Rates *k, int stages)
{
    double moved[SOME(N_STATES)];
    const double *taken = x;
    bool good = all_finite(x, N_STATES);
    if (good && HAS_PROJECT) {
        model_project(t, self->s.v, x, moved);
        taken = moved;
        good = all_finite(taken, N_STATES);
    }
    if (good) {
        memcpy(self->s.v + STATES, taken, N_STATES * sizeof(double));
        return true;
    }
    for (int i = 0; i < stages; i++)
        if (name_not_finite(self, k[i], N_STATES, DERIVATIVES))
            return false;
    name_not_finite(self, taken, N_STATES, STATES);
    return false;
}

static bool rk4(Instance *self, double t, double h)
{
    const double *x = self->s.v + STATES;
    Rates k[4], stage;
    const double count = fmax(1.0, ceil(h / self->s.v[SOLVER_STEP] - 1e-9));
    const double dt = h / count, half = 0.5 * dt, sixth = dt / 6.0;
    for (double i = 0.0; i < count; i += 1.0) {
        const double s = t + i * dt;
        rate(self, s, x, k[0]);
        for (int j = 0; j < N_STATES; j++)
            stage[j] = x[j] + half * k[0][j];
        rate(self, s + half, stage, k[1]);
        for (int j = 0; j < N_STATES; j++)
            stage[j] = x[j] + half * k[1][j];
        rate(self, s + half, stage, k[2]);
        for (int j = 0; j < N_STATES; j++)
            stage[j] = x[j] + dt * k[2][j];
        rate(self, s + dt, stage, k[3]);
        for (int j = 0; j < N_STATES; j++)
            stage[j] = x[j] + sixth * (k[0][j] + 2.0 * k[1][j] + 2.0 * k[2][j] + k[3][j]);
        if (!accept(self, s + dt, stage, k, 4))
            return false;
    }
    return true;
}

/* One trial step from t to t + dt: the new states in `stage`; returns the norm of the error. */
static double trial_step(Instance *self, double t, double dt, bool first_rate_known, Rates *k,
                         double *stage)
{
    const double *x = self->s.v + STATES;
    const double relative = self->s.v[RELATIVE_TOLERANCE];
    const double absolute = self->s.v[ABSOLUTE_TOLERANCE];
    for (int s = first_rate_known; s < 7; s++) {
        for (int j = 0; j < N_STATES; j++) {
            double value = x[j];
            for (int i = 0; i < s; i++)
                value += dt * STAGES[s][i] * k[i][j];
            stage[j] = value;
        }
        rate(self, t + NODES[s] * dt, stage, k[s]);
    }
    double sum = 0.0;
    for (int j = 0; j < N_STATES; j++) {
        double error = 0.0;
        for (int i = 0; i < 7; i++)
            error += dt * ERROR_WEIGHTS[i] * k[i][j];
        error /= absolute + relative * fmax(fabs(x[j]), fabs(stage[j]));
        sum += error * error;
    }
    return sqrt(sum / SOME(N_STATES));
}

static bool underflow(Instance *self, double t, double dt, Rates *k)
{
    for (int i = 0; i < 7; i++)
        if (name_not_finite(self, k[i], N_STATES, DERIVATIVES))
            return false;
    report(self, STATUS_ERROR, "tolerances cannot be met: step size %.3g s at %.9g s", dt, t);
    return false;
}

static bool dormand_prince(Instance *self, double t, double h)
{
    const double end = t + h;
    Rates k[7] = {{0.0}}, stage;
    bool rejected = false;
    while (t < end) {
        const double smallest = 1e-14 * fmax(fabs(t), 1e-3);
        const bool cut = t + self->s.proposal >= end;
        const double dt = cut ? end - t : self->s.proposal;
        if (!cut && !(dt > smallest))
            return underflow(self, t, dt, k);
        const double norm = trial_step(self, t, dt, rejected, k, stage);
        const double wish = norm == 0.0 ? GROW : SAFETY * pow(norm, -0.2);
        const double factor = fmin(GROW, fmax(SHRINK, wish));
        if (norm <= 1.0) {
            const double next = dt * (rejected ? fmin(factor, 1.0) : factor);
            t = cut ? end : t + dt;
            if (!accept(self, t, stage, k, 7))
                return false;
            self->s.proposal = cut ? fmax(self->s.proposal, next) : next;
            rejected = false;
        } else {
            self->s.proposal = dt * fmin(factor, 1.0);
            rejected = true;
            if (!isfinite(norm) || self->s.proposal < smallest)
                return underflow(self, t, self->s.proposal, k);
        }
    }
    return true;
}

/* From the present time to `end`. */
bool integrate(Instance *self, double end)
{
    const double start = self->s.v[0], h = end - start;
    if (N_STATES && h > 0.0) {
        const bool done = self->s.v[SOLVER] == RK4 ? rk4(self, start, h)
                                                   : dormand_prince(self, start, h);
        if (!done)
            return false;
    }
    self->s.v[0] = end;
    if (self->s.extrapolated)
        extrapolate_inputs(self, end);
    return true;
}
