/* Reading and writing values by reference; the paths that every step takes, hence inline. */
#ifndef SIGHTLINE_ACCESS_H
#define SIGHTLINE_ACCESS_H

#include <math.h>

#include "instance.h"

/* The scalars behind a reference, up to date, or NULL with a message logged. */
static inline const double *readable(Instance *self, uint32_t reference, int type)
{
    if (reference >= N_VALUES || model_access[reference].extent == 0 ||
        model_access[reference].type != type) {
        refuse_read(self, reference, type);
        return NULL;
    }
    const Access access = model_access[reference];
    if (self->s.stale) {
        const bool port = access.kind == OUTPUT || (access.is_output && self->s.pending);
        if (port && (self->s.stale & OUTPUTS_STALE) && !refresh_outputs(self))
            return NULL;
        if (access.kind == DERIVATIVE && (self->s.stale & RATES_STALE) && !refresh_rates(self))
            return NULL;
    }
    return self->s.v + reference;
}

/* Kinds of variables that may be set in a mode, as bits. */
static inline unsigned settable_kinds(int mode)
{
    if (mode & (INSTANTIATED | INITIALIZATION))
        return 1u << INPUT | 1u << FIXED | 1u << TUNABLE | 1u << STATE | 1u << DISCRETE_STATE;
    return mode == CONTINUOUS ? 1u << INPUT : 1u << INPUT | 1u << TUNABLE;
}

/* Number of scalars to be written at a reference, or 0 with a message logged. */
static inline uint32_t writable(Instance *self, uint32_t reference, int type, unsigned kinds)
{
    if (reference >= N_VALUES || model_access[reference].extent == 0 ||
        model_access[reference].type != type || !(kinds >> model_access[reference].kind & 1)) {
        refuse_write(self, reference, type);
        return 0;
    }
    return model_access[reference].extent;
}

static inline bool write_value(Instance *self, uint32_t element, double value)
{
    const Limits limits = model_limits[element];
    if (!(value >= limits.min && value <= limits.max) || isinf(value))
        return refuse_value(self, element, value);
    self->s.v[element] = value;
    return true;
}

/* Bodies of the getters and setters of both standards, for one C type. */
#define GET_VALUES(self, references, n, type, values, n_values, ctype)                             \
    size_t at = 0;                                                                                 \
    for (size_t i = 0; i < (n); i++) {                                                             \
        const double *from = readable(self, (references)[i], type);                                \
        if (!from)                                                                                 \
            return false;                                                                          \
        const uint32_t extent = model_access[(references)[i]].extent;                              \
        if (at + extent > (n_values))                                                              \
            return refuse_count(self, n_values, at + extent);                                      \
        for (uint32_t j = 0; j < extent; j++)                                                      \
            (values)[at++] = (ctype)from[j];                                                       \
    }                                                                                              \
    return at == (n_values) || refuse_count(self, n_values, at);

#define SET_VALUES(self, references, n, type, values, n_values)                                    \
    const unsigned kinds = settable_kinds((self)->s.mode);                                         \
    size_t at = 0;                                                                                 \
    bool accepted = true;                                                                          \
    for (size_t i = 0; i < (n); i++) {                                                             \
        const uint32_t extent = writable(self, (references)[i], type, kinds);                      \
        if (!extent)                                                                               \
            return false;                                                                          \
        if (at + extent > (n_values))                                                              \
            return refuse_count(self, n_values, at + extent);                                      \
        for (uint32_t j = 0; j < extent; j++, at++)                                                \
            accepted &= write_value(self, (references)[i] + j, (double)(values)[at]);              \
        (self)->s.stale = ALL_STALE;                                                               \
    }                                                                                              \
    return (at == (n_values) || refuse_count(self, n_values, at)) && accepted;

#endif
