/* Reading and writing values by reference; the paths that every step takes, hence inline. */
#ifndef SIGHTLINE_ACCESS_H
#define SIGHTLINE_ACCESS_H

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

/* Whether a variable may be set now; if not, a message is logged. */
static inline bool writable(Instance *self, uint32_t reference, int type, unsigned kinds)
{
    if (reference < N_VALUES && model_access[reference].extent != 0 &&
        model_access[reference].type == type && (kinds >> model_access[reference].kind & 1))
        return true;
    return refuse_write(self, reference, type);
}

/* A value that is not finite is out of every range. */
static inline bool in_range(uint32_t element, double value)
{
    return value >= model_limits[element].min && value <= model_limits[element].max;
}

static inline bool write_value(Instance *self, uint32_t element, double value)
{
    if (!in_range(element, value))
        return refuse_value(self, element, value);
    self->s.v[element] = value;
    return true;
}

/* Write values side by side; those that are not acceptable leave the old ones. The first loop has
   no branch: it finds out whether clipping, which also replaces a NaN, would change a bit. */
static inline bool write_values(Instance *self, uint32_t first, const double *values, size_t n)
{
    const Limits *limits = model_limits + first;
    uint64_t changed = 0;
    for (size_t j = 0; j < n; j++) {
        double clipped = values[j] > limits[j].min ? values[j] : limits[j].min;
        clipped = clipped < limits[j].max ? clipped : limits[j].max;
        uint64_t before, after;
        memcpy(&before, values + j, sizeof before);
        memcpy(&after, &clipped, sizeof after);
        changed |= before ^ after;
    }
    if (!changed) {
        memcpy(self->s.v + first, values, n * sizeof(double));
        return true;
    }
    bool accepted = true;
    for (size_t j = 0; j < n; j++)
        accepted &= write_value(self, first + (uint32_t)j, values[j]);
    return accepted;
}

/* How many of the references follow each other like the scalars behind them: all or one. */
static inline uint32_t consecutive(const uint32_t *references, size_t n)
{
    const uint32_t run = model_access[references[0]].run, limit = n < run ? (uint32_t)n : run;
    uint32_t gaps = 0;
    for (uint32_t k = 1; k < limit; k++)
        gaps |= references[k] - references[0] - k;
    return gaps ? 1 : limit;
}

/* Bodies of the getters and setters of both standards, for one C type. `taken` references that
   follow each other, or the elements of one array variable, are `count` scalars side by side. */
#define GET_VALUES(self, references, n, type, values, n_values, ctype)                             \
    size_t at = 0;                                                                                 \
    for (size_t i = 0, taken; i < (n); i += taken) {                                               \
        const double *from = readable(self, (references)[i], type);                                \
        if (!from)                                                                                 \
            return false;                                                                          \
        taken = consecutive((references) + i, (n) - i);                                            \
        const size_t extent = model_access[(references)[i]].extent;                                \
        const size_t count = extent > taken ? extent : taken;                                      \
        if (at + count > (n_values))                                                               \
            return refuse_count(self, n_values, at + count);                                       \
        if ((type) == REAL)                                                                        \
            memcpy((values) + at, from, count * sizeof(double));                                   \
        else                                                                                       \
            for (size_t j = 0; j < count; j++)                                                     \
                (values)[at + j] = (ctype)from[j];                                                 \
        at += count;                                                                               \
    }                                                                                              \
    return at == (n_values) || refuse_count(self, n_values, at);

#define SET_VALUES(self, references, n, type, values, n_values)                                    \
    const unsigned kinds = settable_kinds((self)->s.mode);                                         \
    size_t at = 0;                                                                                 \
    bool accepted = true;                                                                          \
    for (size_t i = 0, taken; i < (n); i += taken) {                                               \
        const uint32_t first = (references)[i];                                                    \
        if (!writable(self, first, type, kinds))                                                   \
            return false;                                                                          \
        taken = consecutive((references) + i, (n) - i);                                            \
        const size_t extent = model_access[first].extent;                                          \
        const size_t count = extent > taken ? extent : taken;                                      \
        if (at + count > (n_values))                                                               \
            return refuse_count(self, n_values, at + count);                                       \
        if ((type) == REAL)                                                                        \
            accepted &= write_values(self, first, (const double *)(const void *)((values) + at),   \
                                     count);                                                       \
        else                                                                                       \
            for (uint32_t j = 0; j < count; j++)                                                   \
                accepted &= write_value(self, first + j, (type) == BOOLEAN                         \
                                                             ? (double)((values)[at + j] != 0)     \
                                                             : (double)(values)[at + j]);          \
        at += count;                                                                               \
        (self)->s.stale = ALL_STALE;                                                               \
    }                                                                                              \
    return (at == (n_values) || refuse_count(self, n_values, at)) && accepted;

#endif
