/* Directional and adjoint derivatives of outputs and rates by inputs and states.

   Time, inputs, parameters, states and discrete states stand first in the array of values: seeds
   and sensitivities with respect to them are one vector of N_KNOWNS. */
#include "access.h"

typedef struct {
    const uint32_t *references;
    size_t count;
} Variables;

/* Total number of scalars, or -1 with a message logged if one of the variables is of no use. */
static long elements(Instance *self, Variables variables, bool knowns)
{
    long total = 0;
    for (size_t i = 0; i < variables.count; i++) {
        const uint32_t r = variables.references[i];
        if (r >= N_VALUES || model_access[r].extent == 0 || model_access[r].type != REAL) {
            refuse_read(self, r, REAL);
            return -1;
        }
        const int kind = model_access[r].kind;
        const bool known = r < N_KNOWNS && kind != FIXED && kind != TUNABLE;
        const bool unknown = kind == DERIVATIVE || model_access[r].is_output;
        if (knowns ? !known : !unknown) {
            report(self, STATUS_ERROR, "%s cannot be %s of a partial derivative", model_names[r],
                   knowns ? "a known" : "an unknown");
            return -1;
        }
        total += model_access[r].extent;
    }
    return total;
}

static bool sizes_fit(Instance *self, Variables unknowns, Variables knowns, size_t n_unknown,
                      size_t n_known)
{
    if (!HAS_SENSITIVITIES) {
        report(self, STATUS_ERROR, "this block offers no partial derivatives");
        return false;
    }
    const long u = elements(self, unknowns, false), k = u < 0 ? -1 : elements(self, knowns, true);
    if (u < 0 || k < 0)
        return false;
    if ((size_t)u != n_unknown)
        return refuse_count(self, n_unknown, (size_t)u);
    return (size_t)k == n_known || refuse_count(self, n_known, (size_t)k);
}

static void scatter(Variables variables, const double *from, double *values)
{
    for (size_t i = 0; i < variables.count; i++)
        for (uint32_t j = 0; j < model_access[variables.references[i]].extent; j++)
            values[variables.references[i] + j] += *from++;
}

static void gather(Variables variables, const double *values, double *to)
{
    for (size_t i = 0; i < variables.count; i++)
        for (uint32_t j = 0; j < model_access[variables.references[i]].extent; j++)
            *to++ = values[variables.references[i] + j];
}

static bool wanted(Variables unknowns, int kind)
{
    for (size_t i = 0; i < unknowns.count; i++)
        if (model_access[unknowns.references[i]].kind == kind)
            return true;
    return false;
}

/* Outputs that are held between ticks depend on nothing. */
static bool outputs_act(const Instance *self)
{
    return !(period(self) > 0.0) || self->s.pending;
}

static bool finite_result(Instance *self, const double *result, size_t count)
{
    if (all_finite(result, (int)count))
        return true;
    report(self, STATUS_ERROR, "a partial derivative is not finite at time %.9g s", self->s.v[0]);
    return false;
}

bool directional_derivative(Instance *self, const uint32_t *unknowns, size_t n_unknowns,
                            const uint32_t *knowns, size_t n_knowns, const double *seed,
                            size_t n_seed, double *result, size_t n_result)
{
    const Variables u = {unknowns, n_unknowns}, k = {knowns, n_knowns};
    if (!sizes_fit(self, u, k, n_result, n_seed))
        return false;
    double d[N_VALUES] = {0.0};
    scatter(k, seed, d);
    if (wanted(u, OUTPUT) && outputs_act(self)) {
        if ((self->s.stale & OUTPUTS_STALE) && !refresh_outputs(self))
            return false;
        model_outputs_forward(self->s.v, self->s.noise, d, d + OUTPUTS);
    }
    if (wanted(u, DERIVATIVE))
        model_derivatives_forward(self->s.v, d, d + DERIVATIVES);
    gather(u, d, result);
    return finite_result(self, result, n_result);
}

bool adjoint_derivative(Instance *self, const uint32_t *unknowns, size_t n_unknowns,
                        const uint32_t *knowns, size_t n_knowns, const double *seed,
                        size_t n_seed, double *result, size_t n_result)
{
    const Variables u = {unknowns, n_unknowns}, k = {knowns, n_knowns};
    if (!sizes_fit(self, u, k, n_seed, n_result))
        return false;
    double bar[N_VALUES] = {0.0}, sum[N_VALUES];
    scatter(u, seed, bar);
    memcpy(sum, bar, sizeof sum); /* outputs that are states: the identity */
    if (wanted(u, OUTPUT) && outputs_act(self)) {
        if ((self->s.stale & OUTPUTS_STALE) && !refresh_outputs(self))
            return false;
        double part[N_KNOWNS];
        model_outputs_reverse(self->s.v, self->s.noise, bar + OUTPUTS, part);
        for (int i = 0; i < N_KNOWNS; i++)
            sum[i] += part[i];
    }
    if (wanted(u, DERIVATIVE)) {
        double part[N_KNOWNS];
        model_derivatives_reverse(self->s.v, bar + DERIVATIVES, part);
        for (int i = 0; i < N_KNOWNS; i++)
            sum[i] += part[i];
    }
    gather(k, sum, result);
    return finite_result(self, result, n_result);
}
